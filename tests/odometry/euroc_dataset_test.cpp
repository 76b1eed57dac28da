// SPDX-License-Identifier: MIT
// The reader of EuRoC's layout.
#include "tests/odometry/dataset_folder.hpp"
#include "tests/odometry/distorted_camera.hpp"

#include <Eigen/LU>

namespace maxlogdet::test {
namespace {

// A camera with its sensor.yaml.
struct OracleCamera {
  DistortedCamera lens;
  Pose T_bs;

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
            "intrinsics: [" + numbers({lens.fx, lens.fy, lens.cx, lens.cy}, ", ") + "] #fu, fv, cu, cv",
            "distortion_model: radial-tangential",
            "distortion_coefficients: [" + numbers({lens.k1, lens.k2, lens.p1, lens.p2}, ", ") + "]"};
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
    left_ = {{229.3, 228.6, 183.6, 124.2, -0.28340811, 0.07395907, 0.00019359, 1.76187114e-05}, T_bs};
    const Pose T_lr = sim::exp_se3((sim::Vector6() << 0.11, 0.002, -0.001, -0.012, 0.02, 0.015).finished());
    right_ = {{228.8, 228.1, 190.0, 127.6, -0.28368365, 0.07451284, -0.00010473, -3.555907e-05}, T_bs * T_lr};
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

  // Points in front of the left camera of pair i, on a grid in its image, at depths of 1.5 to 6 m; world frame.
  std::vector<Eigen::Vector3d> points(std::size_t i) const {
    Random random("points", i);
    std::vector<Eigen::Vector3d> result;
    for (int v = -110; v <= 110; v += 22) {
      for (int u = -170; u <= 170; u += 34) {
        const Eigen::Vector3d ray(u / left_.lens.fx, v / left_.lens.fy, 1);
        result.emplace_back(true_pose(seconds(stamp(i))) * left_.T_bs * (random.uniform(1.5, 6) * ray));
      }
    }
    return result;
  }

  // Draws a blob around each point into the images of both cameras.
  void draw(std::size_t i) const {
    for (const auto& [name, camera] : {std::make_pair("cam0", left_), std::make_pair("cam1", right_)}) {
      cv::Mat image(height, width, CV_64F, cv::Scalar(0));
      const Pose T_sw = (true_pose(seconds(stamp(i))) * camera.T_bs).inverse();
      for (const Eigen::Vector3d& point : points(i)) draw_blob(image, camera.lens.project(T_sw * point));
      image.convertTo(image, CV_8U);
      write(std::string("mav0/") + name + "/data/" + std::to_string(stamp(i)) + ".png", image);
    }
  }

  OracleCamera left_, right_;
};

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
      EXPECT_LT((*left - z).norm(), 0.1) << "camera() and truth() belong to the left image";
      EXPECT_NEAR(left->y(), right->y(), 0.1) << "rows agree";
      EXPECT_NEAR(left->x() - right->x(), camera.bf / p.z(), 0.1) << "disparity";
    }
  }
  EXPECT_GT(seen, 60 * pair_count);
}

// Rectification turns about the camera, by the same rotation in all frames.
TEST_F(EurocFolder, truth_of_either_file_is_the_bodys_and_not_known_in_gaps) {
  // It begins after image 0, has a gap around image 2, and ends before image 3.
  Lines lines = asl_truth(stamp(0) + 7 * ms, stamp(1) + 20 * ms, 10 * ms);
  const Lines rest = asl_truth(stamp(3) - 22 * ms, stamp(3) - 2 * ms, 10 * ms);
  lines.insert(lines.end(), rest.begin() + 1, rest.end());
  write("mav0/state_groundtruth_estimate0/data.csv", lines);
  const auto gapped = open_dataset(folder_);
  for (std::size_t i = 0; i < pair_count; ++i) EXPECT_EQ(gapped->truth(i).has_value(), i == 1 || i == 2) << "77 ms";

  Lines tum;  // the same trajectory at 40 Hz, at other times than the images
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
  const Pose T_bc = true_pose(0).inverse() * *dataset->truth(0);
  EXPECT_LT((T_bc.translation() - left_.T_bs.translation()).norm(), 1e-6);
  for (std::size_t i = 1; i < pair_count; ++i) {
    ASSERT_TRUE(dataset->truth(i).has_value());
    EXPECT_TRUE(dataset->truth(i)->isApprox(true_pose(seconds(stamp(i))) * T_bc, 1e-6))
        << "0.2 us is the resolution of the stamps";
  }
  EXPECT_TRUE(gapped->truth(1)->isApprox(*dataset->truth(1), 1e-6));
}

TEST_F(EurocFolder, opens_mav0_itself_under_the_same_name) {
  const auto dataset = open_dataset(path("mav0"));
  EXPECT_EQ(dataset->name(), fs::path(folder_).filename().string());
  EXPECT_EQ(dataset->size(), pair_count);
  EXPECT_TRUE(same(dataset->load(1).right, open_dataset(folder_)->load(1).right));
}

const std::string sensor_file = "mav0/cam1/sensor.yaml";

TEST_F(EurocFolder, tells_what_is_wrong_with_a_value_of_a_sensor_file) {
  const std::string intrinsics = "4 finite numbers: intrinsics", sides = "a width and height from 1 to 32766 px";
  expect_errors(sensor_file, right_.yaml(),
                {{11, "camera_model: omni", "camera_model 'pinhole', not 'omni'"},
                 {11, "camera_model: \"pin\\nhole\"", "camera_model 'pinhole', not 'pin?hole'"},
                 {3, "comment: \"\\\x01\"", "YAML; unknown escape character: ?"},
                 {13, "distortion_model: equidistant", "distortion_model 'radial-tangential', not 'equidistant'"},
                 {12, "intrinsics: [458, 457, 367]", intrinsics},
                 {12, "intrinsics: 458", intrinsics},
                 {12, "intrinsics: [458, abc, 367, 248]", intrinsics},
                 {12, "intrinsics: [458, .nan, 367, 248]", intrinsics},
                 {12, "intrinsics: [-458, 457, 367, 248]", "positive focal lengths"},
                 {14, "distortion_coefficients: [0.1, 0.1]", "4 finite numbers: distortion_coefficients"},
                 {10, "resolution: [752.5, 480]", sides},
                 {10, "resolution: [1000000, 480]", sides},
                 {10, "resolution: [0, 480]", sides},
                 {10, "resolution: [[1, 2], 480]", "2 finite numbers: resolution"}});
}

TEST_F(EurocFolder, tells_what_is_wrong_with_the_structure_of_a_sensor_file) {
  const auto with_line = [&](std::size_t line, const std::string& text) {
    Lines lines = right_.yaml();
    lines.at(line - 1) = text;
    return lines;
  };
  expect_error_in(sensor_file, with_line(9, "rate_hz: [20"), ":10: ", "YAML");  // its end is missed on the next line
  Lines nested = right_.yaml();
  nested.push_back("nested: " + std::string(1000000, '['));
  expect_error_in(sensor_file, nested, ":", "YAML");
  for (const std::size_t line : {4U, 10U, 11U, 12U, 13U, 14U}) {
    const std::string field = right_.yaml()[line - 1];
    expect_error_in(sensor_file, with_line(line, "x_" + field), ": ",
                    "expected a field '" + field.substr(0, field.find(':')) + "'");
  }
  for (const std::string k1 : {"1e300", "-1000"}) {
    expect_error_in(sensor_file, with_line(14, "distortion_coefficients: [" + k1 + ", 0, 0, 0]"), ": ",
                    "that can be rectified with cam0's");
  }
  expect_error_in(sensor_file, with_line(10, "resolution: [375, 240]"), ": ", "expected the resolution that cam0 has");
  expect_error_in(sensor_file, {}, ": ", "expected a sensor file");
  expect_error_in(sensor_file, {"%YAML:1.0", "- 1"}, ": ", "expected a sensor file");
  fs::remove(path(sensor_file));
  expect_error(sensor_file + ": ", "cannot be opened; expected a sensor file");
}

TEST_F(EurocFolder, tells_what_is_wrong_with_a_pose_of_a_sensor_file) {
  const auto with_pose = [&](const Pose& T_bs, const std::string& place, const std::string& expected) {
    OracleCamera camera = right_;
    camera.T_bs = T_bs;
    expect_error_in(sensor_file, camera.yaml(), place, expected);
  };
  Pose stretched = right_.T_bs;
  stretched.linear() *= 1.01;
  with_pose(stretched, ":5: ", "a rigid transform, sensor to body, as T_BS");
  for (const Eigen::Vector3d& p : {Eigen::Vector3d(0, 0, 0), {-0.11, 0, 0}, {0, 0.11, 0}, {0.1, 0.06, 0}}) {
    with_pose(left_.T_bs * Eigen::Translation3d(p), ": ", "a T_BS that puts cam1 to the right of cam0");
  }
  Lines projective = right_.yaml();
  projective[7] = "         0, 1, 0, 0, 0, 0, 0, 2]";
  expect_error_in(sensor_file, projective, ":5: ", "a rigid transform");
}

TEST_F(EurocFolder, names_the_stamp_without_partner) {
  const std::int64_t s0 = stamp(0), s1 = stamp(1), s2 = stamp(2), s3 = stamp(3), between = s0 + 20 * ms;
  const struct {
    std::vector<std::int64_t> right;
    const char* file;
    std::int64_t alone;
  } cases[] = {{{s0, s1, s3}, "cam0", s2},
               {{s0, s1, s2}, "cam0", s3},
               {{s0, between, s1, s2, s3}, "cam1", between},
               {{s0, s1, s2, s3, stamp(4)}, "cam1", stamp(4)},
               {{s0, s1, s2, s3 + ms + 1}, "cam0", s3}};
  for (const auto& one : cases) {
    write("mav0/cam1/data.csv", list(one.right));
    const std::string stamp = "/data.csv: stamp " + std::to_string(one.alone);
    expect_error(std::string("mav0/") + one.file + stamp + " has no partner", "expected one within 1 ms in");
  }
  write("mav0/cam1/data.csv", Lines{std::to_string(s0 - ms) + "," + std::to_string(s0) + ".png"});
  write("mav0/cam0/data.csv", list({s0}));
  EXPECT_EQ(open_dataset(folder_)->size(), 1U) << "1 ms apart";
}

TEST_F(EurocFolder, tells_what_is_wrong_with_lists_images_and_truth) {
  const std::string file = "mav0/cam0/data.csv";
  const std::string stamps_rise = "a stamp in ns, later than the one before, not ";
  expect_errors(file, {"#timestamp [ns],filename", "1403636579763555584,a.png", "1403636579763555590,b.png"},
                {{2, "1403715273262142976", "the fields stamp,filename, not 1"},
                 {2, "12e3,a.png", stamps_rise + "'12e3'"},
                 {2, "-1,a.png", stamps_rise + "'-1'"},
                 {3, "12,b.png", stamps_rise + "'12'"},
                 // In seconds, float64 cannot distinguish these times.
                 {3, "1403636579763555584,b.png", stamps_rise + "'1403636579763555584'"}});
  expect_error_in(file, {std::string("12,a\0.png", 10)}, ":1: ", "a file name without control characters");
  expect_error_in(file, {"#timestamp [ns],filename"}, ":1: end of file", "at least one image: stamp,filename");
  fs::remove(path(file));
  expect_error(file + ": ", "cannot be opened; expected a readable list of images");
  write(file, list({stamp(0), stamp(1), stamp(2), stamp(3)}));

  const std::string truth = "mav0/state_groundtruth_estimate0/data.csv";
  expect_error_in(truth, {std::to_string(first_stamp) + ",1,2,3,1,0,0,1"}, ":1: ", "q_w,q_x,q_y,q_z of norm 1");
  write(truth, Lines{std::to_string(first_stamp - 10 * ms) + ",-1.7e308,0,0,1,0,0,0",
                     std::to_string(first_stamp + 10 * ms) + ",1.7e308,0,0,1,0,0,0"});
  expect_input_error([&] { open_dataset(folder_); }, folder_ + ": ", "float64 can hold the camera's place");
  fs::remove(path(truth));
  expect_error_in("ground_truth.txt", {"1 2 3"}, ":1: ", "8 fields");
  fs::remove(path("ground_truth.txt"));

  Random random;
  for (const char* camera : {"mav0/cam1", "mav0/cam0"}) {
    const std::string first = camera + ("/data/" + std::to_string(stamp(0)) + ".png");
    write(first, random_image(random, width + 1, height));
    expect_error(first + ": ", "is an image of 377 x 240 px; expected 376 x 240 px");
    fs::remove(path(first));
    expect_error(first + ": ", "is missing; expected an image");
  }
}

TEST_F(EurocFolder, damaged_files_are_read_or_refused) {
  const std::string truth = "mav0/state_groundtruth_estimate0/data.csv";
  write(truth, asl_truth(first_stamp, stamp(pair_count), 20 * ms));
  expect_no_crash_of_damaged_files(
      folder_, {"mav0/cam0/sensor.yaml", "mav0/cam1/sensor.yaml", "mav0/cam1/sensor.yaml", "mav0/cam1/data.csv", truth},
      400);
}

}  // namespace
}  // namespace maxlogdet::test
