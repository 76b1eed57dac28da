// SPDX-License-Identifier: MIT
#include "sim/trajectory.hpp"

#include "sim/frame_reader.hpp"
#include "sim/text.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <locale>
#include <optional>
#include <stdexcept>
#include <string_view>

namespace maxlogdet::sim {
namespace {

constexpr char columns[] = "timestamp tx ty tz qx qy qz qw";

// The fields between blanks and tabs.
std::vector<std::string_view> split(std::string_view text) {
  constexpr char blanks[] = " \t";
  std::vector<std::string_view> fields;
  auto begin = text.find_first_not_of(blanks);
  while (begin != std::string_view::npos) {
    const auto end = std::min(text.find_first_of(blanks, begin), text.size());
    fields.push_back(text.substr(begin, end - begin));
    begin = text.find_first_not_of(blanks, end);
  }
  return fields;
}

// Names go into CSV files and plots as they are.
bool is_plain(const std::string& name) {
  return std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-' ||
           c == '.';
  });
}

class TumReader {
 public:
  explicit TumReader(const std::string& file) : file_(file), stream_(file) {
    if (!stream_) throw InputError(file + ": cannot be opened; expected a readable trajectory file");
  }

  Trajectory read() {
    trajectory_.name = std::filesystem::path(file_).stem().string();
    if (!is_plain(trajectory_.name)) {
      throw InputError(file_ +
                       ": expected a file name of letters, digits, '_', '-' and '.': it names the sequence in tables");
    }
    std::string line;
    while (std::getline(stream_, line)) {
      ++line_;
      const std::string_view text = text_of_line(line, line_);
      const std::string_view pose = trimmed(text.substr(0, text.find('#')));
      if (!pose.empty()) read_pose(pose);
    }
    if (stream_.bad()) throw InputError(file_ + ": reading failed after line " + std::to_string(line_));
    const std::size_t poses = trajectory_.poses.size();
    if (poses < 2) {
      throw InputError(file_ + ":" + std::to_string(line_) + ": end of file; expected at least 2 lines '" + columns +
                       "', not " + std::to_string(poses));
    }
    return std::move(trajectory_);
  }

 private:
  [[noreturn]] void fail(const std::string& expected) const {
    throw InputError(file_ + ":" + std::to_string(line_) + ": expected " + expected);
  }

  void read_pose(std::string_view text) {
    constexpr std::array<const char*, 8> names = {"timestamp", "tx", "ty", "tz", "qx", "qy", "qz", "qw"};
    const auto fields = split(text);
    if (fields.size() != names.size()) {
      fail("8 fields '" + std::string(columns) + "', not " + std::to_string(fields.size()));
    }
    std::array<double, names.size()> v{};
    for (std::size_t i = 0; i < v.size(); ++i) {
      const std::optional<double> value = finite_number(fields[i]);
      if (!value) fail("a finite number for " + std::string(names[i]) + ", not " + shown(fields[i]));
      v[i] = *value;
    }
    auto& poses = trajectory_.poses;
    if (!poses.empty() && !(v[0] > poses.back().time)) {
      fail("a timestamp later than that of the pose before, not " + shown(fields[0]));
    }
    const Eigen::Quaterniond q(v[7], v[4], v[5], v[6]);
    if (!(std::abs(q.norm() - 1) <= 1e-2)) {
      fail("a quaternion qx qy qz qw of norm 1 within 0.01, not one of norm " + shown(std::to_string(q.norm())));
    }
    StampedPose pose;
    pose.time = v[0];
    pose.T_wb = Eigen::Translation3d(v[1], v[2], v[3]) * q.normalized();
    poses.push_back(pose);
  }

  std::string file_;
  std::ifstream stream_;
  std::size_t line_ = 0;
  Trajectory trajectory_;
};

// A Lissajous curve that closes after 2 pi / 0.11 = 57 s. Each amplitude times its frequency is a largest speed or
// rate; together they stay below 1 m/s and 40 deg/s. The angles have frequencies of their own, so that a place seen
// again is seen from elsewhere.
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

Trajectory read_tum(const std::string& file) {
  std::error_code error;
  if (std::filesystem::is_directory(file, error)) throw InputError(file + ": is a folder; expected a trajectory file");
  return TumReader(file).read();
}

std::vector<Trajectory> read_trajectories(const std::string& file_or_folder) {
  namespace fs = std::filesystem;
  std::error_code error;
  if (!fs::is_directory(file_or_folder, error)) return {read_tum(file_or_folder)};
  std::vector<std::string> files;
  for (const auto& entry : fs::directory_iterator(file_or_folder, error)) {
    if (entry.path().extension() == ".txt") files.push_back(entry.path().string());
  }
  if (error) throw InputError(file_or_folder + ": cannot be listed: " + error.message());
  if (files.empty()) throw InputError(file_or_folder + ": expected files named *.txt in this folder, found none");
  std::sort(files.begin(), files.end());
  std::vector<Trajectory> trajectories;
  for (const auto& file : files) trajectories.push_back(read_tum(file));
  return trajectories;
}

void write_tum(const Trajectory& trajectory, const std::string& file) {
  std::ofstream stream(file);
  stream.imbue(std::locale::classic());  // a point in numbers, whatever the program's locale
  stream.precision(17);                  // as many digits as tell any two doubles apart
  stream << "# " << columns << '\n';
  for (const StampedPose& pose : trajectory.poses) {
    const auto p = pose.T_wb.translation();
    const Eigen::Quaterniond q(pose.T_wb.linear());
    stream << pose.time;
    for (const double value : {p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()}) stream << ' ' << value;
    stream << '\n';
  }
  stream.close();
  if (!stream) throw InputError(file + ": cannot be written; expected a place for a trajectory file");
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
