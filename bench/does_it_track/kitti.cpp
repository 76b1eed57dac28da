// SPDX-License-Identifier: MIT
#include "bench/does_it_track/layouts.hpp"
#include "bench/world/text.hpp"
#include "bench/world/text_file.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <opencv2/core.hpp>

namespace stereo_odometry {
namespace {

namespace fs = std::filesystem;
using maxlogdet::sim::InputError;
using maxlogdet::sim::Pose;
using maxlogdet::sim::TextFile;
using Matrix34 = Eigen::Matrix<double, 3, 4>;

constexpr double rate = 10;  // Hz, of all KITTI sequences

Matrix34 matrix(const TextFile& file, std::string_view text, const std::string& what) {
  const auto fields = maxlogdet::sim::split_at_blanks(text);
  if (fields.size() != 12) {
    file.fail("12 numbers, " + what + " (3 x 4 row-major), not " + std::to_string(fields.size()));
  }
  Matrix34 M;
  for (int i = 0; i < 12; ++i) M(i / 4, i % 4) = file.number(fields[static_cast<std::size_t>(i)], what);
  return M;
}

// A projection matrix K [I | offset]; the camera is at -offset in the frame of the poses.
struct Projection {
  Eigen::Matrix3d K;
  Eigen::Vector3d offset;
};

Projection projection(const TextFile& file, std::string_view text) {
  const Matrix34 P = matrix(file, text, "a projection matrix");
  Eigen::Matrix3d K = Eigen::Matrix3d::Identity();
  K(0, 0) = P(0, 0);
  K(1, 1) = P(1, 1);
  K.col(2).head<2>() = P.col(2).head<2>();
  if (!(K(0, 0) > 0) || !(K(1, 1) > 0) || P.leftCols<3>() != K) {
    file.fail("a projection matrix 'fx 0 cx . 0 fy cy . 0 0 1 .' with positive fx and fy");
  }
  return {K, K.inverse() * P.col(3)};
}

// Sets the camera. Returns the left camera's position in the frame of the poses, whose origin may be another camera.
Eigen::Vector3d read_calibration(const std::string& path, int left_matrix, maxlogdet::PinholeCamera& camera) {
  const std::string left_label = "P" + std::to_string(left_matrix);
  const std::string right_label = "P" + std::to_string(left_matrix + 1);
  TextFile file(path, "calibration file");
  std::map<std::string, Projection> found;
  while (const auto text = file.next()) {
    std::string label = found.empty() ? left_label : right_label;  // of a line without a label
    const auto colon = text->find(':');
    if (colon != std::string_view::npos) label = maxlogdet::sim::trimmed(text->substr(0, colon));
    if (label != left_label && label != right_label) continue;
    const Projection P = projection(file, colon == std::string_view::npos ? *text : text->substr(colon + 1));
    if (!found.emplace(label, P).second) file.fail("two projection matrices, left and right, not one more");
  }
  if (found.size() != 2) {
    file.fail_at_end("two projection matrices, left and right: lines of 12 numbers, bare or after '" + left_label +
                     ":' and '" + right_label + ":'");
  }
  const Projection& left = found[left_label];
  const Projection& right = found[right_label];
  if (!left.K.isApprox(right.K, 1e-9)) file.fail_at_end("the same fx, fy, cx, cy left and right, as rectified");
  const Eigen::Vector3d baseline = left.offset - right.offset;
  if (!(baseline.x() > 0) || !(baseline.tail<2>().norm() < 0.02 * baseline.x())) {  // KITTI's colour cameras have 0.005
    file.fail_at_end("a right camera to the right of the left one: P_left[3] - P_right[3] > 0");
  }
  camera = {left.K(0, 0), left.K(1, 1), left.K(0, 2), left.K(1, 2), left.K(0, 0) * baseline.x()};
  if (!left.offset.allFinite() || !std::isfinite(camera.bf) || !(camera.bf > 0)) {
    file.fail_at_end("projection matrices of cameras whose places float64 can hold");
  }
  return -left.offset;
}

std::vector<std::string> names_of(const std::string& folder) {
  std::vector<std::string> names;
  for (const std::string& file : maxlogdet::sim::files_of(folder, "", ".png")) {
    names.push_back(fs::path(file).filename().string());
  }
  return names;
}

std::vector<Recording::Pair> list_pairs(const std::string& left, const std::string& right) {
  const std::vector<std::string> left_names = names_of(left);
  const std::vector<std::string> right_names = names_of(right);
  const auto [l, r] = std::mismatch(left_names.begin(), left_names.end(), right_names.begin(), right_names.end());
  if (l != left_names.end() || r != right_names.end()) {
    const bool left_is_alone = r == right_names.end() || (l != left_names.end() && *l < *r);
    throw InputError((left_is_alone ? left + "/" + *l : right + "/" + *r) +
                     ": has no partner; expected an image of that name in " + (left_is_alone ? right : left));
  }
  std::vector<Recording::Pair> pairs;
  for (const std::string& name : left_names) {
    pairs.push_back({static_cast<double>(pairs.size()) / rate, left + "/" + name, right + "/" + name, {}});
  }
  return pairs;
}

void read_times(const std::string& path, std::vector<Recording::Pair>& pairs) {
  TextFile file(path, "file of times");
  const std::string expected = "a time for each of " + std::to_string(pairs.size()) + " images";
  std::size_t i = 0;
  for (; const auto text = file.next(); ++i) {
    if (i == pairs.size()) file.fail(expected + ", not one more");
    pairs[i].time = file.number(*text, "a time in s");
    if (i > 0 && !(pairs[i].time > pairs[i - 1].time)) file.fail("a time later than the one before");
  }
  if (i < pairs.size()) file.fail_at_end(expected + ", not " + std::to_string(i));
}

void read_poses(const std::string& path, const Eigen::Vector3d& camera_place, std::vector<Recording::Pair>& pairs) {
  TextFile file(path, "file of poses");
  std::size_t i = 0;
  for (; const auto text = file.next(); ++i) {
    if (i == pairs.size()) file.fail("at most a pose for each of " + std::to_string(i) + " images, not one more");
    const std::optional<Pose> T = maxlogdet::sim::nearest_pose(matrix(file, *text, "a pose, camera to world"));
    if (!T) file.fail("a rotation in the first 3 columns of a 3 x 4 pose");
    pairs[i].T_wc = *T * Eigen::Translation3d(camera_place);
    if (!pairs[i].T_wc->matrix().allFinite()) file.fail("a pose at which float64 can hold the camera's place");
  }
}

}  // namespace

Recording read_kitti(const std::string& folder, const KittiFolders& names) {
  Recording recording;
  const Eigen::Vector3d place = read_calibration(folder + "/calib.txt", names.left_matrix, recording.camera);
  recording.pairs = list_pairs(folder + "/" + names.left_images, folder + "/" + names.right_images);
  std::error_code error;
  if (fs::exists(folder + "/times.txt", error)) read_times(folder + "/times.txt", recording.pairs);
  if (fs::exists(folder + "/poses.txt", error)) read_poses(folder + "/poses.txt", place, recording.pairs);
  const cv::Mat first = read_grey(recording.pairs.front().left);
  recording.width = first.cols;
  recording.height = first.rows;
  return recording;
}

}  // namespace stereo_odometry
