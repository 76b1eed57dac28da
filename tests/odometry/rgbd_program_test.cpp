// SPDX-License-Identifier: MIT
// The program on RGB-D folders: its results, and its refusals.
#include "tests/odometry/rendered_world.hpp"
#include "tests/support/program.hpp"

#include <Eigen/Geometry>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <string>

namespace maxlogdet::test {
namespace {

// Writes the first frames of the rendered world in the layout of TUM RGB-D, 30 Hz, with ground truth that begins
// before them; 1000 depth units per metre.
void write_rendered_rgbd(const std::string& folder, std::size_t frames) {
  const RenderedWorld world;
  for (const char* const kind : {"rgb", "depth"}) std::filesystem::create_directories(folder + "/" + kind);
  std::ofstream(folder + "/camera.txt") << "300 300 239.5 159.5 0 0 0 0\n480 320 1000\n";
  std::ofstream associations(folder + "/associations.txt"), truth(folder + "/groundtruth.txt");
  associations.precision(17);
  truth.precision(17);
  for (std::size_t i = 0; i < frames; ++i) {
    const std::string file = std::to_string(i) + ".png";
    const double time = 100 + static_cast<double>(i) / 30;
    const stereo_odometry::StereoImages images = world.depth_images(RenderedWorld::T_wc(i));
    cv::Mat depth;
    images.depth.convertTo(depth, CV_16U, 1000);
    ASSERT_TRUE(cv::imwrite(folder + "/rgb/" + file, images.left));
    ASSERT_TRUE(cv::imwrite(folder + "/depth/" + file, depth));
    associations << time << " rgb/" << file << ' ' << time + 0.004 << " depth/" << file << '\n';
    // Exact at the times of the frames.
    const sim::Pose T_wc = RenderedWorld::T_wc(i);
    const Eigen::Quaterniond q(T_wc.linear());
    const Eigen::Vector3d p = T_wc.translation();
    for (const double t : {time - 0.005, time, time + 0.005}) {
      truth << t << ' ' << p.x() << ' ' << p.y() << ' ' << p.z() << ' ' << q.x() << ' ' << q.y() << ' ' << q.z() << ' '
            << q.w() << '\n';
    }
  }
}

constexpr std::size_t frames = 5;

class RgbdProgram : public Program {
 protected:
  RgbdProgram() { write_rendered_rgbd(path("images"), frames); }

  Outcome track(const std::string& arguments) const {
    return run("--dataset images --output results --overlays 0 --runs 1 " + arguments);
  }

  nlohmann::json summary() const { return nlohmann::json::parse(text_of(path("results/summary.json"))); }
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
  const cv::Size size(RenderedWorld::width, RenderedWorld::height);
  ASSERT_TRUE(cv::imwrite(path("images/rgb/2.png"), RenderedWorld::blank().left));
  ASSERT_TRUE(cv::imwrite(path("images/depth/3.png"), cv::Mat(size, CV_16U, cv::Scalar(0))));
  const Outcome outcome = track("--selectors inl --features 500");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.err.rfind("stereo_odometry: inl: frame 2: ", 0), 0U) << outcome.err;
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  EXPECT_NEAR(summary()[0].at("tracked_percent"), 80, 1e-9);
}

TEST_F(RgbdProgram, refuses_bad_folders_with_one_line) {
  std::filesystem::remove(path("images/camera.txt"));
  const Outcome outcome = track("--selectors md");
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_EQ(outcome.out, "") << "no partial output";
  EXPECT_EQ(outcome.err.rfind("stereo_odometry: images/camera.txt: cannot be opened; expected a readable", 0), 0U);
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  EXPECT_FALSE(std::filesystem::exists(path("results/summary.json")));
}

class RealRgbdProgram : public Program {};

// A camera turned by hand, by up to 6 deg per frame: from frame 100 on images are blurred, and tracking may get lost.
TEST_F(RealRgbdProgram, tracks_a_recorded_clip) {
  const std::string clip = std::filesystem::absolute(data_folder() + "/tum_fr1_rpy_a").string();
  if (data_folder().empty() || !std::filesystem::is_directory(clip)) GTEST_SKIP() << no_real_frames;
  const Outcome outcome = run("--dataset '" + clip + "' --output results --overlays 0 --runs 1 --selectors md,inl");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  for (const nlohmann::json& entry : nlohmann::json::parse(text_of(path("results/summary.json")))) {
    SCOPED_TRACE(std::string(entry.at("selector")));
    EXPECT_GE(entry.at("tracked_percent"), 85);
    EXPECT_LT(entry.at("ate_m"), 0.1) << "typically 0.03";
    EXPECT_LT(entry.at("rpe_m_per_s"), 0.5)
        << "0.1 to 0.2; ground truth itself has errors of millimetres between frames";
    EXPECT_LT(entry.at("roe_deg_per_s"), 40) << "15 to 20, at up to 170 deg/s";
    std::istringstream rows(text_of(folder_ + "/results/" + std::string(entry.at("selector")) + "/frames.csv"));
    std::string row;
    std::getline(rows, row);
    for (std::size_t i = 0; i < 50 && std::getline(rows, row); ++i) {
      EXPECT_NE(row.find(i == 0 ? ",initialized," : ",tracked,"), std::string::npos) << row;
    }
  }
}

}  // namespace
}  // namespace maxlogdet::test
