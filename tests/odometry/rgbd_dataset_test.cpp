// SPDX-License-Identifier: MIT
// The reader of TUM RGB-D's layout.
#include "tests/odometry/rgbd_dataset_folder.hpp"

#include <Eigen/Geometry>
#include <stdexcept>

namespace maxlogdet::test {
namespace {

using Indices = std::vector<std::size_t>;

TEST_F(RgbdFolder, opens_and_loads_as_it_is_written) {
  const auto dataset = open_dataset(path(""));
  EXPECT_EQ(dataset->name(), fs::path(folder_).filename().string());
  EXPECT_EQ(dataset->width(), width);
  EXPECT_EQ(dataset->height(), height);
  EXPECT_EQ(dataset->camera().fx, 100);
  EXPECT_EQ(dataset->camera().fy, 101);
  EXPECT_EQ(dataset->camera().cx, 59.5);
  EXPECT_EQ(dataset->camera().cy, 44.5);
  EXPECT_EQ(dataset->camera().bf, 40) << "as in ORB-SLAM2";
  ASSERT_EQ(dataset->size(), 3U);
  EXPECT_EQ(dataset->time(0), 10.00) << "the time of the colour image";
  EXPECT_EQ(dataset->time(2), 10.07);
  for (std::size_t i = 0; i < 3; ++i) {
    const StereoImages images = dataset->load(i);
    EXPECT_TRUE(same(images.left, colours_[i]));
    EXPECT_TRUE(images.right.empty());
    ASSERT_EQ(images.depth.type(), CV_32FC1);
    for (const cv::Point p : {cv::Point(0, 0), cv::Point(17, 80), cv::Point(119, 89)}) {
      EXPECT_FLOAT_EQ(images.depth.at<float>(p), static_cast<float>(depths_[i].at<std::uint16_t>(p)) / 1000) << "m";
    }
    EXPECT_FALSE(dataset->truth(i).has_value());
  }
  EXPECT_THROW(dataset->load(3), std::out_of_range);
}

TEST_F(RgbdFolder, reads_colour_images_as_grey) {
  Random random;
  write(colour(0), random_image(random, width, height, CV_8UC3));
  EXPECT_EQ(open_dataset(folder_)->load(0).left.type(), CV_8UC1);
}

TEST_F(RgbdFolder, associations_may_name_depth_first) {
  write("associations.txt", Lines{"10.01 depth/2.png 10.00 rgb/0.png", "10.02 depth/0.png 10.03 rgb/1.png"});
  EXPECT_EQ(depth_indices(), (Indices{2, 0}));
  EXPECT_EQ(open_dataset(folder_)->time(1), 10.03);
  EXPECT_TRUE(same(open_dataset(folder_)->load(1).left, colours_[1]));
}

TEST_F(RgbdFolder, finds_the_depth_nearest_in_time_and_uses_it_once) {
  write_lists({10.00, 10.03, 10.06}, {10.005, 10.034, 10.062});
  EXPECT_EQ(depth_indices(), (Indices{0, 1, 2}));
  write_lists({10.00, 10.015, 10.03}, {10.012, 10.031});
  EXPECT_EQ(depth_indices(), (Indices{0, 1})) << "a depth image that is nearer to the second image belongs to it";
  EXPECT_EQ(open_dataset(folder_)->time(0), 10.015);
  write_lists({10.00, 10.03, 10.06}, {9.98, 10.0795});
  EXPECT_EQ(open_dataset(folder_)->size(), 2U) << "20 ms, before and after";
  EXPECT_EQ(open_dataset(folder_)->time(1), 10.06);
  write_lists({10.00, 10.03, 10.06}, {9.979, 10.031, 10.0805});
  EXPECT_EQ(depth_indices(), Indices{1}) << "colour images without a partner are left out";
  write_lists({10.00, 10.03}, {9.97, 10.051});
  expect_error("depth.txt: ", "a depth image within 20 ms of a colour image");
  write("associations.txt", associations());
  EXPECT_EQ(open_dataset(folder_)->size(), 3U) << "associations come first";
}

TEST_F(RgbdFolder, depth_is_in_units_of_the_camera_file) {
  const auto factor = [&](const std::string& image_line) {
    Lines lines = plain_camera();
    lines[3] = image_line;
    write("camera.txt", lines);
    return static_cast<double>(open_dataset(folder_)->load(0).depth.at<float>(40, 40)) /
           depths_[0].at<std::uint16_t>(40, 40);
  };
  depths_[0].at<std::uint16_t>(40, 40) = 30000;
  write(depth(0), depths_[0]);
  EXPECT_NEAR(factor("120 90 250"), 1 / 250., 1e-9);
  EXPECT_NEAR(factor("120 90"), 1 / 5000., 1e-10) << "the default";
}

TEST_F(RgbdFolder, truth_is_interpolated_but_not_over_gaps) {
  const auto line = [](double t, double turned) {
    const Eigen::Quaterniond q(Eigen::AngleAxisd(turned, Eigen::Vector3d(1, -2, 2) / 3));
    return numbers({t, 10 * (t - 10), 2, 3, q.x(), q.y(), q.z(), q.w()});
  };
  write("groundtruth.txt", Lines{"# timestamp tx ty tz qx qy qz qw", line(9.98, 0.1), line(10.02, 0.3),
                                 line(10.04, 0.3), line(10.15, 0.3)});
  const auto dataset = open_dataset(folder_);
  const Pose expected = Eigen::Translation3d(0, 2, 3) * Eigen::AngleAxisd(0.2, Eigen::Vector3d(1, -2, 2) / 3);
  ASSERT_TRUE(dataset->truth(0).has_value());
  EXPECT_TRUE(dataset->truth(0)->isApprox(expected, 1e-9)) << dataset->truth(0)->matrix();
  EXPECT_TRUE(dataset->truth(1).has_value());
  EXPECT_FALSE(dataset->truth(2).has_value());
}

TEST_F(RgbdFolder, tells_what_is_wrong_with_the_camera_file) {
  const std::string lens = "'fx fy cx cy k1 k2 p1 p2 k3'", image = "'width height depth_units_per_metre'";
  const std::string number = "a finite number for " + lens, focal = "focal lengths fx and fy from 1 to 1000000 px";
  const std::string sides = "a width and height from 1 to 32766 px", units = "from 1 to 1000000 depth units a metre";
  expect_errors("camera.txt", plain_camera(),
                {{2, "100 101 59.5 44.5 0 0 0", lens + ", not 7 fields"},
                 {2, "100 101 59.5 44.5 0 0 0 0 0 0", lens + ", not 10 fields"},
                 {2, "100 101 59.5 x 0 0 0 0 0", number + ", not 'x'"},
                 {2, "100 nan 59.5 44.5 0 0 0 0 0", number + ", not 'nan'"},
                 {2, "100 101 59.5 44.5 inf 0 0 0 0", number + ", not 'inf'"},
                 {2, "0 101 59.5 44.5 0 0 0 0 0", focal},
                 {2, "100 -101 59.5 44.5 0 0 0 0 0", focal},
                 {2, "100 1e300 59.5 44.5 0 0 0 0 0", focal},
                 {4, "120", image + ", not 1 fields"},
                 {4, "120 90 1000 1", image + ", not 4 fields"},
                 {4, "0 90 1000", sides},
                 {4, "120.5 90 1000", sides},
                 {4, "120 1e9 1000", sides},
                 {4, "120 90 0", units},
                 {4, "120 90 -1000", units},
                 {4, "120 90 nan", "a finite number for " + image},
                 {4, "50 90 1000", "an image in which the principal point cx cy is"}});
  expect_error_in("camera.txt", {plain_camera()[1]}, ":1: end of file", image);
  expect_error_in("camera.txt", {"# nothing"}, ":1: end of file", lens);
  expect_error_in("camera.txt", {plain_camera()[1], plain_camera()[3], "1"}, ":3: ", "not one more");
  for (const std::string distortion : {"1e300 0 0 0 0", "-1000 0 0 0 0", "0 0 1e5 0 0"}) {
    expect_error_in("camera.txt", {"100 101 59.5 44.5 " + distortion, plain_camera()[3]}, ": ",
                    "intrinsics and a distortion that can be removed");
  }
  fs::remove(path("camera.txt"));
  expect_error("camera.txt: ", "a readable camera file with the lines " + lens + " and " + image);
}

TEST_F(RgbdFolder, tells_what_is_wrong_with_lists) {
  const std::string file = "associations.txt";
  const std::string fields = "'timestamp rgb/FILE timestamp depth/FILE'", rising = "a time later than the one before";
  const std::string number = "a finite number for a time in s, not ";
  expect_errors(
      file, associations(),
      {{2, "10.00 rgb/0.png", "the 4 fields " + fields + ", not 2"},
       {2, "10.00 rgb/0.png 10.01", "the 4 fields " + fields + ", not 3"},
       {2, "rgb/0.png 10.00 depth/0.png 10.01", number + "'rgb/0.png'"},
       {3, "nan rgb/1.png 10.02 depth/1.png", number + "'nan'"},
       {3, "10.03 rgb/1.png inf depth/1.png", number + "'inf'"},
       {3, "10.00 rgb/1.png 10.02 depth/1.png", rising},
       {3, "10.02 depth/1.png 9.00 rgb/1.png", rising},
       {3, "10.03 rgb/1.png 10.02 rgb/2.png", fields},
       {3, "10.03 depth/1.png 10.02 depth/2.png", fields},
       {3, "10.03 1.png 10.02 1d.png", fields},
       {2, std::string("10.00 rgb/0\0.png 10.01 depth/0.png", 35), "a file name without control characters"}});
  expect_error_in(file, {"# pairs"}, ":1: end of file", "at least one pair of images: " + fields);
  write(file, Lines{"10.00 rgb/0.png 10.01 depth/0.png", "10.03 rgb/1.png 10.02 depth/none.png"});
  expect_error("depth/none.png: is missing", "an image file");
  write(file, Lines{"10.00 rgb/none.png 10.01 depth/0.png"});
  expect_error("rgb/none.png: is missing", "an image file");

  fs::remove(path(file));
  expect_input_error([&] { open_dataset(folder_); }, folder_ + ": holds no list of images",
                     "associations.txt, or rgb.txt and depth.txt");
  write_lists({10.00, 10.03}, {10.00, 10.03});
  expect_error_in("rgb.txt", {"10.00"}, ":1: ", "the 2 fields 'timestamp rgb/FILE', not 1");
  expect_error_in("rgb.txt", {"10.00 rgb/0.png", "10.00 rgb/1.png"}, ":2: ", "a time later than the one before");
  expect_error_in("rgb.txt", {"# none"}, ":1: end of file", "at least one image");
  fs::remove(path("rgb.txt"));
  expect_error("rgb.txt: ", "a readable list of images");
  write_lists({10.00, 10.03}, {10.00, 10.03});
  expect_error_in("depth.txt", {"1e999 depth/0.png"}, ":1: ", "a finite number for a time in s, not '1e999'");
  fs::remove(path("depth.txt"));
  expect_error("depth.txt: ", "a readable list of images");
  write("associations.txt", associations());
  expect_error_in("groundtruth.txt", {"1 2 3"}, ":1: ", "8 fields");
}

TEST_F(RgbdFolder, names_the_depth_that_cannot_be_used) {
  const auto dataset = open_dataset(folder_);
  Random random;
  const std::string type = "expected depth in one channel of 16 bit";
  const std::pair<cv::Mat, std::string> images[] = {
      {random_depth(random, width - 1), "is an image of 119 x 90 px; expected 120 x 90"},
      {random_image(random, width, height), type},
      {random_image(random, width, height, CV_8UC3), type},
      {cv::Mat(height, width, CV_16UC3, cv::Scalar(1, 2, 3)), type}};
  for (const auto& [image, expected] : images) {
    write(depth(1), image);
    expect_input_error([&] { dataset->load(1); }, path(depth(1)) + ": ", expected);
  }
  EXPECT_TRUE(same(dataset->load(2).left, colours_[2])) << "the other images can still be loaded";

  const cv::Mat metres(height, width, CV_32F, cv::Scalar(std::nan("")));  // PNG cannot store NaN
  ASSERT_TRUE(cv::imwrite(path("depth/0.tiff"), metres));
  write("associations.txt", Lines{"10.00 rgb/0.png 10.01 depth/0.tiff"});
  expect_error("depth/0.tiff: is an image of type CV_32FC1; ", type);
  write("associations.txt", associations());
  write(colour(0), random_image(random, width + 1, height));
  expect_error(colour(0) + ": is an image of 121 x 90 px; ", "expected 120 x 90 px");
}

TEST_F(RgbdFolder, needs_depth_in_one_image_at_least) {
  const cv::Mat none(height, width, CV_16UC1, cv::Scalar(0));
  write(depth(0), none);
  write(depth(1), none);
  EXPECT_EQ(open_dataset(folder_)->size(), 3U);
  EXPECT_EQ(cv::countNonZero(open_dataset(folder_)->load(0).depth), 0);
  write(depth(2), none);
  expect_error("depth: ", "depth other than 0 in one of the images");
}

TEST_F(RgbdFolder, damaged_files_are_read_or_refused) {
  write("groundtruth.txt",
        Lines{"9.9 0 0 0 0 0 0 1", "9.99 0 0 0 0 0 0 1", "10.05 1 0 0 0 0 0 1", "10.1 1 2 3 0 0 0 1"});
  write("camera.txt", {"100 101 59.5 44.5 0.26 -0.95 -0.005 0.003 1.16", "120 90 1000"});
  expect_no_crash_of_damaged_files(
      folder_, {"camera.txt", "camera.txt", "associations.txt", "groundtruth.txt", depth(1), colour(1)}, 300);
  write_lists({10.00, 10.03, 10.06}, {10.00, 10.03, 10.06});
  expect_no_crash_of_damaged_files(folder_, {"rgb.txt", "depth.txt"}, 100);
}

}  // namespace
}  // namespace maxlogdet::test
