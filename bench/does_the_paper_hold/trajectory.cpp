// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/trajectory.hpp"

#include "bench/world/text.hpp"
#include "bench/world/text_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <string_view>
#include <system_error>

namespace maxlogdet::sim {
namespace {

constexpr char columns[] = "timestamp tx ty tz qx qy qz qw";

class TumReader {
 public:
  explicit TumReader(const std::string& file) : file_(file, "trajectory file") {
    trajectory_.name = std::filesystem::path(file).stem().string();
    if (!std::all_of(trajectory_.name.begin(), trajectory_.name.end(), is_plain)) {
      throw InputError(file +
                       ": expected a file name of letters, digits, '_', '-' and '.': it names the sequence in tables");
    }
  }

  Trajectory read() {
    while (const auto text = file_.next()) {
      const std::string_view pose = trimmed(text->substr(0, text->find('#')));
      if (!pose.empty()) read_pose(pose);
    }
    const std::size_t poses = trajectory_.poses.size();
    if (poses < 2) {
      file_.fail_at_end("at least 2 lines '" + std::string(columns) + "', not " + std::to_string(poses));
    }
    return std::move(trajectory_);
  }

 private:
  void read_pose(std::string_view text) {
    constexpr std::array<const char*, 8> names = {"timestamp", "tx", "ty", "tz", "qx", "qy", "qz", "qw"};
    const auto fields = split_at_blanks(text);
    if (fields.size() != names.size()) {
      file_.fail("8 fields '" + std::string(columns) + "', not " + std::to_string(fields.size()));
    }
    std::array<double, names.size()> v{};
    for (std::size_t i = 0; i < v.size(); ++i) {
      v[i] = file_.number(fields[i], names[i]);
    }
    auto& poses = trajectory_.poses;
    if (!poses.empty() && !(v[0] > poses.back().time)) {
      file_.fail("a timestamp later than that of the pose before, not " + shown(fields[0]));
    }
    const Eigen::Quaterniond q(v[7], v[4], v[5], v[6]);
    if (!(std::abs(q.norm() - 1) <= 1e-2)) {
      file_.fail("a quaternion qx qy qz qw of norm 1 within 0.01, not one of norm " + shown(std::to_string(q.norm())));
    }
    StampedPose pose;
    pose.time = v[0];
    pose.T_wb = Eigen::Translation3d(v[1], v[2], v[3]) * q.normalized();
    poses.push_back(pose);
  }

  TextFile file_;
  Trajectory trajectory_;
};

// A Lissajous curve that closes after 2 pi / 0.11 = 57 s. Each amplitude times its frequency is a maximum speed or
// rate; together they stay below 1 m/s and 40 deg/s. The angles have other frequencies, so that a place is revisited
// from another direction.
Pose analytic_pose(double t) {
  const Eigen::Vector3d position(3.0 * std::sin(0.22 * t + 1.2), 2.1 * std::sin(0.33 * t),
                                 1.5 + 0.6 * std::sin(0.55 * t));
  const double yaw = 2.3 * std::sin(0.28 * t);
  const double pitch = 0.12 * std::sin(0.9 * t + 0.5);
  const double roll = 0.15 * std::sin(1.1 * t);
  return Eigen::Translation3d(position) * Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) * Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX());
}

}  // namespace

Trajectory read_tum(const std::string& file) { return TumReader(file).read(); }

std::vector<Trajectory> read_trajectories(const std::string& file_or_folder) {
  std::error_code error;
  if (!std::filesystem::is_directory(file_or_folder, error)) return {read_tum(file_or_folder)};
  std::vector<Trajectory> trajectories;
  for (const auto& file : files_of(file_or_folder, "", ".txt")) trajectories.push_back(read_tum(file));
  return trajectories;
}

Trajectory analytic_trajectory(double seconds, double rate) {
  if (!(seconds >= 0) || !(rate > 0) || !std::isfinite(seconds * rate)) {
    throw std::invalid_argument("a trajectory needs a time of 0 s or more and a positive rate");
  }
  const double last = std::floor(seconds * rate + 1e-6);  // 0.29 * 100 is a little less than 29
  Trajectory trajectory;
  trajectory.name = "analytic";
  for (std::size_t i = 0; i <= static_cast<std::size_t>(last); ++i) {
    const double time = static_cast<double>(i) / rate;
    trajectory.poses.push_back({time, analytic_pose(time)});
  }
  return trajectory;
}

}  // namespace maxlogdet::sim
