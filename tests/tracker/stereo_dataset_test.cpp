// SPDX-License-Identifier: MIT
#include "tests/tracker/dataset_folder.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <sstream>
#include <stdexcept>

namespace maxlogdet::test {
namespace {

// ---- KITTI

const Lines bare_calibration = {"700 0 60.5 0 0 710 22.5 0 0 0 1 0", "700 0 60.5 -350 0 710 22.5 0 0 0 1 0"};

class KittiFolder : public StereoDatasetFolder {
 protected:
  KittiFolder() {
    Random random;
    write("calib.txt", bare_calibration);
    for (int i = 0; i < 3; ++i) {
      for (const char* side : {"image_l", "image_r"}) {
        images_.push_back(random_image(random, 120, 45));
        write(std::string(side) + "/00000" + std::to_string(i) + ".png", images_.back());
      }
    }
  }

  std::vector<cv::Mat> images_;
};

TEST_F(KittiFolder, opens_and_loads_as_it_is_written) {
  const Pose second = Eigen::Translation3d(1, 2, 3) * Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY());
  write("poses.txt", {rows_of(Pose::Identity()), rows_of(second)});
  const auto dataset = open_dataset(folder_ + "/");
  EXPECT_EQ(dataset->name(), fs::path(folder_).filename().string());
  EXPECT_EQ(dataset->width(), 120);
  EXPECT_EQ(dataset->height(), 45);
  EXPECT_EQ(dataset->camera().fx, 700);
  EXPECT_EQ(dataset->camera().fy, 710);
  EXPECT_EQ(dataset->camera().cx, 60.5);
  EXPECT_EQ(dataset->camera().cy, 22.5);
  EXPECT_NEAR(dataset->camera().bf, 350, 1e-12);
  ASSERT_EQ(dataset->size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(dataset->time(i), 0.1 * static_cast<double>(i), 1e-15) << "10 Hz";
    const StereoImages images = dataset->load(i);
    EXPECT_TRUE(same(images.left, images_[2 * i]));
    EXPECT_TRUE(same(images.right, images_[2 * i + 1]));
  }
  ASSERT_TRUE(dataset->truth(0).has_value() && dataset->truth(1).has_value());
  EXPECT_TRUE(dataset->truth(1)->isApprox(second, 1e-14));
  EXPECT_FALSE(dataset->truth(2).has_value()) << "one pose fewer than images";
  EXPECT_THROW(dataset->time(3), std::out_of_range);
  EXPECT_THROW(dataset->truth(3), std::out_of_range);
  EXPECT_THROW(dataset->load(3), std::out_of_range);
}

TEST_F(KittiFolder, reads_times_and_does_without_truth) {
  write("times.txt", {"0.000000e+00", "1.036224e-01", "2.5"});
  const auto dataset = open_dataset(folder_);
  EXPECT_EQ(dataset->time(1), 1.036224e-01);
  EXPECT_EQ(dataset->time(2), 2.5);
  EXPECT_FALSE(dataset->truth(0).has_value());
}

TEST_F(KittiFolder, orthonormalises_poses) {
  write("poses.txt", {"1 1e-5 0 4 0 1 0 5 0 0 1.0001 6"});
  const auto truth = open_dataset(folder_)->truth(0);
  ASSERT_TRUE(truth.has_value());
  EXPECT_TRUE(truth->linear().isUnitary(1e-14));
  EXPECT_EQ(truth->translation(), Eigen::Vector3d(4, 5, 6));
}

TEST_F(KittiFolder, reads_grey_and_colour_cameras_by_their_matrices) {
  Random random;
  const Lines labelled = {"P0: 700 0 60 0 0 700 22 0 0 0 1 0", "P1: 700 0 60 -350 0 700 22 0 0 0 1 0",
                          "P2: 720 0 61 36 0 720 23 0.72 0 0 1 0.003", "P3: 720 0 61 -324 0 720 23 0.72 0 0 1 0.003",
                          "Tr: 1 0 0 0 0 1 0 0 0 0 1 0"};
  for (const char* side : {"image_2", "image_3"}) {
    write(std::string("colour/") + side + "/0.png", random_image(random, 50, 40, CV_8UC3));
  }
  write("colour/calib.txt", labelled);
  write("colour/poses.txt", {rows_of(Pose::Identity())});
  const auto colour = open_dataset(path("colour"));
  EXPECT_EQ(colour->name(), "colour");
  EXPECT_EQ(colour->camera().fx, 720);
  EXPECT_NEAR(colour->camera().bf, 360, 1e-10);
  EXPECT_EQ(colour->load(0).left.type(), CV_8UC1);
  // Poses are those of camera 0: P2 projects a point of its frame to where the camera at truth() sees it.
  Eigen::Matrix<double, 3, 4> P2;
  P2 << 720, 0, 61, 36, 0, 720, 23, 0.72, 0, 0, 1, 0.003;
  const Eigen::Vector4d point(1, -0.5, 8, 1);
  ASSERT_TRUE(colour->truth(0).has_value());
  const Eigen::Vector3d p = colour->truth(0)->inverse() * point.head<3>();
  const auto& camera = colour->camera();
  EXPECT_NEAR(camera.fx * p.x() / p.z() + camera.cx, (P2 * point).hnormalized().x(), 1e-9);
  EXPECT_NEAR(camera.fy * p.y() / p.z() + camera.cy, (P2 * point).hnormalized().y(), 1e-9);

  write("calib.txt", labelled);
  EXPECT_EQ(open_dataset(folder_)->camera().fx, 700);
  EXPECT_NEAR(open_dataset(folder_)->camera().bf, 350, 1e-12);
}

TEST_F(KittiFolder, names_make_plain_text) {
  fs::rename(folder_, folder_ + " (a)");
  EXPECT_EQ(open_dataset(folder_ + " (a)")->name(), fs::path(folder_).filename().string() + "__a_");
  fs::rename(folder_ + " (a)", folder_);
}

TEST_F(KittiFolder, tells_what_is_wrong_with_the_calibration) {
  const auto with = [&](std::size_t line, const std::string& text, const std::string& expected) {
    expect_error_with("calib.txt", bare_calibration, line, text, expected);
  };
  with(1, "700 0 60.5 0 0 710 22.5 0 0 0 1", "12 numbers, a projection matrix (3 x 4 row-major), not 11");
  with(2, "700 0 60.5 x 0 710 22.5 0 0 0 1 0", "a finite number for a projection matrix, not 'x'");
  with(2, "700 0 60.5 nan 0 710 22.5 0 0 0 1 0", "a finite number for a projection matrix, not 'nan'");
  with(1, "0 0 60.5 0 0 710 22.5 0 0 0 1 0", "positive fx and fy");
  with(1, "700 0 60.5 0 0 -710 22.5 0 0 0 1 0", "positive fx and fy");
  with(1, "700 1 60.5 0 0 710 22.5 0 0 0 1 0", "a projection matrix 'fx 0 cx . 0 fy cy . 0 0 1 .'");
  with(1, "700 0 60.5 0 0 710 22.5 0 0 0 2 0", "a projection matrix 'fx 0 cx . 0 fy cy . 0 0 1 .'");
  with(2, "701 0 60.5 -350 0 710 22.5 0 0 0 1 0", "the same fx, fy, cx, cy left and right");
  with(2, "700 0 60.5 0 0 710 22.5 0 0 0 1 0", "P_left[3] - P_right[3] > 0");
  with(2, "700 0 60.5 350 0 710 22.5 0 0 0 1 0", "P_left[3] - P_right[3] > 0");
  with(2, "700 0 60.5 -350 0 710 22.5 -350 0 0 1 0", "to the right of the left one");
  with(2, "700 0 60.5 -1e308 0 710 22.5 0 0 0 1 1e308", "to the right of the left one");
  const Lines far = {"1e-300 0 60 0 0 710 22 0 0 0 1 0", "1e-300 0 60 -1e300 0 710 22 0 0 0 1 0"};
  expect_error_in("calib.txt", far, ":2: end of file", "cameras whose places float64 can hold");
  const std::string what = "two projection matrices";
  expect_error_in("calib.txt", {bare_calibration[0], bare_calibration[1], bare_calibration[1]}, ":3: ", what);
  expect_error_in("calib.txt", {bare_calibration[0]}, ":1: end of file", what);
  expect_error_in("calib.txt", {}, ":0: end of file", what);
  expect_error_in("calib.txt", {"P0: " + bare_calibration[0], "P2: " + bare_calibration[1]}, ":2: end of file",
                  "'P1:'");
  fs::remove(path("calib.txt"));
  expect_error("calib.txt", "cannot be opened; expected a readable calibration file");
}

TEST_F(KittiFolder, tells_what_is_wrong_with_times_and_poses) {
  const std::string pose = rows_of(Pose::Identity());
  expect_error_in("times.txt", {"0", "1"}, ":2: end of file", "a time for each of 3 images, not 2");
  expect_error_in("times.txt", {"0", "1", "2", "3"}, ":4: ", "a time for each of 3 images, not one more");
  expect_error_in("times.txt", {"0", "1", "1"}, ":3: ", "a time later than the one before");
  expect_error_in("times.txt", {"0", "inf", "1"}, ":2: ", "a finite number for a time in s, not 'inf'");
  fs::remove(path("times.txt"));
  expect_error_in("poses.txt", {pose, pose, pose, pose}, ":4: ", "at most a pose for each of 3 images");
  expect_error_in("poses.txt", {pose, "1 0 0 0"},
                  ":2: ", "12 numbers, a pose, camera to world (3 x 4 row-major), not 4");
  expect_error_in("poses.txt", {"1.01 0 0 0 0 1 0 0 0 0 1 0"}, ":1: ", "a rotation in the first 3 columns");
  expect_error_in("poses.txt", {"-1 0 0 0 0 1 0 0 0 0 1 0"}, ":1: ", "a rotation in the first 3 columns");
  write("calib.txt", {"1 0 60 1.7e308 0 1 22 0 0 0 1 0", "1 0 60 -1 0 1 22 0 0 0 1 0"});
  expect_error_in("poses.txt", {"1 0 0 -1.7e308 0 1 0 0 0 0 1 0"}, ":1: ", "float64 can hold the camera's place");
}

TEST_F(KittiFolder, names_the_image_without_partner) {
  const auto expect_alone = [&](const std::string& file) {
    expect_error(file + ": ", "expected an image of that name in");
  };
  fs::remove(path("image_r/000002.png"));
  expect_alone("image_l/000002.png");
  fs::remove(path("image_l/000001.png"));
  expect_alone("image_r/000001.png");
  fs::remove(path("image_r/000001.png"));
  fs::rename(path("image_r/000000.png"), path("image_r/000003.png"));
  expect_alone("image_l/000000.png");
  fs::remove_all(path("image_r"));
  fs::create_directories(path("image_r"));
  expect_error("image_r: ", "expected files named *.png in this folder");
  fs::remove_all(path("image_r"));
  expect_error("image_r: ", "expected files named *.png in this folder");
}

TEST_F(KittiFolder, names_the_image_that_cannot_be_used) {
  const std::string good = read_bytes(path("image_l/000001.png"));
  const auto dataset = open_dataset(folder_);
  const auto expect_load_error = [&](const std::string& file, const std::string& expected) {
    expect_input_error([&] { dataset->load(1); }, path(file) + ": ", expected);
  };
  const std::string unreadable = "cannot be read; expected a whole image";
  write_bytes(path("image_l/000001.png"), good.substr(0, good.size() / 2));
  expect_load_error("image_l/000001.png", unreadable);
  std::string damaged = good;
  damaged[damaged.size() / 2] = static_cast<char>(~damaged[damaged.size() / 2]);
  write_bytes(path("image_l/000001.png"), damaged);
  expect_load_error("image_l/000001.png", unreadable);
  write_bytes(path("image_l/000001.png"), "");
  expect_load_error("image_l/000001.png", unreadable);
  fs::remove(path("image_l/000001.png"));
  expect_load_error("image_l/000001.png", "is missing; expected an image");
  fs::create_directories(path("image_l/000001.png"));
  expect_load_error("image_l/000001.png", "is missing; expected an image");
  fs::remove_all(path("image_l/000001.png"));
  write_bytes(path("image_l/000001.png"), good);
  Random random;
  write("image_r/000001.png", random_image(random, 119, 45));
  expect_load_error("image_r/000001.png", "is an image of 119 x 45 px; expected 120 x 45 px");
  EXPECT_TRUE(same(dataset->load(2).left, images_[4])) << "the others still are what they were";

  write_bytes(path("image_l/000000.png"), "no image");
  expect_error("image_l/000000.png: ", unreadable);
}

TEST_F(StereoDatasetFolder, tells_what_it_looked_for) {
  expect_input_error([&] { open_dataset(path("none")); }, path("none: is not a folder"),
                     "expected one with stereo images");
  expect_input_error([&] { open_dataset(folder_); }, folder_ + ": holds no stereo images", "image_0 and image_1");
  write("file", Lines{"text"});
  expect_input_error([&] { open_dataset(path("file")); }, path("file: is not a folder"),
                     "expected one with stereo images");
}

// ---- EuRoC: an oracle of its cameras

struct OracleCamera {
  double fu, fv, cu, cv;
  double k1, k2, p1, p2;  // radial-tangential
  Pose T_bs;

  Eigen::Vector2d project(const Eigen::Vector3d& p) const {
    const double x = p.x() / p.z();
    const double y = p.y() / p.z();
    const double r2 = x * x + y * y;
    const double radial = 1 + k1 * r2 + k2 * r2 * r2;
    return {fu * (x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)) + cu,
            fv * (y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y) + cv};
  }

  Lines yaml() const {
    const auto rows = sim::to_rows(T_bs);
    return {"%YAML:1.0",
            "sensor_type: camera",
            "comment: VI-Sensor cam (MT9M034)",
            "T_BS:",
            "  cols: 4",
            "  rows: 4",
            "  data: [" + numbers({rows.begin(), rows.begin() + 8}, ", ") + ",",
            "         " + numbers({rows.begin() + 8, rows.end()}, ", ") + ", 0.0, 0.0, 0.0, 1.0]",
            "rate_hz: 20",
            "resolution: [376, 240]",
            "camera_model: pinhole",
            "intrinsics: [" + numbers({fu, fv, cu, cv}, ", ") + "] #fu, fv, cu, cv",
            "distortion_model: radial-tangential",
            "distortion_coefficients: [" + numbers({k1, k2, p1, p2}, ", ") + "]"};
  }
};

constexpr int width = 376;
constexpr int height = 240;
constexpr std::int64_t first_stamp = 1403715273262142976;
constexpr std::int64_t ms = 1000000;
constexpr std::size_t pair_count = 4;

class EurocFolder : public StereoDatasetFolder {
 protected:
  EurocFolder() {
    Eigen::Matrix3d R;  // body x forward, y left, z up; camera z forward, x right, y down
    R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
    Pose T_bs = Eigen::Translation3d(0.06, 0.05, -0.02) * Eigen::Quaterniond(R);
    T_bs = T_bs * sim::exp_se3((sim::Vector6() << 0, 0, 0, 0.05, -0.1, 0.07).finished());
    left_ = {229.3, 228.6, 183.6, 124.2, -0.28340811, 0.07395907, 0.00019359, 1.76187114e-05, T_bs};
    const Pose T_lr = sim::exp_se3((sim::Vector6() << 0.11, 0.002, -0.001, -0.012, 0.02, 0.015).finished());
    right_ = {228.8, 228.1, 190.0, 127.6, -0.28368365, 0.07451284, -0.00010473, -3.555907e-05, T_bs * T_lr};
    write("mav0/cam0/sensor.yaml", left_.yaml());
    write("mav0/cam1/sensor.yaml", right_.yaml());
    std::vector<std::int64_t> stamps;
    for (std::size_t i = 0; i < pair_count; ++i) stamps.push_back(stamp(i));
    write("mav0/cam0/data.csv", list(stamps));
    write("mav0/cam1/data.csv", list(stamps));
    for (std::size_t i = 0; i < pair_count; ++i) draw(i);
  }

  static std::int64_t stamp(std::size_t i) { return first_stamp + 50 * ms * static_cast<std::int64_t>(i); }
  static double seconds(std::int64_t stamp) { return static_cast<double>(stamp - first_stamp) * 1e-9; }

  static Lines list(const std::vector<std::int64_t>& stamps) {
    Lines lines = {"#timestamp [ns],filename"};
    for (const auto s : stamps) lines.push_back(std::to_string(s) + "," + std::to_string(s) + ".png\r");
    return lines;
  }

  // Body to world: a straight line and a steady turn, so that truth between samples is exact.
  static Pose true_pose(double t) {
    return Eigen::Translation3d(3 + 0.9 * t, -1 - 0.4 * t, 1 + 0.2 * t) *
           Eigen::AngleAxisd(0.8 + 0.6 * t, Eigen::Vector3d(1, -2, 2) / 3);
  }

  Lines asl_truth(std::int64_t from, std::int64_t to, std::int64_t step) const {
    Lines lines = {"#timestamp, p_RS_R_x [m], ..., q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z [], v_RS_R_x [m s^-1]"};
    for (std::int64_t s = from; s <= to; s += step) {
      const Pose T = true_pose(seconds(s));
      const Eigen::Quaterniond q(T.linear());
      const auto p = T.translation();
      lines.push_back(std::to_string(s) + "," + numbers({p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z(), 7, 7}, ","));
    }
    return lines;
  }

  // Points before the left camera of pair i, on a grid in its image, at depths of 1.5 to 6 m; world frame.
  std::vector<Eigen::Vector3d> points(std::size_t i) const {
    Random random("points", i);
    std::vector<Eigen::Vector3d> result;
    for (int v = -110; v <= 110; v += 22) {
      for (int u = -170; u <= 170; u += 34) {
        const Eigen::Vector3d ray(u / left_.fu, v / left_.fv, 1);
        result.emplace_back(true_pose(seconds(stamp(i))) * left_.T_bs * (random.uniform(1.5, 6) * ray));
      }
    }
    return result;
  }

  // A blob around each point, as the cameras see it.
  void draw(std::size_t i) const {
    for (const auto& [name, camera] : {std::make_pair("cam0", left_), std::make_pair("cam1", right_)}) {
      cv::Mat image(height, width, CV_64F, cv::Scalar(0));
      const Pose T_sw = (true_pose(seconds(stamp(i))) * camera.T_bs).inverse();
      for (const Eigen::Vector3d& point : points(i)) {
        const Eigen::Vector2d z = camera.project(T_sw * point);
        for (int y = static_cast<int>(z.y()) - 7; y <= static_cast<int>(z.y()) + 8; ++y) {
          for (int x = static_cast<int>(z.x()) - 7; x <= static_cast<int>(z.x()) + 8; ++x) {
            if (x < 0 || y < 0 || x >= width || y >= height) continue;
            image.at<double>(y, x) += 220 * std::exp(-(Eigen::Vector2d(x, y) - z).squaredNorm() / (2 * 1.3 * 1.3));
          }
        }
      }
      image.convertTo(image, CV_8U);
      write(std::string("mav0/") + name + "/data/" + std::to_string(stamp(i)) + ".png", image);
    }
  }

  OracleCamera left_, right_;
};

// Middle of the blob around z, px, seen through a window of +-6 px; nothing if the window is not inside.
std::optional<Eigen::Vector2d> blob_near(const cv::Mat& image, const Eigen::Vector2d& z) {
  constexpr int half = 6;
  const int u = static_cast<int>(std::lround(z.x()));
  const int v = static_cast<int>(std::lround(z.y()));
  if (u < half || v < half || u + half >= image.cols || v + half >= image.rows) return std::nullopt;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int y = v - half; y <= v + half; ++y) {
    for (int x = u - half; x <= u + half; ++x) sum += image.at<unsigned char>(y, x) * Eigen::Vector3d(x, y, 1);
  }
  return sum.hnormalized();
}

TEST_F(EurocFolder, rectified_rows_agree_and_disparity_is_bf_over_depth) {
  write("mav0/state_groundtruth_estimate0/data.csv", asl_truth(first_stamp, stamp(pair_count), 5 * ms));
  const auto dataset = open_dataset(folder_);
  ASSERT_EQ(dataset->size(), pair_count);
  EXPECT_EQ(dataset->width(), width);
  EXPECT_EQ(dataset->height(), height);
  const PinholeCamera& camera = dataset->camera();
  const Eigen::Vector3d baseline = (left_.T_bs.inverse() * right_.T_bs).translation();
  EXPECT_NEAR(camera.bf / camera.fx, baseline.norm(), 1e-9);
  std::size_t seen = 0;
  for (std::size_t i = 0; i < pair_count; ++i) {
    SCOPED_TRACE("pair " + std::to_string(i));
    EXPECT_NEAR(dataset->time(i), static_cast<double>(stamp(i)) * 1e-9, 1e-6);
    ASSERT_TRUE(dataset->truth(i).has_value());
    const StereoImages images = dataset->load(i);
    ASSERT_EQ(images.left.size(), cv::Size(width, height));
    ASSERT_EQ(images.right.size(), images.left.size());
    ASSERT_EQ(images.left.type(), CV_8UC1);
    ASSERT_EQ(images.right.type(), CV_8UC1);
    for (const Eigen::Vector3d& point : points(i)) {
      const Eigen::Vector3d p = dataset->truth(i)->inverse() * point;
      const Eigen::Vector2d z(camera.fx * p.x() / p.z() + camera.cx, camera.fy * p.y() / p.z() + camera.cy);
      const Eigen::Vector2d z_right(z.x() - camera.bf / p.z(), z.y());
      const auto left = blob_near(images.left, z);
      const auto right = blob_near(images.right, z_right);
      if (!left || !right) continue;
      ++seen;
      EXPECT_LT((*left - z).norm(), 0.1) << "camera() and truth() are those of the left image";
      EXPECT_NEAR(left->y(), right->y(), 0.1) << "rows agree";
      EXPECT_NEAR(left->x() - right->x(), camera.bf / p.z(), 0.1) << "disparity";
    }
  }
  EXPECT_GT(seen, 60 * pair_count);
}

TEST_F(EurocFolder, truth_is_interpolated_but_not_over_gaps) {
  // Truth begins after image 0, has a gap around image 2, and ends before image 3; beside it, one without either.
  Lines lines = asl_truth(stamp(0) + 7 * ms, stamp(1) + 20 * ms, 10 * ms);
  const Lines rest = asl_truth(stamp(3) - 22 * ms, stamp(3) - 2 * ms, 10 * ms);
  lines.insert(lines.end(), rest.begin() + 1, rest.end());
  write("mav0/state_groundtruth_estimate0/data.csv", lines);
  const auto gapped = open_dataset(folder_);
  EXPECT_FALSE(gapped->truth(0).has_value());
  EXPECT_TRUE(gapped->truth(1).has_value());
  EXPECT_TRUE(gapped->truth(2).has_value()) << "77 ms";
  EXPECT_FALSE(gapped->truth(3).has_value());

  Lines tum;  // the same trajectory, 40 Hz and off the images
  for (int k = -3; k < 9; ++k) {
    const double t = 0.007 + 0.025 * k;
    const Pose T = true_pose(t);
    const Eigen::Quaterniond q(T.linear());
    const auto p = T.translation();
    tum.push_back(
        numbers({static_cast<double>(first_stamp) * 1e-9 + t, p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()}));
  }
  write("ground_truth.txt", tum);
  fs::remove_all(path("mav0/state_groundtruth_estimate0"));
  const auto dataset = open_dataset(folder_);
  ASSERT_TRUE(dataset->truth(0).has_value());
  const Pose T_bc = true_pose(0).inverse() * *dataset->truth(0);  // rectified camera to body: the same in all
  EXPECT_LT((T_bc.translation() - left_.T_bs.translation()).norm(), 1e-6) << "rectification turns about the camera";
  for (std::size_t i = 1; i < pair_count; ++i) {
    ASSERT_TRUE(dataset->truth(i).has_value());
    EXPECT_TRUE(dataset->truth(i)->isApprox(true_pose(seconds(stamp(i))) * T_bc, 1e-6)) << "stamps of 0.2 us";
  }
  EXPECT_TRUE(gapped->truth(1)->isApprox(*dataset->truth(1), 1e-6));

  const Lines far = {tum[0], numbers({static_cast<double>(first_stamp) * 1e-9 + 0.3, 0, 0, 0, 0, 0, 0, 1})};
  write("ground_truth.txt", far);
  for (std::size_t i = 0; i < pair_count; ++i) EXPECT_FALSE(open_dataset(folder_)->truth(i).has_value());
}

TEST_F(EurocFolder, opens_mav0_itself_under_the_same_name) {
  const auto dataset = open_dataset(path("mav0"));
  EXPECT_EQ(dataset->name(), fs::path(folder_).filename().string());
  EXPECT_EQ(dataset->size(), pair_count);
  EXPECT_TRUE(same(dataset->load(1).right, open_dataset(folder_)->load(1).right));
}

TEST_F(EurocFolder, tells_what_is_wrong_with_a_sensor_file) {
  const std::string file = "mav0/cam1/sensor.yaml";
  const auto with = [&](std::size_t line, const std::string& text, const std::string& expected) {
    expect_error_with(file, right_.yaml(), line, text, expected);
  };
  with(11, "camera_model: omni", "camera_model 'pinhole', not 'omni'");
  with(13, "distortion_model: equidistant", "distortion_model 'radial-tangential', not 'equidistant'");
  with(12, "intrinsics: [458, 457, 367]", "4 finite numbers: intrinsics");
  with(12, "intrinsics: 458", "4 finite numbers: intrinsics");
  with(12, "intrinsics: [458, abc, 367, 248]", "4 finite numbers: intrinsics");
  with(12, "intrinsics: [458, .nan, 367, 248]", "4 finite numbers: intrinsics");
  with(12, "intrinsics: [-458, 457, 367, 248]", "positive focal lengths");
  with(14, "distortion_coefficients: [0.1, 0.1]", "4 finite numbers: distortion_coefficients");
  with(10, "resolution: [752.5, 480]", "a width and height from 1 to 32766 px");
  with(10, "resolution: [1000000, 480]", "a width and height from 1 to 32766 px");
  with(10, "resolution: [0, 480]", "a width and height from 1 to 32766 px");
  with(10, "resolution: [[1, 2], 480]", "2 finite numbers: resolution");
  Lines broken = right_.yaml();
  broken[8] = "rate_hz: [20";  // whose end is missed on the next line
  expect_error_in(file, broken, ":10: ", "YAML");
  const auto with_field = [&](std::size_t line, const std::string& text, const std::string& expected) {
    Lines lines = right_.yaml();
    lines[line - 1] = text;
    expect_error_in(file, lines, ": ", expected);
  };
  for (const auto& [line, name] : {std::make_pair(10, "resolution"), std::make_pair(11, "camera_model"),
                                   std::make_pair(12, "intrinsics"), std::make_pair(13, "distortion_model"),
                                   std::make_pair(14, "distortion_coefficients"), std::make_pair(4, "T_BS")}) {
    with_field(static_cast<std::size_t>(line),
               std::string("x_") + name + right_.yaml()[static_cast<std::size_t>(line - 1)],
               std::string("expected a field '") + name + "'");
  }
  for (const std::string k1 : {"1e300", "-1000"}) {
    with_field(14, "distortion_coefficients: [" + k1 + ", 0, 0, 0]", "that can be rectified with cam0's");
  }
  with_field(10, "resolution: [375, 240]", "expected the resolution that cam0 has");
  const auto with_pose = [&](const Pose& T_bs, const std::string& place, const std::string& expected) {
    OracleCamera camera = right_;
    camera.T_bs = T_bs;
    expect_error_in(file, camera.yaml(), place, expected);
  };
  Pose stretched = right_.T_bs;
  stretched.linear() *= 1.01;
  with_pose(stretched, ":5: ", "a rigid transform, sensor to body, as T_BS");
  with_pose(left_.T_bs, ": ", "a T_BS that puts cam1 to the right of cam0");
  with_pose(left_.T_bs * Eigen::Translation3d(-0.11, 0, 0), ": ", "to the right of cam0");
  with_pose(left_.T_bs * Eigen::Translation3d(0, 0.11, 0), ": ", "to the right of cam0");
  Lines projective = right_.yaml();
  projective[7] = "         0, 1, 0, 0, 0, 0, 0, 2]";
  expect_error_in(file, projective, ":5: ", "a rigid transform");
  expect_error_in(file, {}, ": ", "expected a sensor file");
  expect_error_in(file, {"%YAML:1.0", "- 1"}, ": ", "expected a sensor file");
  fs::remove(path(file));
  expect_error(file + ": ", "cannot be opened; expected a sensor file");
}

TEST_F(EurocFolder, names_the_stamp_without_partner) {
  const auto expect_alone = [&](const std::string& file, std::int64_t s) {
    expect_error("mav0/" + file + ": stamp " + std::to_string(s) + " has no partner", "expected one within 1 ms in");
  };
  const auto write_right = [&](const std::vector<std::int64_t>& stamps) { write("mav0/cam1/data.csv", list(stamps)); };
  write_right({stamp(0), stamp(1), stamp(3)});
  expect_alone("cam0/data.csv", stamp(2));
  write_right({stamp(0), stamp(1), stamp(2)});
  expect_alone("cam0/data.csv", stamp(3));
  write_right({stamp(0), stamp(0) + 20 * ms, stamp(1), stamp(2), stamp(3)});
  expect_alone("cam1/data.csv", stamp(0) + 20 * ms);
  write_right({stamp(0), stamp(1), stamp(2), stamp(3), stamp(4)});
  expect_alone("cam1/data.csv", stamp(4));
  write_right({stamp(0), stamp(1), stamp(2), stamp(3) + ms + 1});
  expect_alone("cam0/data.csv", stamp(3));
  write("mav0/cam1/data.csv", {std::to_string(stamp(0) - ms) + "," + std::to_string(stamp(0)) + ".png"});
  write("mav0/cam0/data.csv", list({stamp(0)}));
  EXPECT_EQ(open_dataset(folder_)->size(), 1U) << "1 ms apart";
}

TEST_F(EurocFolder, tells_what_is_wrong_with_lists_images_and_truth) {
  const std::string file = "mav0/cam0/data.csv";
  expect_error_in(file, {"#timestamp [ns],filename", "1403715273262142976"},
                  ":2: ", "the fields stamp,filename, not 1");
  expect_error_in(file, {"12e3,a.png"}, ":1: ", "a stamp in ns, later than the one before, not '12e3'");
  expect_error_in(file, {"-1,a.png"}, ":1: ", "a stamp in ns, later than the one before, not '-1'");
  expect_error_in(file, {"12,a.png", "12,b.png"}, ":2: ", "a stamp in ns, later than the one before, not '12'");
  // In seconds, as float64 has them, these are the same time.
  expect_error_in(file, {"1403636579763555584,a.png", "1403636579763555585,b.png"},
                  ":2: ", "a stamp in ns, later than the one before, not '1403636579763555585'");
  expect_error_in(file, {std::string("12,a\0.png", 10)}, ":1: ", "a file name without control characters");
  expect_error_in(file, {"#timestamp [ns],filename"}, ":1: end of file", "at least one image: stamp,filename");
  fs::remove(path(file));
  expect_error(file + ": ", "cannot be opened; expected a readable list of images");
  std::vector<std::int64_t> stamps;
  for (std::size_t i = 0; i < pair_count; ++i) stamps.push_back(stamp(i));
  write(file, list(stamps));

  const std::string truth = "mav0/state_groundtruth_estimate0/data.csv";
  expect_error_in(truth, {std::to_string(first_stamp) + ",1,2,3,1,0,0,1"}, ":1: ", "q_w,q_x,q_y,q_z of norm 1");
  write(truth, {std::to_string(first_stamp - 10 * ms) + ",-1.7e308,0,0,1,0,0,0",
                std::to_string(first_stamp + 10 * ms) + ",1.7e308,0,0,1,0,0,0"});
  expect_input_error([&] { open_dataset(folder_); }, folder_ + ": ", "float64 can hold the camera's place");
  fs::remove(path(truth));
  expect_error_in("ground_truth.txt", {"1 2 3"}, ":1: ", "8 fields");
  fs::remove(path("ground_truth.txt"));

  Random random;
  const std::string image = "mav0/cam1/data/" + std::to_string(stamp(2)) + ".png";
  write(image, random_image(random, width, height + 1));
  const auto dataset = open_dataset(folder_);
  expect_input_error([&] { dataset->load(2); }, path(image) + ": ", "expected 376 x 240 px");
  for (const char* camera : {"mav0/cam1", "mav0/cam0"}) {
    const std::string first = camera + ("/data/" + std::to_string(stamp(0)) + ".png");
    write(first, random_image(random, width + 1, height));
    expect_error(first + ": ", "is an image of 377 x 240 px; expected 376 x 240 px");
    fs::remove(path(first));
    expect_error(first + ": ", "is missing; expected an image");
  }
}

// ---- Both

TEST_F(KittiFolder, damaged_files_are_read_or_refused) {
  write("poses.txt", {rows_of(Pose::Identity()), rows_of(Pose::Identity())});
  write("times.txt", Lines{"0", "0.1", "0.2"});
  expect_no_crash_of_damaged_files(folder_, {"calib.txt", "poses.txt", "times.txt", "image_l/000001.png"}, 400);
}

TEST_F(EurocFolder, damaged_files_are_read_or_refused) {
  const std::string truth = "mav0/state_groundtruth_estimate0/data.csv";
  write(truth, asl_truth(first_stamp, stamp(pair_count), 20 * ms));
  expect_no_crash_of_damaged_files(
      folder_, {"mav0/cam0/sensor.yaml", "mav0/cam1/sensor.yaml", "mav0/cam1/sensor.yaml", "mav0/cam1/data.csv", truth},
      400);
}

TEST_F(EurocFolder, errors_in_sensor_files_show_no_control_characters) {
  const auto with = [&](std::size_t line, const std::string& text, const std::string& expected) {
    expect_error_with("mav0/cam1/sensor.yaml", right_.yaml(), line, text, expected);
  };
  with(3, "comment: \"\\\x01\"", "YAML; unknown escape character: ?");
  with(11, "camera_model: \"pin\\nhole\"", "camera_model 'pinhole', not 'pin?hole'");
}

TEST_F(EurocFolder, deeply_nested_sensor_files_are_refused) {
  Lines lines = right_.yaml();
  lines.push_back("nested: " + std::string(1000000, '['));
  expect_error_in("mav0/cam1/sensor.yaml", lines, ":", "YAML");
}

// ---- Recorded data, where it is there

class RealDatasets : public ::testing::Test {
 protected:
  void SetUp() override {
    if (data_folder().empty() || !fs::is_directory(data_folder() + "/kitti_clip_1") ||
        !fs::is_directory(data_folder() + "/euroc_static")) {
      GTEST_SKIP() << no_real_frames;
    }
  }
};

TEST_F(RealDatasets, kitti_is_read_whole) {
  const auto dataset = open_dataset(data_folder() + "/kitti_clip_1");
  EXPECT_EQ(dataset->name(), "kitti_clip_1");
  ASSERT_EQ(dataset->size(), 51U);
  EXPECT_EQ(dataset->width(), 1226);
  EXPECT_EQ(dataset->height(), 370);
  EXPECT_NEAR(dataset->camera().bf, 379.8145, 1e-9);
  for (std::size_t i = 0; i < dataset->size(); ++i) {
    EXPECT_EQ(dataset->load(i).left.size(), cv::Size(1226, 370));
    EXPECT_TRUE(dataset->truth(i).has_value());
  }
  EXPECT_GT(dataset->truth(50)->translation().z(), 50) << "a straight road";
}

TEST_F(RealDatasets, rectified_rows_of_euroc_agree) {
  const auto dataset = open_dataset(data_folder() + "/euroc_static");
  ASSERT_EQ(dataset->size(), 10U);
  const PinholeCamera& camera = dataset->camera();
  EXPECT_NEAR(camera.bf / camera.fx, 0.11, 0.001) << "m, what all who calibrated these cameras tell";
  const auto orb = cv::ORB::create(1000);
  const cv::BFMatcher matcher(cv::NORM_HAMMING);
  for (std::size_t i = 0; i < dataset->size(); ++i) {
    SCOPED_TRACE(i);
    EXPECT_FALSE(dataset->truth(i).has_value());
    const StereoImages images = dataset->load(i);
    std::vector<cv::KeyPoint> left, right;
    cv::Mat left_descriptors, right_descriptors;
    orb->detectAndCompute(images.left, cv::noArray(), left, left_descriptors);
    orb->detectAndCompute(images.right, cv::noArray(), right, right_descriptors);
    // The scene repeats itself: only what is within 5 rows and 150 columns may match, which would let wrong rows be
    // seen.
    cv::Mat may_match(static_cast<int>(left.size()), static_cast<int>(right.size()), CV_8U);
    for (int j = 0; j < may_match.rows; ++j) {
      for (int k = 0; k < may_match.cols; ++k) {
        const cv::Point2f d = left[static_cast<std::size_t>(j)].pt - right[static_cast<std::size_t>(k)].pt;
        may_match.at<unsigned char>(j, k) = std::abs(d.y) <= 5 && d.x >= 0 && d.x <= 150 ? 1 : 0;
      }
    }
    std::vector<cv::DMatch> matches;
    matcher.match(left_descriptors, right_descriptors, matches, may_match);
    std::vector<cv::Point2f> left_points, right_points;
    for (const cv::DMatch& match : matches) {
      const cv::KeyPoint& from = left[static_cast<std::size_t>(match.queryIdx)];
      const cv::KeyPoint& to = right[static_cast<std::size_t>(match.trainIdx)];
      if (match.distance >= 30 || from.octave != 0 || to.octave != 0) continue;
      left_points.push_back(from.pt);
      right_points.push_back(to.pt);
    }
    ASSERT_GT(left_points.size(), 50U);
    const cv::TermCriteria criteria(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 30, 0.01);
    cv::cornerSubPix(images.left, left_points, {5, 5}, {-1, -1}, criteria);  // ORB's corners are whole pixels
    cv::cornerSubPix(images.right, right_points, {5, 5}, {-1, -1}, criteria);
    std::vector<double> offsets;  // |dv|, px
    for (std::size_t j = 0; j < left_points.size(); ++j) {
      offsets.push_back(static_cast<double>(std::abs(left_points[j].y - right_points[j].y)));
    }
    std::sort(offsets.begin(), offsets.end());
    EXPECT_LT(offsets[offsets.size() / 2], 0.5) << offsets.size() << " matches";
  }
}

}  // namespace
}  // namespace maxlogdet::test
