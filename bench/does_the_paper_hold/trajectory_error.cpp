// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/trajectory_error.hpp"

#include "bench/world/angles.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace maxlogdet::sim {
namespace {

constexpr double half_a_microsecond = 0.5e-6;  // a double resolves the seconds since 1970 to half of that
constexpr double longest_gap = 0.5;            // s, of a window over its length

// Whether points differ by rounding only.
bool all_coincide(const Eigen::Matrix3Xd& points) {
  const double spread = (points.colwise() - points.col(0)).cwiseAbs().maxCoeff();
  return spread <= 1e-12 * points.cwiseAbs().maxCoeff();
}

Eigen::Matrix3Xd positions_of(const std::vector<StampedPose>& poses) {
  Eigen::Matrix3Xd positions(3, static_cast<Eigen::Index>(poses.size()));
  for (std::size_t i = 0; i < poses.size(); ++i) {
    positions.col(static_cast<Eigen::Index>(i)) = poses[i].T_wb.translation();
  }
  return positions;
}

}  // namespace

// The best rotation is the same with and without scale; the best scale follows from it.
Similarity align_sim3(const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to) {
  const Eigen::Vector3d from_mean = from.rowwise().mean();
  const Eigen::Vector3d to_mean = to.rowwise().mean();
  Similarity result;
  if (!all_coincide(from) && !all_coincide(to)) {
    const Eigen::Matrix3Xd p = from.colwise() - from_mean;
    const Eigen::Matrix3Xd q = to.colwise() - to_mean;
    result.R = Eigen::umeyama(p, q, false).topLeftCorner<3, 3>();
    result.scale = std::max(0.0, q.cwiseProduct(result.R * p).sum() / p.squaredNorm());  // negative only by rounding
  }
  result.t = to_mean - result.scale * (result.R * from_mean);
  return result;
}

TrajectoryErrors trajectory_errors(const std::vector<StampedPose>& estimate, const std::vector<StampedPose>& truth,
                                   double window) {
  const Similarity onto_truth = align_sim3(positions_of(estimate), positions_of(truth));
  std::vector<StampedPose> aligned = estimate;
  for (StampedPose& pose : aligned) {  // the scale moves positions only: a pose remains rigid
    const Eigen::Vector3d position = onto_truth.scale * (onto_truth.R * pose.T_wb.translation()) + onto_truth.t;
    pose.T_wb.linear() = onto_truth.R * pose.T_wb.linear();
    pose.T_wb.translation() = position;
  }

  TrajectoryErrors errors;
  const double squares = (positions_of(aligned) - positions_of(truth)).squaredNorm();
  errors.ate_m = std::sqrt(squares / static_cast<double>(truth.size()));
  std::size_t j = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    while (j < truth.size() && truth[j].time - truth[i].time < window - half_a_microsecond) ++j;
    if (j == truth.size()) break;
    const double time = truth[j].time - truth[i].time;
    if (time > window + longest_gap) continue;
    const Pose true_motion = truth[i].T_wb.inverse() * truth[j].T_wb;
    const Pose motion = aligned[i].T_wb.inverse() * aligned[j].T_wb;
    const Pose drift = true_motion.inverse() * motion;
    errors.rpe_m_per_s += drift.translation().norm() / time;
    errors.roe_deg_per_s += rotation_angle(drift.linear()) * degrees / time;
    ++errors.windows;
  }
  const double windows =
      errors.windows > 0 ? static_cast<double>(errors.windows) : std::numeric_limits<double>::quiet_NaN();
  errors.rpe_m_per_s /= windows;
  errors.roe_deg_per_s /= windows;
  return errors;
}

}  // namespace maxlogdet::sim
