// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/trajectory.hpp"

#include "bench/world/text_file.hpp"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <string_view>

namespace maxlogdet::sim {
namespace {

constexpr std::array<const char*, 8> columns = {"timestamp", "tx", "ty", "tz", "qx", "qy", "qz", "qw"};

StampedPose read_pose(const TextFile& file, std::string_view text) {
  const auto fields = split_at_blanks(text);
  if (fields.size() != columns.size()) {
    file.fail("8 fields 'timestamp tx ty tz qx qy qz qw', not " + std::to_string(fields.size()));
  }
  std::array<double, columns.size()> v{};
  for (std::size_t i = 0; i < v.size(); ++i) v[i] = file.number(fields[i], columns[i]);
  const Eigen::Quaterniond q(v[7], v[4], v[5], v[6]);
  if (!(std::abs(q.norm() - 1) <= 1e-2)) {
    file.fail("a quaternion qx qy qz qw of norm 1 within 0.01, not one of norm " + std::to_string(q.norm()));
  }
  return {v[0], Eigen::Translation3d(v[1], v[2], v[3]) * q.normalized()};
}

Trajectory read_tum(const std::string& name) {
  TextFile file(name, "trajectory file");
  Trajectory trajectory{std::filesystem::path(name).stem().string(), {}};
  auto& poses = trajectory.poses;
  while (const auto text = file.next()) {
    const std::string_view fields = trimmed(text->substr(0, text->find('#')));
    if (fields.empty()) continue;
    const StampedPose pose = read_pose(file, fields);
    if (!poses.empty() && !(pose.time > poses.back().time)) file.fail("a timestamp later than that of the pose before");
    poses.push_back(pose);
  }
  if (poses.size() < 3) file.fail_at_end("at least 3 poses, not " + std::to_string(poses.size()));
  return trajectory;
}

Eigen::Matrix3Xd positions_of(const std::vector<StampedPose>& poses) {
  Eigen::Matrix3Xd positions(3, static_cast<Eigen::Index>(poses.size()));
  for (std::size_t i = 0; i < poses.size(); ++i) {
    positions.col(static_cast<Eigen::Index>(i)) = poses[i].T_wb.translation();
  }
  return positions;
}

std::vector<StampedPose> aligned(std::vector<StampedPose> estimate, const std::vector<StampedPose>& truth) {
  const Eigen::Matrix4d similarity = Eigen::umeyama(positions_of(estimate), positions_of(truth));
  const double scale = similarity.block<3, 1>(0, 0).norm();
  for (StampedPose& pose : estimate) {  // the scale moves positions only: a pose remains rigid
    const Eigen::Vector3d position = similarity.topRows<3>() * pose.T_wb.translation().homogeneous();
    pose.T_wb.linear() = similarity.topLeftCorner<3, 3>() / scale * pose.T_wb.linear();
    pose.T_wb.translation() = position;
  }
  return estimate;
}

}  // namespace

std::vector<Trajectory> read_trajectories(const std::string& folder) {
  std::vector<Trajectory> trajectories;
  for (const auto& file : files_of(folder, "", ".txt")) trajectories.push_back(read_tum(file));
  return trajectories;
}

TrajectoryErrors trajectory_errors(const std::vector<StampedPose>& estimate, const std::vector<StampedPose>& truth,
                                   double window) {
  constexpr double half_a_microsecond = 0.5e-6;  // a double resolves the seconds since 1970 to half of that
  constexpr double longest_gap = 0.5;            // s, of a window over its length
  const std::vector<StampedPose> poses = aligned(estimate, truth);
  TrajectoryErrors errors;
  const double squares = (positions_of(poses) - positions_of(truth)).squaredNorm();
  errors.ate_m = std::sqrt(squares / static_cast<double>(truth.size()));
  std::size_t j = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    while (j < truth.size() && truth[j].time - truth[i].time < window - half_a_microsecond) ++j;
    if (j == truth.size()) break;
    const double time = truth[j].time - truth[i].time;
    if (time > window + longest_gap) continue;
    const Pose true_motion = truth[i].T_wb.inverse() * truth[j].T_wb;
    const Pose drift = true_motion.inverse() * (poses[i].T_wb.inverse() * poses[j].T_wb);
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
