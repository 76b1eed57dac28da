// SPDX-License-Identifier: MIT
// The reader of TUM RGB-D's layout.
#include "tests/tracker/dataset_folder.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <functional>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

namespace maxlogdet::test {
namespace {

constexpr int width = 120;  // px
constexpr int height = 90;
const Lines plain_camera = {"# fx fy cx cy k1 k2 p1 p2 k3", "100 101 59.5 44.5 0 0 0 0 0", "# width height units",
                            "120 90 1000"};
const Lines associations = {"# pairs", "10.00 rgb/0.png 10.01 depth/0.png", "10.03 rgb/1.png 10.02 depth/1.png",
                            "10.07 rgb/2.png 10.06 depth/2.png"};

cv::Mat random_depth(Random& random, int columns = width, int rows = height) {
  cv::Mat depth(rows, columns, CV_16UC1);
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x)
      depth.at<std::uint16_t>(y, x) = static_cast<std::uint16_t>(random.integer(0, 65535));
  }
  return depth;
}

class RgbdFolder : public StereoDatasetFolder {
 protected:
  RgbdFolder() {
    Random random;
    write("camera.txt", plain_camera);
    write("associations.txt", associations);
    for (int i = 0; i < 3; ++i) {
      colours_.push_back(random_image(random, width, height));
      depths_.push_back(random_depth(random));
      write(colour(i), colours_.back());
      write(depth(i), depths_.back());
    }
  }

  static std::string colour(int i) { return "rgb/" + std::to_string(i) + ".png"; }
  static std::string depth(int i) { return "depth/" + std::to_string(i) + ".png"; }

  void write_lists(const std::vector<double>& colour_times, const std::vector<double>& depth_times) const {
    fs::remove(path("associations.txt"));
    for (const auto& [name, times] : {std::make_pair("rgb", colour_times), std::make_pair("depth", depth_times)}) {
      Lines lines = {"# timestamp filename"};
      for (std::size_t i = 0; i < times.size(); ++i) {
        lines.push_back(numbers({times[i]}) + " " + name + "/" + std::to_string(i) + ".png");
      }
      write(name + std::string(".txt"), lines);
    }
  }

  // Which of the recorded depth images each pair has.
  std::vector<std::size_t> depth_indices() const {
    const auto dataset = open_dataset(folder_);
    std::vector<std::size_t> indices;
    for (std::size_t i = 0; i < dataset->size(); ++i) {
      const cv::Mat loaded = dataset->load(i).depth;
      const auto is_loaded = [&](const cv::Mat& recorded) {
        cv::Mat metres;
        recorded.convertTo(metres, CV_32F, 1e-3);
        return same(metres, loaded);
      };
      indices.push_back(
          static_cast<std::size_t>(std::find_if(depths_.begin(), depths_.end(), is_loaded) - depths_.begin()));
    }
    return indices;
  }

  std::vector<cv::Mat> colours_, depths_;
};

using Indices = std::vector<std::size_t>;

TEST_F(RgbdFolder, opens_and_loads_as_it_is_written) {
  const auto dataset = open_dataset(folder_ + "/");
  EXPECT_EQ(dataset->name(), fs::path(folder_).filename().string());
  EXPECT_EQ(dataset->width(), width);
  EXPECT_EQ(dataset->height(), height);
  EXPECT_EQ(dataset->camera().fx, 100);
  EXPECT_EQ(dataset->camera().fy, 101);
  EXPECT_EQ(dataset->camera().cx, 59.5);
  EXPECT_EQ(dataset->camera().cy, 44.5);
  EXPECT_EQ(dataset->camera().bf, 40) << "as ORB-SLAM2 has it";
  ASSERT_EQ(dataset->size(), 3U);
  EXPECT_EQ(dataset->time(0), 10.00) << "the colour image's";
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
  EXPECT_EQ(depth_indices(), (Indices{0, 1})) << "what is nearer to the second image is not the first one's";
  EXPECT_EQ(open_dataset(folder_)->time(0), 10.015);
  write_lists({10.00, 10.03, 10.06}, {9.98, 10.0795});
  EXPECT_EQ(open_dataset(folder_)->size(), 2U) << "20 ms, before and after";
  EXPECT_EQ(open_dataset(folder_)->time(1), 10.06);
  write_lists({10.00, 10.03, 10.06}, {9.979, 10.031, 10.0805});
  EXPECT_EQ(depth_indices(), Indices{1}) << "colour images without a partner are left out";
  write_lists({10.00, 10.03}, {9.97, 10.051});
  expect_error("depth.txt: ", "a depth image within 20 ms of a colour image");
  write("associations.txt", associations);
  EXPECT_EQ(open_dataset(folder_)->size(), 3U) << "associations come first";
}

TEST_F(RgbdFolder, depth_is_in_units_of_the_camera_file) {
  const auto factor = [&](const std::string& image_line) {
    Lines lines = plain_camera;
    lines[3] = image_line;
    write("camera.txt", lines);
    return static_cast<double>(open_dataset(folder_)->load(0).depth.at<float>(40, 40)) /
           depths_[0].at<std::uint16_t>(40, 40);
  };
  depths_[0].at<std::uint16_t>(40, 40) = 30000;
  write(depth(0), depths_[0]);
  EXPECT_NEAR(factor("120 90 250"), 1 / 250., 1e-9);
  EXPECT_NEAR(factor("120 90"), 1 / 5000., 1e-10) << "unless it tells";
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
  const auto with = [&](std::size_t line, const std::string& text, const std::string& expected) {
    expect_error_with("camera.txt", plain_camera, line, text, expected);
  };
  const std::string lens = "'fx fy cx cy k1 k2 p1 p2 k3'", image = "'width height depth_units_per_metre'";
  with(2, "100 101 59.5 44.5 0 0 0", lens + ", not 7 fields");
  with(2, "100 101 59.5 44.5 0 0 0 0 0 0", lens + ", not 10 fields");
  with(2, "100 101 59.5 x 0 0 0 0 0", "a finite number for " + lens + ", not 'x'");
  with(2, "100 nan 59.5 44.5 0 0 0 0 0", "a finite number for " + lens + ", not 'nan'");
  with(2, "100 101 59.5 44.5 inf 0 0 0 0", "a finite number for " + lens + ", not 'inf'");
  with(2, "0 101 59.5 44.5 0 0 0 0 0", "focal lengths fx and fy from 1 to 1000000 px");
  with(2, "100 -101 59.5 44.5 0 0 0 0 0", "focal lengths fx and fy from 1 to 1000000 px");
  with(2, "100 1e300 59.5 44.5 0 0 0 0 0", "focal lengths fx and fy from 1 to 1000000 px");
  with(4, "120", image + ", not 1 fields");
  with(4, "120 90 1000 1", image + ", not 4 fields");
  with(4, "0 90 1000", "a width and height from 1 to 32766 px");
  with(4, "120.5 90 1000", "a width and height from 1 to 32766 px");
  with(4, "120 1e9 1000", "a width and height from 1 to 32766 px");
  with(4, "120 90 0", "from 1 to 1000000 depth units a metre");
  with(4, "120 90 -1000", "from 1 to 1000000 depth units a metre");
  with(4, "120 90 nan", "a finite number for " + image);
  with(4, "50 90 1000", "an image in which the principal point cx cy is");
  expect_error_in("camera.txt", {plain_camera[1]}, ":1: end of file", image);
  expect_error_in("camera.txt", {"# nothing"}, ":1: end of file", lens);
  expect_error_in("camera.txt", {plain_camera[1], plain_camera[3], "1"}, ":3: ", "not one more");
  for (const std::string distortion : {"1e300 0 0 0 0", "-1000 0 0 0 0", "0 0 1e5 0 0"}) {
    expect_error_in("camera.txt", {"100 101 59.5 44.5 " + distortion, plain_camera[3]}, ": ",
                    "intrinsics and a distortion that can be removed");
  }
  fs::remove(path("camera.txt"));
  expect_error("camera.txt: ", "a readable camera file with the lines " + lens + " and " + image);
}

TEST_F(RgbdFolder, tells_what_is_wrong_with_lists) {
  const std::string file = "associations.txt";
  const auto with = [&](std::size_t line, const std::string& text, const std::string& expected) {
    expect_error_with(file, associations, line, text, expected);
  };
  const std::string fields = "'timestamp rgb/FILE timestamp depth/FILE'";
  with(2, "10.00 rgb/0.png", "the 4 fields " + fields + ", not 2");
  with(2, "10.00 rgb/0.png 10.01", "the 4 fields " + fields + ", not 3");
  with(2, "rgb/0.png 10.00 depth/0.png 10.01", "a finite number for a time in s, not 'rgb/0.png'");
  with(3, "nan rgb/1.png 10.02 depth/1.png", "a finite number for a time in s, not 'nan'");
  with(3, "10.03 rgb/1.png inf depth/1.png", "a finite number for a time in s, not 'inf'");
  with(3, "10.00 rgb/1.png 10.02 depth/1.png", "a time later than the one before");
  with(3, "10.02 depth/1.png 9.00 rgb/1.png", "a time later than the one before");
  with(3, "10.03 rgb/1.png 10.02 rgb/2.png", fields);
  with(3, "10.03 depth/1.png 10.02 depth/2.png", fields);
  with(3, "10.03 1.png 10.02 1d.png", fields);
  with(2, std::string("10.00 rgb/0\0.png 10.01 depth/0.png", 35), "a file name without control characters");
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
  write("associations.txt", associations);
  expect_error_in("groundtruth.txt", {"1 2 3"}, ":1: ", "8 fields");
}

TEST_F(RgbdFolder, names_the_image_that_cannot_be_used) {
  const auto dataset = open_dataset(folder_);
  const auto expect_load_error = [&](const std::string& file, const cv::Mat& image, const std::string& expected) {
    const std::string good = read_bytes(path(file));
    write(file, image);
    expect_input_error([&] { dataset->load(1); }, path(file) + ": ", expected);
    write_bytes(path(file), good);
  };
  Random random;
  expect_load_error(colour(1), random_image(random, width, height + 1),
                    "is an image of 120 x 91 px; expected 120 x 90");
  expect_load_error(depth(1), random_depth(random, width - 1), "is an image of 119 x 90 px; expected 120 x 90");
  const std::string type = "expected depth in one channel of 16 bit";
  expect_load_error(depth(1), random_image(random, width, height), type);
  expect_load_error(depth(1), random_image(random, width, height, CV_8UC3), type);
  expect_load_error(depth(1), cv::Mat(height, width, CV_16UC3, cv::Scalar(1, 2, 3)), type);
  write_bytes(path(depth(1)), "no image");
  expect_input_error([&] { dataset->load(1); }, path(depth(1)) + ": ", "expected a whole image");
  fs::remove(path(depth(1)));
  expect_input_error([&] { dataset->load(1); }, path(depth(1)) + ": ", "expected an image file");
  EXPECT_TRUE(same(dataset->load(2).left, colours_[2])) << "the others still are what they were";
  write(depth(1), depths_[1]);

  const cv::Mat metres(height, width, CV_32F, cv::Scalar(std::nan("")));  // which PNG does not hold
  ASSERT_TRUE(cv::imwrite(path("depth/0.tiff"), metres));
  write("associations.txt", Lines{"10.00 rgb/0.png 10.01 depth/0.tiff"});
  expect_error("depth/0.tiff: is an image of type CV_32FC1; ", type);
  write("associations.txt", associations);
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

// ---- Distortion: an oracle of the camera

struct DistortedCamera {
  double fx, fy, cx, cy, k1, k2, p1, p2, k3;

  Eigen::Vector2d project(const Eigen::Vector3d& p) const {
    const double x = p.x() / p.z(), y = p.y() / p.z(), r2 = x * x + y * y;
    const double radial = 1 + k1 * r2 + k2 * r2 * r2 + k3 * r2 * r2 * r2;
    return {fx * (x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)) + cx,
            fy * (y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y) + cy};
  }
};

class DistortedRgbd : public RgbdFolder, public ::testing::WithParamInterface<DistortedCamera> {
 protected:
  static constexpr int columns = 320;
  static constexpr int rows = 240;

  DistortedRgbd() {
    const DistortedCamera& c = GetParam();
    write("camera.txt", {numbers({c.fx, c.fy, c.cx, c.cy, c.k1, c.k2, c.p1, c.p2, c.k3}), "320 240 5000"});
    write("associations.txt", Lines{"1.0 rgb/0.png 1.0 depth/0.png"});
  }

  // On a grid in the image, each at a depth of its own.
  std::vector<Eigen::Vector3d> points() const {
    Random random("points", 0);
    std::vector<Eigen::Vector3d> result;
    for (int v = -100; v <= 100; v += 25) {
      for (int u = -140; u <= 140; u += 28) {
        result.emplace_back(random.uniform(0.6, 6) * Eigen::Vector3d(u / GetParam().fx, v / GetParam().fy, 1));
      }
    }
    return result;
  }

  // A blob around each point, and its depth there.
  void draw() const {
    cv::Mat image(rows, columns, CV_64F, cv::Scalar(0)), depths(rows, columns, CV_16UC1, cv::Scalar(0));
    for (const Eigen::Vector3d& point : points()) {
      const Eigen::Vector2d z = GetParam().project(point);
      for (int y = std::max(0, static_cast<int>(z.y()) - 7); y <= std::min(rows - 1, static_cast<int>(z.y()) + 8);
           ++y) {
        for (int x = std::max(0, static_cast<int>(z.x()) - 7); x <= std::min(columns - 1, static_cast<int>(z.x()) + 8);
             ++x) {
          const double squared = (Eigen::Vector2d(x, y) - z).squaredNorm();
          image.at<double>(y, x) += 220 * std::exp(-squared / (2 * 1.3 * 1.3));
          if (squared < 9) depths.at<std::uint16_t>(y, x) = static_cast<std::uint16_t>(std::lround(5000 * point.z()));
        }
      }
    }
    image.convertTo(image, CV_8U);
    write(colour(0), image);
    write(depth(0), depths);
  }
};

TEST_P(DistortedRgbd, points_are_where_a_pinhole_has_them_and_as_far) {
  draw();
  const auto dataset = open_dataset(folder_);
  const PinholeCamera& camera = dataset->camera();
  const StereoImages images = dataset->load(0);
  std::size_t seen = 0;
  for (const Eigen::Vector3d& p : points()) {
    const Eigen::Vector2d z(camera.fx * p.x() / p.z() + camera.cx, camera.fy * p.y() / p.z() + camera.cy);
    const cv::Point pixel(cvRound(z.x()), cvRound(z.y()));
    if (!cv::Rect(6, 6, columns - 12, rows - 12).contains(pixel)) continue;
    ++seen;
    const cv::Moments m = cv::moments(images.left({pixel.x - 6, pixel.y - 6, 13, 13}));
    const Eigen::Vector2d middle(pixel.x - 6 + m.m10 / m.m00, pixel.y - 6 + m.m01 / m.m00);
    EXPECT_LT((middle - z).norm(), 0.15) << z.transpose();
    EXPECT_NEAR(static_cast<double>(images.depth.at<float>(pixel)), p.z(), 1e-4 + 1e-6) << z.transpose();
  }
  EXPECT_GT(seen, 60U);
}

TEST_P(DistortedRgbd, pixels_come_from_the_image_or_less_than_a_pixel_beside_it) {
  draw();
  const auto dataset = open_dataset(folder_);
  const PinholeCamera& camera = dataset->camera();
  double farthest = 0;  // px, beyond the middles of the outermost pixels
  for (int v = 0; v < rows; ++v) {
    for (int u = 0; u < columns; ++u) {
      const Eigen::Vector2d z = GetParam().project({(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1});
      farthest = std::max({farthest, -z.x(), -z.y(), z.x() - (columns - 1), z.y() - (rows - 1)});
    }
  }
  EXPECT_LT(farthest, 1);
}

TEST_P(DistortedRgbd, has_no_black_border_and_depth_never_between_two_sides) {
  cv::Mat depths(rows, columns, CV_16UC1, cv::Scalar(5000));
  depths.colRange(columns / 2, columns) = cv::Scalar(20000);
  write(colour(0), cv::Mat(rows, columns, CV_8UC1, cv::Scalar(200)));
  write(depth(0), depths);
  const StereoImages images = open_dataset(folder_)->load(0);
  EXPECT_TRUE(same(images.left, cv::Mat(rows, columns, CV_8UC1, cv::Scalar(200)))) << "no black border";
  EXPECT_EQ(cv::countNonZero(images.depth == 1) + cv::countNonZero(images.depth == 4), rows * columns);
}

INSTANTIATE_TEST_SUITE_P(Cameras, DistortedRgbd,
                         ::testing::Values(DistortedCamera{258.7, 258.2, 159.3, 127.7, 0.262383, -0.953104, -0.005358,
                                                           0.002628, 1.163314},
                                           DistortedCamera{229.3, 228.6, 160, 118, -0.2834, 0.074, 0.0002, 2e-5, 0},
                                           DistortedCamera{250, 251, 159.5, 119.5, 0.1, 0, 0, 0, 0}));

// ---- Recorded data, where it is there

TEST(RealRgbd, tum_is_read_whole) {
  const std::string folder = data_folder() + "/tum_fr1_rpy_a";
  if (data_folder().empty() || !fs::is_directory(folder)) GTEST_SKIP() << no_real_frames;
  const auto dataset = open_dataset(folder);
  EXPECT_EQ(dataset->name(), "tum_fr1_rpy_a");
  ASSERT_EQ(dataset->size(), 120U);
  EXPECT_EQ(dataset->width(), 640);
  EXPECT_EQ(dataset->height(), 480);
  EXPECT_GT(dataset->camera().fx, 517) << "a crop of what was recorded, drawn larger";
  EXPECT_LT(dataset->camera().fx, 560);
  for (std::size_t i = 0; i < dataset->size(); ++i) {
    const StereoImages images = dataset->load(i);
    EXPECT_GT(cv::countNonZero(images.depth), 640 * 480 / 3) << i;
    double most = 0;
    cv::minMaxLoc(images.depth, nullptr, &most);
    EXPECT_LT(most, 13.2) << "what 16 bit hold, m";
    EXPECT_TRUE(dataset->truth(i).has_value()) << i;
  }
}

}  // namespace
}  // namespace maxlogdet::test
