// SPDX-License-Identifier: MIT
#include "bench/does_it_track/layouts.hpp"
#include "bench/world/text.hpp"
#include "bench/world/text_file.hpp"
#include "bench/world/trajectory.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/core/eigen.hpp>
#include <opencv2/imgproc.hpp>

namespace stereo_odometry {
namespace {

using maxlogdet::sim::InputError;
using maxlogdet::sim::Pose;
using maxlogdet::sim::TextFile;

struct Camera {
  cv::Matx33d K;
  cv::Vec4d distortion;  // k1, k2, p1, p2
  cv::Size size;         // px
  Pose T_bc;             // camera to body
};

// sensor.yaml, not read by cv::FileStorage, which reads beyond the end of damaged files.
class SensorFile {
 public:
  explicit SensorFile(std::string file) : file_(std::move(file)) {
    try {
      root_ = YAML::LoadFile(file_);
    } catch (const YAML::BadFile&) {
      throw InputError(file_ + ": cannot be opened; expected a sensor file");
    } catch (const YAML::Exception& error) {
      fail(error.mark, "YAML; " + error.msg);
    }
    if (!root_.IsMap()) throw InputError(file_ + ": expected a sensor file, YAML with one field per line");
  }

  Camera read() const {
    expect_text("camera_model", "pinhole");
    expect_text("distortion_model", "radial-tangential");
    const auto k = numbers(field(root_, "intrinsics"), 4, "intrinsics fu, fv, cu, cv");
    const auto d = numbers(field(root_, "distortion_coefficients"), 4, "distortion_coefficients k1, k2, p1, p2");
    const auto size = numbers(field(root_, "resolution"), 2, "resolution, width and height");
    const auto T = numbers(field(field(root_, "T_BS"), "data"), 16, "T_BS (4 x 4 row-major)");
    if (!(k[0] > 0) || !(k[1] > 0)) fail(field(root_, "intrinsics").Mark(), "positive focal lengths");
    if (!is_image_side(size[0]) || !is_image_side(size[1])) {
      fail(field(root_, "resolution").Mark(), expected_image_sides);
    }
    const Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> T_BS(T.data());
    const std::optional<Pose> T_bc = maxlogdet::sim::nearest_pose(T_BS.topRows<3>());
    if (!T_bc || T_BS.row(3) != Eigen::RowVector4d(0, 0, 0, 1)) {
      fail(field(root_, "T_BS").Mark(), "a rigid transform, sensor to body, as T_BS");
    }
    return {cv::Matx33d(k[0], 0, k[2], 0, k[1], k[3], 0, 0, 1), cv::Vec4d(d.data()),
            cv::Size(static_cast<int>(size[0]), static_cast<int>(size[1])), *T_bc};
  }

 private:
  // `expected` may quote the file, including line ends.
  [[noreturn]] void fail(const YAML::Mark& mark, const std::string& expected) const {
    throw InputError(file_ + ":" + std::to_string(mark.line + 1) + ": expected " + maxlogdet::sim::one_line(expected));
  }

  YAML::Node field(const YAML::Node& parent, const std::string& name) const {
    if (!parent.IsMap() || !parent[name].IsDefined()) throw InputError(file_ + ": expected a field '" + name + "'");
    return parent[name];
  }

  void expect_text(const std::string& name, const std::string& text) const {
    const YAML::Node node = field(root_, name);
    const std::string there = node.IsScalar() ? node.Scalar() : "";
    if (there != text) fail(node.Mark(), name + " '" + text + "', not " + maxlogdet::sim::shown(there));
  }

  std::vector<double> numbers(const YAML::Node& node, std::size_t count, const std::string& what) const {
    const std::string expected = std::to_string(count) + " finite numbers: " + what;
    if (!node.IsSequence() || node.size() != count) fail(node.Mark(), expected);
    std::vector<double> values;
    for (const YAML::Node& entry : node) {
      const auto value = entry.IsScalar() ? maxlogdet::sim::finite_number(entry.Scalar()) : std::nullopt;
      if (!value) fail(entry.Mark(), expected);
      values.push_back(*value);
    }
    return values;
  }

  std::string file_;
  YAML::Node root_;
};

struct StampedImage {
  std::int64_t stamp;  // ns
  std::string file;
};

std::vector<StampedImage> list_images(const std::string& camera_folder) {
  TextFile file(camera_folder + "/data.csv", "list of images");
  std::vector<StampedImage> images;
  const auto read_row = [&](std::int64_t stamp, const std::vector<std::string_view>& fields) {
    refuse_control_characters(file, fields[1]);
    images.push_back({stamp, camera_folder + "/data/" + std::string(fields[1])});
  };
  maxlogdet::sim::read_stamped_rows(file, 2, "stamp,filename", read_row);
  if (images.empty()) file.fail_at_end("at least one image: stamp,filename");
  return images;
}

std::vector<Recording::Pair> list_pairs(const std::string& mav0) {
  const std::vector<StampedImage> left = list_images(mav0 + "/cam0");
  const std::vector<StampedImage> right = list_images(mav0 + "/cam1");
  constexpr std::int64_t longest = 1000000;  // ns; recorded stamps are equal
  const auto [l, r] = std::mismatch(left.begin(), left.end(), right.begin(), right.end(),
                                    [](const StampedImage& a, const StampedImage& b) {
                                      return a.stamp - b.stamp <= longest && b.stamp - a.stamp <= longest;
                                    });
  if (l != left.end() || r != right.end()) {
    const bool left_is_alone = r == right.end() || (l != left.end() && l->stamp < r->stamp);
    throw InputError(mav0 + (left_is_alone ? "/cam0" : "/cam1") + "/data.csv: stamp " +
                     std::to_string((left_is_alone ? l : r)->stamp) + " has no partner; expected one within 1 ms in " +
                     (left_is_alone ? "cam1" : "cam0"));
  }
  std::vector<Recording::Pair> pairs;
  for (std::size_t i = 0; i < left.size(); ++i) {
    pairs.push_back({static_cast<double>(left[i].stamp) * 1e-9, left[i].file, right[i].file, {}});
  }
  return pairs;
}

// Sets camera, size and maps. Returns the rotation from the left to the rectified left camera.
Eigen::Matrix3d rectify(const Camera& left, const Camera& right, Recording& recording) {
  const Pose T_rl = right.T_bc.inverse() * left.T_bc;
  cv::Matx33d R, R1, R2;
  cv::Matx34d P1, P2;
  cv::Matx44d Q;
  cv::Vec3d t;
  cv::eigen2cv(Eigen::Matrix3d(T_rl.linear()), R);
  cv::eigen2cv(Eigen::Vector3d(T_rl.translation()), t);
  cv::stereoRectify(left.K, left.distortion, right.K, right.distortion, left.size, R, t, R1, R2, P1, P2, Q,
                    cv::CALIB_ZERO_DISPARITY, 0);  // 0: every pixel has a source
  cv::initUndistortRectifyMap(left.K, left.distortion, R1, P1, left.size, CV_32FC1, recording.left_map.x,
                              recording.left_map.y);
  cv::initUndistortRectifyMap(right.K, right.distortion, R2, P2, right.size, CV_32FC1, recording.right_map.x,
                              recording.right_map.y);
  recording.camera = {P1(0, 0), P1(1, 1), P1(0, 2), P1(1, 2), -P2(0, 3)};
  recording.width = left.size.width;
  recording.height = left.size.height;
  Eigen::Matrix3d R_rectified;
  cv::cv2eigen(R1, R_rectified);
  return R_rectified;
}

maxlogdet::sim::Trajectory find_ground_truth(const std::string& folder, const std::string& mav0) {
  std::error_code error;
  const std::string estimate = mav0 + "/state_groundtruth_estimate0/data.csv";
  if (std::filesystem::exists(estimate, error)) return maxlogdet::sim::read_asl(estimate);
  const std::string tum = folder + "/ground_truth.txt";
  if (std::filesystem::exists(tum, error)) return maxlogdet::sim::read_tum(tum);
  return {};
}

}  // namespace

Recording read_euroc(const std::string& folder, const std::string& mav0) {
  const std::string right_sensor = mav0 + "/cam1/sensor.yaml";
  const Camera left = SensorFile(mav0 + "/cam0/sensor.yaml").read();
  const Camera right = SensorFile(right_sensor).read();
  if (left.size != right.size) throw InputError(right_sensor + ": expected the resolution that cam0 has");
  const Eigen::Vector3d p = (left.T_bc.inverse() * right.T_bc).translation();  // of the right camera, left frame
  if (!(p.x() > 1e-6) || p.x() < 2 * p.tail<2>().norm()) {
    throw InputError(right_sensor + ": expected a T_BS that puts cam1 to the right of cam0");
  }
  Recording recording;
  recording.pairs = list_pairs(mav0);
  for (const std::string& file : {recording.pairs.front().left, recording.pairs.front().right}) {
    read_grey(file, left.size);  // before maps of the calibrated size are made
  }
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  bool is_sensible = false;
  try {
    R = rectify(left, right, recording);
    is_sensible = is_stereo(recording.camera) && comes_from_image(recording.left_map, left.size) &&
                  comes_from_image(recording.right_map, left.size);
  } catch (const cv::Exception&) {
    is_sensible = false;
  }
  if (!is_sensible) {
    throw InputError(right_sensor + ": expected intrinsics, distortion and T_BS that can be rectified with cam0's");
  }
  const auto truth = find_ground_truth(folder, mav0);
  const Pose T_br = left.T_bc * Pose(R.transpose());  // rectified left camera to body
  for (Recording::Pair& pair : recording.pairs) {
    const std::optional<Pose> T_wb = pose_at(truth, pair.time, max_truth_gap);
    if (!T_wb) continue;
    pair.T_wc = *T_wb * T_br;
    if (!pair.T_wc->matrix().allFinite()) {
      throw InputError(folder + ": expected a ground truth at which float64 can hold the camera's place");
    }
  }
  return recording;
}

}  // namespace stereo_odometry
