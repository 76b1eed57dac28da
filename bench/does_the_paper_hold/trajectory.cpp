// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/trajectory.hpp"

#include "bench/world/text_file.hpp"

#include <array>
#include <cmath>
#include <filesystem>
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
  StampedPose pose;
  pose.time = v[0];
  pose.T_wb = Eigen::Translation3d(v[1], v[2], v[3]) * q.normalized();
  return pose;
}

}  // namespace

Trajectory read_tum(const std::string& name) {
  TextFile file(name, "trajectory file");
  Trajectory trajectory;
  trajectory.name = std::filesystem::path(name).stem().string();
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

std::vector<Trajectory> read_trajectories(const std::string& folder) {
  std::vector<Trajectory> trajectories;
  for (const auto& file : files_of(folder, "", ".txt")) trajectories.push_back(read_tum(file));
  return trajectories;
}

}  // namespace maxlogdet::sim
