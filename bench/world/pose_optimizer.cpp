// SPDX-License-Identifier: MIT
#include "bench/world/pose_optimizer.hpp"

#include "bench/world/projection.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace maxlogdet::sim {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t min_matches = 3;  // 6 rows

// With the diagonal scaled to 1, a direction whose undamped pivot is not above this is unobserved: sums of 2000 matches
// round to some 1e-14.
constexpr double min_pivot = 1e-13;

// Levenberg-Marquardt adds lambda diag to the normal equations. lambda starts almost at Gauss-Newton, falls tenfold
// with each accepted step, and grows tenfold, to at least 0.01, with each rejected one.
constexpr double first_damping = 1e-6;
constexpr double min_damping_after_rise = 1e-2;

// A symmetric matrix with its diagonal scaled to 1, so that metres and radians are comparable.
class Scaled {
 public:
  explicit Scaled(const Matrix6& A) : scale_(A.diagonal().array().sqrt().inverse()) {
    matrix_ = scale_.asDiagonal() * A * scale_.asDiagonal();
  }

  // Factorises A + damping diag(A); returns whether it is regular.
  bool factorize(double damping) {
    Matrix6 damped = matrix_;
    damped.diagonal().array() += damping;
    factor_.compute(damped);
    return damped.allFinite() && factor_.info() == Eigen::Success &&
           (factor_.matrixLLT().diagonal().array().square() > min_pivot).all();
  }

  Vector6 solve(const Vector6& b) const {
    return scale_.asDiagonal() * factor_.solve(Vector6(scale_.asDiagonal() * b));
  }

 private:
  Vector6 scale_;
  Matrix6 matrix_;
  Eigen::LLT<Matrix6> factor_;
};

// What optimize_pose() minimises, as it was given.
struct PoseProblem {
  const FrameCamera& camera;
  const std::vector<Match>& matches;
  const std::vector<std::uint32_t>& subset;
  const PoseOptions& options;
  const std::vector<Whitening>& whitenings;

  Whitening whitening(std::uint32_t i) const {
    return whitenings.empty() ? measurement_whitening(camera, matches[i]) : whitenings[i];
  }
  // Huber's threshold, infinite of squared errors.
  double threshold(bool has_depth_cue) const {
    const double given = has_depth_cue ? options.huber_stereo : options.huber_monocular;
    return given > 0 ? given : infinity;
  }
};

// Huber's rho(s), and its derivative.
struct Loss {
  Loss(double s, double threshold) : rho(s) {
    if (s <= threshold * threshold) return;
    const double e = std::sqrt(s);
    weight = threshold / e;
    rho = 2 * threshold * e - threshold * threshold;
  }
  double weight = 1, rho;
};

// The normal equations at a pose, of the matches of the subset that have an error there. Rows h of H = W J [I | -[p]x]
// are added one by one, because Eigen's products would wait for matrices that have just been written.
struct Linearization {
  Linearization(const PoseProblem& problem, Pose at) : T_cw(std::move(at)) {
    LinearizedMatch one;
    for (const std::uint32_t i : problem.subset) {
      if (!linearize(problem.camera, T_cw, problem.matches[i], problem.options.stereo, one)) continue;
      const Whitening W = problem.whitening(i);
      const Eigen::Vector3d& r = one.residual;
      const Eigen::Vector3d e(W.row(0).dot(r), W.row(1).dot(r), W.row(2).dot(r));
      if (!(e.squaredNorm() < infinity)) continue;
      const Loss loss(e.squaredNorm(), problem.threshold(one.rows == 3));
      for (int row = 0; row < one.rows; ++row) {
        const Eigen::Vector3d j = one.J.transpose() * W.row(row).transpose(), pxj = one.p.cross(j);
        const double h[] = {j.x(), j.y(), j.z(), pxj.x(), pxj.y(), pxj.z()};
        for (int column = 0; column < 6; ++column) {
          const double weighted = loss.weight * h[column];
          descent(column) += weighted * e(row);
          for (int k = 0; k <= column; ++k) information(k, column) += weighted * h[k];
        }
      }
      rho += loss.rho;
      ++used;
    }
    information.triangularView<Eigen::StrictlyLower>() = information.transpose();
  }

  bool is_regular() const {
    return used >= min_matches && std::isfinite(rho) && information.allFinite() && Scaled(information).factorize(0);
  }

  // Translations count in the distance by which the camera has to move to change errors as much as by turning by 1 rad:
  // so the unit of length does not matter.
  bool is_small(const Vector6& step, double tolerance) const {
    const Vector6 diagonal = information.diagonal();
    const double distance = std::sqrt(diagonal.tail<3>().sum() / diagonal.head<3>().sum());
    return step.head<3>().lpNorm<Eigen::Infinity>() <= tolerance * distance &&
           step.tail<3>().lpNorm<Eigen::Infinity>() <= tolerance;
  }

  Pose T_cw;
  Matrix6 information = Matrix6::Zero();
  Vector6 descent = Vector6::Zero();  // minus the gradient of the cost
  double rho = 0;
  std::size_t used = 0;
};

// Compares the cost of the matches that were linearised at `from`: infinite if a point moves behind the camera, and
// without points that come in front of it.
bool cost_rises(const PoseProblem& problem, const Linearization& from, const Linearization& to) {
  const std::size_t all = problem.subset.size();
  if (from.used == all && to.used == all) return !(to.rho <= from.rho);
  double rho = 0;
  for (const std::uint32_t i : problem.subset) {
    const Match& match = problem.matches[i];
    const Whitening W = problem.whitening(i);
    const auto error_at = [&](const Pose& T_cw) {
      return chi2(problem.camera, T_cw, match, problem.options.stereo, &W);
    };
    if (!(error_at(from.T_cw) < infinity)) continue;
    const double after = error_at(to.T_cw);
    if (!(after < infinity)) return true;
    rho += Loss(after, problem.threshold(problem.options.stereo && match.has_depth_cue())).rho;
  }
  return !(rho <= from.rho);
}

// Steps from `current`, which becomes the last accepted linearisation; returns why the steps terminated.
PoseStatus iterate(const PoseProblem& problem, Linearization& current, int& iterations) {
  if (current.used < min_matches) return PoseStatus::too_few_matches;
  if (!current.is_regular()) return PoseStatus::singular;
  const bool damps = problem.options.method == PoseMethod::levenberg_marquardt;
  double damping = damps ? first_damping : 0;
  while (iterations < problem.options.max_iterations) {
    ++iterations;
    Scaled equations(current.information);
    if (!equations.factorize(damping)) return PoseStatus::singular;
    const Vector6 step = equations.solve(current.descent);
    if (!step.allFinite()) return PoseStatus::singular;
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

Whitening measurement_whitening(const FrameCamera& camera, const Match& match) {
  const double of_pixels = match.inv_sigma2 > 0 && match.inv_sigma2 < infinity ? std::sqrt(match.inv_sigma2) : nan;
  const double of_depth = match.depth > 0 ? 1 / camera.depth_sigma : 0;
  return Eigen::Vector3d(of_pixels, of_pixels, camera.is_pinhole() ? of_pixels : of_depth).asDiagonal();
}

Whitening whitening_of(const FrameCamera& camera, const Pose& T_cw, const Match& match, bool uses_depth_cue,
                       const Eigen::Matrix3d& map_covariance) {
  const double variance = 1 / match.inv_sigma2, of_depth = camera.depth_sigma * camera.depth_sigma;
  Whitening none = Whitening::Constant(nan);
  LinearizedMatch at;
  if (!(variance > 0) || !linearize(camera, T_cw, match, uses_depth_cue, at)) return none;
  const bool has_third = at.rows == 3;
  const double of_third = !has_third ? 1 : camera.is_pinhole() ? variance : of_depth;  // 1: dropped below
  const Eigen::Matrix3d H_p = at.H_p(T_cw);
  Eigen::Matrix3d covariance = H_p * map_covariance * H_p.transpose();
  covariance.diagonal() += Eigen::Vector3d(variance, variance, of_third);
  const Eigen::LLT<Eigen::Matrix3d> factor(covariance);
  if (!covariance.allFinite() || factor.info() != Eigen::Success) return none;
  Whitening W = factor.matrixL().solve(Eigen::Matrix3d::Identity());
  if (!has_third) W(2, 2) = 0;
  return W;
}

std::vector<Whitening> whitenings_of(const Frame& frame, const Pose& T_cw, bool uses_depth_cue, double map_sigma) {
  std::vector<Whitening> whitenings;
  for (std::size_t i = 0; i < frame.matches.size(); ++i) {
    const Match& match = frame.matches[i];
    if (frame.map_covariances.empty()) {
      whitenings.push_back(measurement_whitening(frame.camera, match));
      continue;
    }
    Eigen::Matrix3d covariance(frame.map_covariances[i].data());
    if (std::isnan(covariance(0))) covariance = map_sigma * map_sigma * Eigen::Matrix3d::Identity();
    whitenings.push_back(whitening_of(frame.camera, T_cw, match, uses_depth_cue, covariance));
  }
  return whitenings;
}

Matrix6 PoseEstimate::covariance() const {
  Scaled scaled(information);
  if (!information.allFinite() || !scaled.factorize(0)) return Matrix6::Constant(nan);
  Matrix6 inverse;
  for (int i = 0; i < 6; ++i) inverse.col(i) = scaled.solve(Vector6::Unit(i));
  return 0.5 * (inverse + inverse.transpose());
}

double chi2(const FrameCamera& camera, const Pose& T_cw, const Match& match, bool stereo, const Whitening* whitening) {
  LinearizedMatch at;
  if (!linearize(camera, T_cw, match, stereo, at)) return infinity;
  const double s =
      ((whitening == nullptr ? measurement_whitening(camera, match) : *whitening) * at.residual).squaredNorm();
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
  estimate.cost = 0.5 * current.rho;
  estimate.information = current.information;
  return estimate;
}

Rejection reject_outliers(const FrameCamera& camera, const std::vector<Match>& matches,
                          const std::vector<std::uint32_t>& subset, const Pose& start, const RejectionOptions& options,
                          const std::vector<Whitening>& whitenings) {
  Rejection result;
  result.estimate.T_cw = start;
  result.inliers = subset;
  std::sort(result.inliers.begin(), result.inliers.end());
  const std::vector<std::uint32_t> all = result.inliers;
  for (int round = 1; round <= options.rounds; ++round) {
    PoseOptions of_round;
    of_round.stereo = options.stereo;
    of_round.huber_monocular = round == options.rounds ? 0 : std::sqrt(options.chi2_monocular);
    of_round.huber_stereo = round == options.rounds ? 0 : std::sqrt(options.chi2_stereo);
    of_round.max_iterations = options.max_iterations;
    of_round.step_tolerance = options.step_tolerance;
    result.estimate = optimize_pose(camera, matches, result.inliers, start, of_round, whitenings);
    if (!result.estimate.is_usable()) return result;
    result.inliers.clear();
    for (const std::uint32_t i : all) {
      const double limit = options.stereo && matches[i].has_depth_cue() ? options.chi2_stereo : options.chi2_monocular;
      const Whitening* const whitening = whitenings.empty() ? nullptr : &whitenings[i];
      if (chi2(camera, result.estimate.T_cw, matches[i], options.stereo, whitening) <= limit)
        result.inliers.push_back(i);
    }
  }
  return result;
}

}  // namespace maxlogdet::sim
