// SPDX-License-Identifier: MIT
// The program examples/stereo_vo, on a room that is rendered here, and on clips of KITTI.
#include "tests/support/support.hpp"
#include "tests/support/text_folder.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/affine.hpp>
#include <opencv2/core/quaternion.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <sstream>
#include <string>
#include <vector>

namespace maxlogdet::test {
namespace {

using Poses = std::vector<cv::Affine3d>;  // camera to world

constexpr int width = 480, height = 240;
const std::vector<double> barrel = {-0.2, 0.03, 0.001, -0.002, 0};
const Lines lens = {"# a barrel", "300 300 240 120 -0.2 0.03 0.001 -0.002 0", "480 240 5000"};
const Lines calib = {"P0: 300 0 240 0 0 300 120 0 0 0 1 0", "P1: 300 0 240 -120 0 300 120 0 0 0 1 0"};

cv::Mat make_texture() {
  cv::RNG random(7);
  cv::Mat texture(1024, 1024, CV_8U);
  random.fill(texture, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(texture, texture, cv::Size(), 2);
  return 4 * texture - 384;
}

// What a camera sees in a textured room: grey values, and depths in fifths of a millimetre. `rays`: of pixels, at Z
// = 1.
void render(const cv::Affine3d& T_wc, const cv::Mat& rays, cv::Mat& image, cv::Mat& depth) {
  static const cv::Mat texture = make_texture();
  const double low[3] = {-4, -1.5, -10}, high[3] = {4, 1.5, 14};  // the walls, m
  cv::Mat columns(height, width, CV_32F), rows(height, width, CV_32F);
  depth.create(height, width, CV_16U);
  for (int i = 0; i < width * height; ++i) {
    const cv::Point at(i % width, i / width);
    const cv::Vec2f ray = rays.at<cv::Vec2f>(i);
    const cv::Vec3d from = T_wc.translation(), d = T_wc.rotation() * cv::Vec3d(ray[0], ray[1], 1);
    double z[3];
    for (int axis = 0; axis < 3; ++axis) z[axis] = ((d[axis] > 0 ? high : low)[axis] - from[axis]) / d[axis];
    const int wall = static_cast<int>(std::min_element(z, z + 3) - z);
    const cv::Vec3d texel = 25 * (from + z[wall] * d);  // of 4 cm
    columns.at<float>(at) = static_cast<float>(texel[(wall + 1) % 3] + 300 * wall);
    rows.at<float>(at) = static_cast<float>(texel[(wall + 2) % 3] + (d[wall] > 0 ? 500 : 0));
    depth.at<std::uint16_t>(at) = static_cast<std::uint16_t>(std::lround(5000 * z[wall]));
  }
  cv::remap(texture, image, columns, rows, cv::INTER_LINEAR, cv::BORDER_WRAP);
}

// A walk that turns and sways; a depth of 16 bits ends at 13 m.
Poses walk(double start) {
  Poses poses;
  for (int i = 0; i < 12; ++i) {
    const double s = std::sin(0.4 * i);
    poses.emplace_back(cv::Vec3d(0, 0.08 * s, 0), cv::Vec3d(0.1 * s, 0.02 * i, start + 0.15 * i));
  }
  return poses;
}

// Of a file of 3 x 4 matrices, or of `timestamp tx ty tz qx qy qz qw`.
Poses read_poses(const std::string& file) {
  Poses poses;
  std::istringstream lines(text_of(file));
  for (std::string line; std::getline(lines, line);) {
    std::istringstream stream(line);
    const std::vector<double> n{std::istream_iterator<double>(stream), {}};
    if (n.size() == 8)
      poses.emplace_back(cv::Quatd(n[7], n[4], n[5], n[6]).toRotMat3x3(), cv::Vec3d(n[1], n[2], n[3]));
    else
      poses.emplace_back(cv::Mat(n).reshape(1, 3));  // throws for other numbers than 12
  }
  return poses;
}

// Medians of the error of the motion between frames: translation, m, and rotation, rad.
cv::Vec2d errors_between(const Poses& truth, const Poses& found) {
  std::vector<double> translations, rotations;
  for (std::size_t i = 1; i < truth.size(); ++i) {
    const cv::Affine3d error = (truth[i - 1].inv() * truth[i]).inv() * (found[i - 1].inv() * found[i]);
    translations.push_back(cv::norm(error.translation()));
    rotations.push_back(cv::norm(error.rvec()));
  }
  std::sort(translations.begin(), translations.end());
  std::sort(rotations.begin(), rotations.end());
  return {translations[translations.size() / 2], rotations[rotations.size() / 2]};
}

class StereoVo : public TextFolder {
 protected:
  // Writes the images that a walk sees, as KITTI has them, or with depths as TUM has them.
  void write_images(const Poses& poses, const std::vector<double>& distortion, bool is_rgbd) const {
    std::vector<cv::Point2f> pixels;
    for (int i = 0; i < width * height; ++i) pixels.emplace_back(i % width, i / width);
    cv::Mat rays;
    const cv::Matx33d K(300, 0, 240, 0, 300, 120, 0, 0, 1);
    cv::undistortPoints(pixels, rays, K, distortion);
    Lines associations;
    cv::Mat image, depth;
    for (const char* folder : {"image_0", "image_1"}) std::filesystem::create_directories(path(folder));
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const std::string name = std::to_string(100 + i), left = "image_0/" + name, right = "image_1/" + name;
      render(poses[i], rays, image, depth);
      cv::imwrite(path(left + ".png"), image);
      if (!is_rgbd) render(poses[i] * cv::Affine3d(cv::Vec3d(), cv::Vec3d(0.4, 0, 0)), rays, image, depth);
      cv::imwrite(path(right + ".png"), is_rgbd ? depth : image);
      associations.push_back(name + ".5 " + left + ".png " + name + ".6 " + right + ".png");
    }
    write("associations.txt", associations);
  }

  // Runs the program; returns its exit code.
  int run(const std::string& arguments) const {
    const std::string command = "cd '" + folder_ + "' && '" STEREO_VO_PROGRAM "' " + arguments + " 2>err.txt >out.txt";
    const int status = std::system(command.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  void expect_refused(const std::string& arguments, const std::string& message) const {
    EXPECT_EQ(run(arguments), 2) << arguments;
    const std::string text = text_of(path("err.txt"));
    EXPECT_EQ(text.rfind("stereo_vo: " + message, 0), 0U) << text << "\ndoes not begin with " << message;
    EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1) << text;
  }

  void expect_errors_below(const std::string& images, const Poses& truth, double translation, double rotation) const {
    for (const std::string options : {"", " --select 100"}) {
      SCOPED_TRACE(images + options);
      ASSERT_EQ(run("'" + images + "'" + options), 0);
      EXPECT_EQ(text_of(path("err.txt")), "") << "every frame has a pose";
      const Poses found = read_poses(path("trajectory.txt"));
      ASSERT_GE(found.size(), truth.size());
      const cv::Vec2d errors = errors_between(truth, found);
      EXPECT_LT(errors[0], translation);
      EXPECT_LT(errors[1], rotation);
    }
  }
};

TEST_F(StereoVo, finds_the_path_in_stereo) {
  write_images(walk(0), {}, false);
  write("calib.txt", calib);
  expect_errors_below(".", walk(0), 0.005, 0.001);
}

TEST_F(StereoVo, finds_the_path_from_distorted_images_with_depths) {
  write_images(walk(2), barrel, true);
  write("camera.txt", lens);
  expect_errors_below(".", walk(2), 0.005, 0.001);
  EXPECT_EQ(run(". --record frames --picture picture.png"), 0);
  EXPECT_NE(text_of(path("frames/frame_000010.csv")), "");
  EXPECT_EQ(cv::imread(path("picture.png")).size(), cv::Size(width, 2 * height));
}

TEST_F(StereoVo, finds_the_paths_of_real_clips) {
  if (data_folder().empty()) GTEST_SKIP() << no_real_frames;
  for (const char* clip : {"/kitti_clip_1", "/kitti_0039_a"}) {
    const Poses truth = read_poses(data_folder() + clip + "/poses.txt");
    ASSERT_GE(truth.size(), 50U) << clip;
    expect_errors_below(std::filesystem::absolute(data_folder() + clip), truth, 0.04,
                        0.0015);  // OpenCV differs between processors
  }
}

TEST_F(StereoVo, names_the_file_that_is_wrong) {
  expect_refused(".", ".: expected a folder with calib.txt");
  write_images({walk(2)[0]}, barrel, false);
  write("calib.txt", {calib[0], "P1: 300 0 240 nan 0 300 120 0 0 0 1 0"});
  expect_refused(".", "./calib.txt:2: expected a 3 x 4 projection matrix");
  write("calib.txt", calib);
  expect_refused(". --output none/path.txt", "none/path.txt: cannot be written");
  std::filesystem::resize_file(path("image_1/100.png"), 0);
  expect_refused(".", "./image_1/100.png: cannot be read; expected the right image");
}

}  // namespace
}  // namespace maxlogdet::test
