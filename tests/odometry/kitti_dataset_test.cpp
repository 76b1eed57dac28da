// SPDX-License-Identifier: MIT
// The reader of KITTI's layout.
#include "tests/odometry/dataset_folder.hpp"

#include <Eigen/LU>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>

namespace maxlogdet::test {
namespace {

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
  const auto dataset = open_dataset(path(""));
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

TEST_F(KittiFolder, reads_times_and_orthonormalises_poses) {
  write("times.txt", Lines{"0.000000e+00", "1.036224e-01", "2.5"});
  write("poses.txt", Lines{"1 1e-5 0 4 0 1 0 5 0 0 1.0001 6"});
  const auto dataset = open_dataset(folder_);
  EXPECT_EQ(dataset->time(1), 1.036224e-01);
  EXPECT_EQ(dataset->time(2), 2.5);
  ASSERT_TRUE(dataset->truth(0).has_value());
  EXPECT_TRUE(dataset->truth(0)->linear().isUnitary(1e-14));
  EXPECT_EQ(dataset->truth(0)->translation(), Eigen::Vector3d(4, 5, 6));
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
  const std::string matrix = "a projection matrix 'fx 0 cx . 0 fy cy . 0 0 1 .'", positive = "positive fx and fy";
  const std::string order = "P_left[3] - P_right[3] > 0", right = "to the right of the left one";
  expect_errors("calib.txt", bare_calibration,
                {{1, "700 0 60.5 0 0 710 22.5 0 0 0 1", "12 numbers, a projection matrix (3 x 4 row-major), not 11"},
                 {2, "700 0 60.5 x 0 710 22.5 0 0 0 1 0", "a finite number for a projection matrix, not 'x'"},
                 {2, "700 0 60.5 nan 0 710 22.5 0 0 0 1 0", "a finite number for a projection matrix, not 'nan'"},
                 {1, "0 0 60.5 0 0 710 22.5 0 0 0 1 0", positive},
                 {1, "700 0 60.5 0 0 -710 22.5 0 0 0 1 0", positive},
                 {1, "700 1 60.5 0 0 710 22.5 0 0 0 1 0", matrix},
                 {1, "700 0 60.5 0 0 710 22.5 0 0 0 2 0", matrix},
                 {2, "701 0 60.5 -350 0 710 22.5 0 0 0 1 0", "the same fx, fy, cx, cy left and right"},
                 {2, "700 0 60.5 0 0 710 22.5 0 0 0 1 0", order},
                 {2, "700 0 60.5 350 0 710 22.5 0 0 0 1 0", order},
                 {2, "700 0 60.5 -350 0 710 22.5 -350 0 0 1 0", right},
                 {2, "700 0 60.5 -1e308 0 710 22.5 0 0 0 1 1e308", right}});
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
  const std::string file = path("image_l/000001.png"), good = text_of(file);
  const auto dataset = open_dataset(folder_);
  const auto expect_load_error = [&](const std::string& expected) {
    expect_input_error([&] { dataset->load(1); }, file + ": ", expected);
  };
  const std::string unreadable = "cannot be read; expected a complete image file";
  std::string damaged = good;
  damaged[damaged.size() / 2] = static_cast<char>(~damaged[damaged.size() / 2]);
  for (const std::string& bytes : {good.substr(0, good.size() / 2), damaged, std::string()}) {
    write_bytes(file, bytes);
    expect_load_error(unreadable);
  }
  Random random;
  write("image_l/000001.png", random_image(random, 119, 45));
  expect_load_error("is an image of 119 x 45 px; expected 120 x 45 px");
  fs::remove(file);
  expect_load_error("is missing; expected an image");
  fs::create_directories(file);
  expect_load_error("is missing; expected an image");
  EXPECT_TRUE(same(dataset->load(2).left, images_[4])) << "the other images can still be loaded";

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

TEST_F(KittiFolder, damaged_files_are_read_or_refused) {
  write("poses.txt", {rows_of(Pose::Identity()), rows_of(Pose::Identity())});
  write("times.txt", Lines{"0", "0.1", "0.2"});
  expect_no_crash_of_damaged_files(folder_, {"calib.txt", "poses.txt", "times.txt", "image_l/000001.png"}, 400);
}

}  // namespace
}  // namespace maxlogdet::test
