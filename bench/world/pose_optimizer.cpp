// SPDX-License-Identifier: MIT
#include "bench/world/pose_optimizer.hpp"

#include "bench/world/pose_equations.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>

namespace maxlogdet::sim {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr std::size_t min_matches = 3;  // 6 rows

// With the diagonal scaled to 1, a direction whose undamped pivot is not above this is unobserved: sums of 2000 matches
// round to some 1e-14.
constexpr double min_pivot = 1e-13;

// Levenberg-Marquardt adds lambda diag to the normal equations. lambda starts almost at Gauss-Newton, falls tenfold
// with each accepted step, and grows tenfold, to at least 0.01, with each rejected one.
constexpr double first_damping = 1e-6;
constexpr double min_damping_after_rise = 1e-2;

// A symmetric matrix with its diagonal scaled to 1, so that metres and radians are comparable.
struct Scaled {
  explicit Scaled(const Matrix6& A) : scale(A.diagonal().array().sqrt().inverse()) {
    matrix = scale.asDiagonal() * A * scale.asDiagonal();
    is_regular = matrix.allFinite() && A.allFinite() && factorize(0);
  }

  // Factorises A + damping diag(A).
  bool factorize(double damping) {
    Matrix6 damped = matrix;
    damped.diagonal().array() += damping;
    factor.compute(damped);
    if (factor.info() != Eigen::Success) return false;
    const Vector6 diagonal = factor.matrixLLT().diagonal();
    return (diagonal.array().square() > min_pivot).all();
  }

  Vector6 solve(const Vector6& b) const { return scale.asDiagonal() * factor.solve(Vector6(scale.asDiagonal() * b)); }

  Vector6 scale;
  Matrix6 matrix;
  Eigen::LLT<Matrix6> factor;
  bool is_regular = false;
};

struct Linearization {
  Linearization(const PoseProblem& problem, const Pose& at)
      : T_cw(at), sums(add_up(problem, at)), equations(to_matrix(sums)) {}

  bool is_regular() const { return sums.used >= min_matches && equations.is_regular && std::isfinite(sums.rho); }

  bool solve(double damping, Vector6& step) {
    if (!is_regular() || !equations.factorize(damping)) return false;
    step = equations.solve(Eigen::Map<const Vector6>(sums.g));
    return step.allFinite();
  }

  // Translations count in the distance by which the camera has to move to change errors as much as by turning by 1 rad:
  // so the unit of length does not matter.
  bool is_small(const Vector6& step, double tolerance) const {
    const Vector6 information = to_matrix(sums).diagonal();
    const double distance = std::sqrt(information.tail<3>().sum() / information.head<3>().sum());
    return step.head<3>().lpNorm<Eigen::Infinity>() <= tolerance * distance &&
           step.tail<3>().lpNorm<Eigen::Infinity>() <= tolerance;
  }

  Pose T_cw;
  PoseSums sums;
  Scaled equations;
};

bool cost_rises(const PoseProblem& problem, const Linearization& from, const Linearization& to) {
  const std::size_t all = problem.subset.size();
  const bool same_terms = from.sums.used == all && to.sums.used == all;
  return !((same_terms ? to.sums.rho : rho_after_step(problem, from.T_cw, to.T_cw)) <= from.sums.rho);
}

// Steps from `current`, which becomes the last accepted linearisation; returns why the steps terminated.
PoseStatus iterate(const PoseProblem& problem, Linearization& current, int& iterations) {
  if (current.sums.used < min_matches) return PoseStatus::too_few_matches;
  if (!current.is_regular()) return PoseStatus::singular;
  const bool damps = problem.options.method == PoseMethod::levenberg_marquardt;
  double damping = damps ? first_damping : 0;
  while (iterations < problem.options.max_iterations) {
    ++iterations;
    Vector6 step;
    if (!current.solve(damping, step)) return PoseStatus::singular;
    if (current.is_small(step, problem.options.step_tolerance)) return PoseStatus::converged;
    const Linearization next(problem, orthonormal(exp_se3(step) * current.T_cw));
    if (damps && cost_rises(problem, current, next)) {
      damping = std::fmax(10 * damping, min_damping_after_rise);
      continue;
    }
    if (!next.is_regular()) return PoseStatus::singular;
    damping /= 10;
    current = next;
  }
  return PoseStatus::iteration_limit;
}

}  // namespace

const char* to_string(PoseStatus status) {
  switch (status) {
    case PoseStatus::converged: return "converged";
    case PoseStatus::iteration_limit: return "iteration_limit";
    case PoseStatus::too_few_matches: return "too_few_matches";
    case PoseStatus::singular: return "singular";
  }
  return "unknown";
}

Matrix6 invert_information(const Matrix6& information) {
  const Scaled scaled(information);
  if (!scaled.is_regular) return Matrix6::Constant(std::numeric_limits<double>::quiet_NaN());
  Matrix6 inverse;
  for (int i = 0; i < 6; ++i) inverse.col(i) = scaled.solve(Vector6::Unit(i));
  return 0.5 * (inverse + inverse.transpose());
}

Matrix6 PoseEstimate::covariance() const { return invert_information(information); }

double chi2(const FrameCamera& camera, const Pose& T_cw, const Match& match, bool stereo, const Whitening* whitening) {
  const double s = squared_error(camera, T_cw, match, stereo, whitening).value;
  return s < infinity ? s : infinity;  // NaN is no match either
}

PoseEstimate optimize_pose(const FrameCamera& camera, const std::vector<Match>& matches,
                           const std::vector<std::uint32_t>& subset, const Pose& start, const PoseOptions& options,
                           const std::vector<Whitening>& whitenings) {
  const PoseProblem problem{camera, matches, subset, options, whitenings};
  Linearization current(problem, orthonormal(start));
  PoseEstimate estimate;
  estimate.status = iterate(problem, current, estimate.iterations);
  estimate.T_cw = estimate.status == PoseStatus::too_few_matches ? start : current.T_cw;
  estimate.cost = 0.5 * current.sums.rho;
  estimate.information = to_matrix(current.sums);
  return estimate;
}

}  // namespace maxlogdet::sim
