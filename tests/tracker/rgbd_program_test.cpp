// SPDX-License-Identifier: MIT
// The program on RGB-D folders: its results, and its refusals.
#include "tests/support/program.hpp"
#include "tests/tracker/rgbd_folder.hpp"

#include <functional>

namespace maxlogdet::test {
namespace {

constexpr std::size_t frames = 5;

class RgbdProgram : public Program {
 protected:
  RgbdProgram() { write_rendered_rgbd(path("images"), frames); }

  std::string path(const std::string& file) const { return folder_ + "/" + file; }
  void write(const std::string& file, const std::string& text) const { std::ofstream(path(file)) << text; }

  void write_image(const std::string& file, const cv::Mat& pixels) const {
    ASSERT_TRUE(cv::imwrite(path(file), pixels)) << file;
  }

  Outcome track(const std::string& arguments, const std::string& dataset = "images") const {
    return run("--dataset '" + dataset + "' --output results --overlays 0 --runs 1 " + arguments);
  }

  nlohmann::json summary() const { return nlohmann::json::parse(contents_of(path("results/summary.json"))); }

  void expect_refused(const std::string& message) const {
    Outcome outcome = track("--selectors md --features 300");
    while (outcome.err.rfind("libpng ", 0) == 0) outcome.err.erase(0, outcome.err.find('\n') + 1);
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_EQ(outcome.out, "") << "no partial output";
    EXPECT_EQ(outcome.err.rfind("stereo_odometry: images", 0), 0U) << outcome.err;
    EXPECT_NE(outcome.err.find(message), std::string::npos) << outcome.err << "\ndoes not contain: " << message;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_FALSE(std::filesystem::exists(path("results/summary.json")));
  }
};

TEST_F(RgbdProgram, tracks_a_rendered_folder) {
  const Outcome outcome = track("--selectors md,inl,active --features 500 --budget 60");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const nlohmann::json list = summary();
  ASSERT_EQ(list.size(), 3U);
  for (const nlohmann::json& entry : list) {
    SCOPED_TRACE(std::string(entry.at("selector")));
    EXPECT_EQ(entry.at("tracked_percent"), 100);
    EXPECT_LT(entry.at("ate_m"), 0.02);
    EXPECT_GT(entry.at("rpe_m_per_s"), 0);
  }
}

TEST_F(RgbdProgram, tells_of_black_frames_and_counts_them_but_does_without_depth) {
  write_image("images/rgb/2.png", RenderedWorld::blank().left);
  write_image("images/depth/3.png", cv::Mat(RenderedWorld::height, RenderedWorld::width, CV_16U, cv::Scalar(0)));
  const Outcome outcome = track("--selectors inl --features 500");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.err.rfind("stereo_odometry: inl: frame 2: ", 0), 0U) << outcome.err;
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  EXPECT_NEAR(summary()[0].at("tracked_percent"), 80, 1e-9);
}

TEST_F(RgbdProgram, gives_the_same_trajectory_whatever_the_threads) {
  std::string expected;
  for (const char* const threads : {"1", "2"}) {
    ASSERT_EQ(track("--selectors md --budget 40 --features 500 --threads " + std::string(threads)).exit_code, 0);
    const std::string trajectory = contents_of(path("results/md/trajectory_kitti.txt"));
    if (expected.empty()) expected = trajectory;
    EXPECT_EQ(trajectory, expected);
  }
}

TEST_F(RgbdProgram, refuses_bad_folders_with_one_line) {
  const auto with = [&](const std::string& file, const std::string& text, const std::string& message) {
    const std::string good = contents_of(path("images/" + file));
    write("images/" + file, text);
    expect_refused("images/" + file + message);
    write("images/" + file, good);
  };
  with("camera.txt", "300 300 239.5 159.5 0 0 0 0\n480 0 1000\n", ":2: expected a width and height");
  with("camera.txt", "300 nan 239.5 159.5 0 0 0 0\n480 320 1000\n", ":1: expected a finite number");
  with("associations.txt", "100 rgb/0.png\n", ":1: expected the 4 fields");
  with("associations.txt", "", ":0: end of file; expected at least one pair");
  with("rgb/0.png", "no image", ": cannot be read; expected a complete image file");
  with("depth/2.png", "no image", ": cannot be read; expected a complete image file");
  const std::string good = contents_of(path("images/depth/2.png"));
  write_image("images/depth/2.png", cv::Mat(RenderedWorld::height, RenderedWorld::width, CV_8U, cv::Scalar(9)));
  expect_refused("images/depth/2.png: is an image of type CV_8UC1; expected depth in one channel of 16 bit");
  write_image("images/depth/2.png", cv::Mat(RenderedWorld::height, 100, CV_16U, cv::Scalar(9)));
  expect_refused("images/depth/2.png: is an image of 100 x 320 px; expected 480 x 320 px");
  write("images/depth/2.png", good);
  std::filesystem::remove(path("images/depth/2.png"));
  expect_refused("images/depth/2.png: is missing; expected an image file");
  const cv::Mat none(RenderedWorld::height, RenderedWorld::width, CV_16U, cv::Scalar(0));
  for (std::size_t i = 0; i < frames; ++i) write_image("images/depth/" + std::to_string(i) + ".png", none);
  expect_refused("images/depth: expected depth other than 0");
  std::filesystem::remove(path("images/associations.txt"));
  expect_refused("images: holds no list of images; expected associations.txt, or rgb.txt and depth.txt");
  std::filesystem::remove(path("images/camera.txt"));
  expect_refused("images/camera.txt: cannot be opened; expected a readable camera file with the lines 'fx fy cx cy");
}

class RealRgbdProgram : public Program {};

// A camera turned by hand, by up to 6 deg per frame: from frame 100 on images are blurred, and tracking may get lost.
TEST_F(RealRgbdProgram, tracks_a_recorded_clip) {
  const std::string clip = std::filesystem::absolute(data_folder() + "/tum_fr1_rpy_a").string();
  if (data_folder().empty() || !std::filesystem::is_directory(clip)) GTEST_SKIP() << no_real_frames;
  const Outcome outcome = run("--dataset '" + clip + "' --output results --overlays 0 --runs 1 --selectors md,inl");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  for (const nlohmann::json& entry : nlohmann::json::parse(contents_of(folder_ + "/results/summary.json"))) {
    SCOPED_TRACE(std::string(entry.at("selector")));
    EXPECT_GE(entry.at("tracked_percent"), 85);
    EXPECT_LT(entry.at("ate_m"), 0.1) << "typically 0.03";
    EXPECT_LT(entry.at("rpe_m_per_s"), 0.5)
        << "0.1 to 0.2; ground truth itself has errors of millimetres between frames";
    EXPECT_LT(entry.at("roe_deg_per_s"), 40) << "15 to 20, at up to 170 deg/s";
    std::istringstream rows(contents_of(folder_ + "/results/" + std::string(entry.at("selector")) + "/frames.csv"));
    std::string row;
    std::getline(rows, row);
    for (std::size_t i = 0; i < 50 && std::getline(rows, row); ++i) {
      EXPECT_NE(row.find(i == 0 ? ",initialized," : ",tracked,"), std::string::npos) << row;
    }
  }
}

}  // namespace
}  // namespace maxlogdet::test
