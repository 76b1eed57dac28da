// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/frame.hpp"
#include "bench/world/se3.hpp"

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

// Max-logDet where matches of a group share an error: those of an image patch that moved together, or the points that
// one keyframe mapped. The error of match i of group g is e_i + b_g, e_i ~ N(0, Sigma_i) its own and b_g ~ N(0, tau^2
// I) the group's, (u, v), px; the right-image column shares that of u. With rows H_i = L_i^-1 H_x and N_i = L_i^-1 [1
// 0; 0 1; 1 0], L_i L_i^T = Sigma_i, and every b_g marginalised, the information about the pose is
//
//   M = M0 + sum_g (A_g - B_g C_g^-1 B_g^T),   A_g = sum H_i^T H_i,  B_g = sum H_i^T N_i,  C_g = I / tau^2 + sum N_i^T
//   N_i
//
// over the selected matches of each group.

namespace maxlogdet::sim {

/// A match's rows, whitened by its own noise. Rows beyond `rows` are zero.
struct WhitenedMatch {
  int rows = 0;                   ///< 2 monocular, 3 stereo; 0: no candidate
  Eigen::Matrix<double, 3, 6> H;  ///< of the pose, left perturbation
  Eigen::Matrix<double, 3, 2> N;  ///< of the error of its group, 1/px
};

/// Match i of the frame at frame.T_cw_prior, whitened (whitening_of()) as `options` make its block (measurement or
/// measurement_and_map, a third row of none or stereo); 3 x 3 row-major `map_covariance`: Sigma_p, m^2, or nullptr for
/// options.map_sigma^2 I. A match of which append_blocks would make an invalid candidate has 0 rows.
WhitenedMatch whiten(const Frame& frame, std::size_t i, const BlockOptions& options, const double* map_covariance);

/// M, and the gains of matches. b_g is tracked as by a Kalman filter: given the pose, its mean is -Q_g xi,
/// Q_g = C_g^-1 B_g^T, with covariance P_g = C_g^-1. A further match of the group then adds a block of its own,
///   G^T S^-1 G,  G = H - N Q_g,  S = I + N P_g N^T,
/// which is the difference of M before and after it. tau = 0 is no special case: P_g and Q_g stay 0.
class SharedInformation {
 public:
  /// Unselects all: M = prior, symmetric positive definite. tau: px, at least 0.
  void reset(std::size_t groups, double tau, const Matrix6& prior);

  /// Returns log det M with the match less log det M without.
  double gain(const WhitenedMatch& match, std::size_t group) const;
  void add(const WhitenedMatch& match, std::size_t group);

  Matrix6 matrix() const { return factor_.transpose() * factor_; }

 private:
  struct Group {
    Eigen::Matrix2d P;
    Eigen::Matrix<double, 2, 6> Q;
  };

  std::vector<Group> groups_;
  Matrix6 factor_ = Matrix6::Identity();          // upper triangular R, R^T R = M
  Matrix6 inverse_factor_ = Matrix6::Identity();  // R^-1
};

/// Greedy on log det M. A gain can only fall when a match of another group is selected, because M grows and nothing
/// else changes, but it can rise when one of the same group is, because b_g is then better known. So the objective is
/// not submodular, and greedy has no (1 - 1/e) guarantee; but the last gain of a candidate is an upper bound until a
/// match of its group is selected, and lazy evaluation that discards the bounds of that group has greedy's answer. On
/// 160 searches for 40 of 200 matches (a test counts): 1.8 % of the gains rise from one round to the next, all of them
/// in the group of the last match; 30 % of them are evaluated; lazy evaluation that discards no bound has another
/// answer in half of the searches, at worst 0.7 nats short (0.3 on other draws: a maximum varies).
class SharedErrorSelection {
 public:
  /// Writes the indices of at most `budget` matches in the order in which greedy selects them; ties go to the lowest
  /// index. `groups`: for each match one below `group_count`. Allocates nothing after a problem as large.
  void select(const std::vector<WhitenedMatch>& matches, const std::vector<std::uint32_t>& groups,
              std::size_t group_count, double tau, const Matrix6& prior, std::size_t budget,
              std::vector<std::uint32_t>& selected);

  /// Returns how many gains the last call evaluated.
  std::size_t evaluations() const { return evaluations_; }

 private:
  struct Candidate {
    std::uint32_t match;
    double bound;  // of its gain
  };

  std::size_t best_of_round(const std::vector<WhitenedMatch>& matches, const std::vector<std::uint32_t>& groups);

  SharedInformation information_;
  std::vector<Candidate> remaining_;  // by match
  std::size_t evaluations_ = 0;
};

}  // namespace maxlogdet::sim
