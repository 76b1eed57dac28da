// SPDX-License-Identifier: MIT
// The program from the outside: the files it writes, its output, and its refusals.
#include "bench/does_it_help/report.hpp"
#include "bench/world/feature_selector.hpp"
#include "bench/world/frame_reader.hpp"
#include "bench/world/trajectory.hpp"
#include "tests/odometry/rendered_world.hpp"
#include "tests/support/program.hpp"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <set>

namespace maxlogdet::test {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t frames = 5;

// A rendered sequence in KITTI's layout, in the subfolder `images` of the working folder.
class StereoProgram : public Program {
 protected:
  StereoProgram() {
    const RenderedWorld world;
    for (const char* const side : {"l", "r"}) fs::create_directories(path(std::string("images/image_") + side));
    std::ofstream poses(path("images/poses.txt"));
    poses.precision(17);
    for (std::size_t i = 0; i < frames; ++i) {
      const sim::Pose T_wc = RenderedWorld::T_wc(i);
      const stereo_odometry::StereoImages images = world.images(T_wc);
      write_image(image("l", i), images.left);
      write_image(image("r", i), images.right);
      for (int n = 0; n < 12; ++n) poses << T_wc.matrix()(n / 4, n % 4) << (n < 11 ? ' ' : '\n');
    }
    write("images/calib.txt", "300 0 239.5 0 0 300 159.5 0 0 0 1 0\n300 0 239.5 -90 0 300 159.5 0 0 0 1 0\n");
  }

  static std::string image(const std::string& side, std::size_t i) {
    return "images/image_" + side + "/00000" + std::to_string(i) + ".png";
  }

  void write(const std::string& file, const std::string& text) const { std::ofstream(path(file)) << text; }

  void write_image(const std::string& file, const cv::Mat& pixels) const {
    ASSERT_TRUE(cv::imwrite(path(file), pixels)) << file;
  }

  // Few features, to save time.
  Outcome track(const std::string& arguments) const {
    return run("--dataset images --output results --features 500 --runs 1 " + arguments);
  }

  // libpng, with which OpenCV reads images, prints its own messages about broken ones first.
  void expect_refused(Outcome outcome, const std::string& message) const {
    while (outcome.err.rfind("libpng ", 0) == 0) outcome.err.erase(0, outcome.err.find('\n') + 1);
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_EQ(outcome.out, "") << "no partial output";
    EXPECT_EQ(outcome.err.rfind("stereo_odometry: ", 0), 0U) << outcome.err;
    EXPECT_NE(outcome.err.find(message), std::string::npos) << outcome.err << "\ndoes not contain: " << message;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_LT(outcome.err.size(), message.size() + 300) << outcome.err;
    EXPECT_FALSE(fs::exists(path("results/summary.json")));
  }

  nlohmann::json summary() const { return nlohmann::json::parse(text_of(path("results/summary.json"))); }

  std::size_t lines_of(const std::string& file) const {
    const std::string text = text_of(path("results/" + file));
    return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
  }
};

std::vector<std::string> selectors() {
  std::vector<std::string> names = sim::names_of(sim::selector_kinds);
  names.insert(names.end(), {"active", "active_random"});
  return names;
}

// Expects the entry of a selector with two runs and a budget of 60.
void expect_complete(const nlohmann::json& entry) {
  const auto kind = sim::find_named(sim::selector_kinds, std::string(entry.at("selector")));
  if (!kind || has_budget(*kind)) {
    EXPECT_EQ(entry.at("budget"), 60);
    EXPECT_LE(entry.at("selected"), 60);
  } else {
    EXPECT_TRUE(entry.at("budget").is_null());
  }
  EXPECT_EQ(entry.at("runs"), 2);
  EXPECT_EQ(entry.at("tracked_percent"), 100);
  for (const char* const key : {"ate_m", "rpe_m_per_s", "roe_deg_per_s"}) EXPECT_GT(entry[key], 0) << key;
  EXPECT_LT(entry.at("ate_m"), 0.02);
  for (const char* const stage : {"base", "matching", "selection", "pose_optimization"}) {
    EXPECT_GE(entry.at("ms")[stage], 0) << stage;
  }
  EXPECT_GT(entry.at("ms").at("total"), 0);
}

TEST_F(StereoProgram, compares_all_selectors_and_writes_what_its_help_promises) {
  const Outcome outcome = run("--dataset images --output results --features 500 --runs 2 --budget 60 --overlays 2 " +
                              ("--selectors " + sim::joined(selectors(), ",")));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  EXPECT_EQ(draw("results").exit_code, 0);
  for (const char* const ending : {".svg", ".png"}) {
    EXPECT_TRUE(fs::exists(path(std::string("results/trajectory") + ending))) << ending;
  }
  EXPECT_EQ(text_of(path("results/summary.md")), outcome.out) << "the same text";
  const nlohmann::json list = summary();
  ASSERT_TRUE(list.is_array());
  std::vector<std::string> names;
  for (const nlohmann::json& entry : list) {
    names.push_back(entry.at("selector"));
    SCOPED_TRACE(names.back());
    expect_complete(entry);
    EXPECT_NE(outcome.out.find("| " + names.back()), std::string::npos) << outcome.out;
    EXPECT_EQ(sim::read_tum(path("results/" + names.back() + "/trajectory_tum.txt")).poses.size(), frames);
    EXPECT_EQ(lines_of(names.back() + "/trajectory_kitti.txt"), frames);
    EXPECT_EQ(lines_of(names.back() + "/frames.csv"), frames + 1);
    for (std::size_t i = 0; i < frames; ++i) {
      const std::string overlay = path("results/" + names.back() + "/overlay_00000" + std::to_string(i) + ".png");
      EXPECT_EQ(fs::exists(overlay), i % 2 == 0) << "every second one";
      if (i % 2 == 0) {
        EXPECT_EQ(cv::imread(overlay).size(), cv::Size(480, 320));
      }
    }
  }
  EXPECT_EQ(names, selectors());
}

TEST_F(StereoProgram, does_one_selector_with_several_budgets_on_the_first_frames) {
  const Outcome outcome = track("--selectors md,inl --budget 30,80 --frames 3 --overlays 0");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const nlohmann::json list = summary();
  ASSERT_EQ(list.size(), 3U);
  EXPECT_EQ(list[0].at("budget"), 30);
  EXPECT_EQ(list[1].at("budget"), 80);
  EXPECT_LT(list[0].at("selected"), list[1].at("selected"));
  EXPECT_TRUE(list[2].at("budget").is_null());
  for (const char* const name : {"md_30", "md_80", "inl"}) {
    EXPECT_EQ(lines_of(std::string(name) + "/trajectory_kitti.txt"), 3U);
    EXPECT_FALSE(fs::exists(path(std::string("results/") + name + "/overlay_000000.png")));
  }
}

TEST_F(StereoProgram, gives_the_same_trajectory_every_time_whatever_the_threads) {
  std::string expected;
  for (const char* const threads : {"1", "1", "2"}) {
    ASSERT_EQ(
        track("--selectors md,random,active --budget 40 --overlays 0 --threads " + std::string(threads)).exit_code, 0);
    std::string all;
    for (const char* const name : {"md", "random", "active"}) {
      all += text_of(path(std::string("results/") + name + "/trajectory_kitti.txt"));
    }
    if (expected.empty()) expected = all;
    EXPECT_EQ(all, expected);
  }
  ASSERT_EQ(track("--selectors random --budget 40 --overlays 0 --seed 1").exit_code, 0);
  EXPECT_EQ(expected.find(text_of(path("results/random/trajectory_kitti.txt"))), std::string::npos)
      << "other random numbers";
}

TEST_F(StereoProgram, tells_frames_that_show_nothing_and_goes_on) {
  write_image(image("l", 2), RenderedWorld::blank().left);
  const Outcome outcome = track("--selectors inl --overlays 1");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.err.rfind("stereo_odometry: inl: frame 2: ", 0), 0U) << outcome.err;
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  EXPECT_NEAR(summary()[0].at("tracked_percent"), 80, 1e-9);
}

TEST_F(StereoProgram, refuses_arguments_that_make_no_sense) {
  expect_refused(run(""), "--dataset");
  expect_refused(run("--dataset images"), "--output");
  const std::pair<const char*, const char*> bad[] = {
      {"--selectors best", "best"},
      {"--strategy fastest", "fastest"},
      {"--weighting none", "--weighting"},
      {"--residuals both", "--residuals"},
      {"--record ''", "--record"},
      {"--bogus", "--bogus"},
      {"--tau 1", "--tau"},
      {"--slack 3", "--slack"},
      {"--noise constant --noise-growth 0.1", "--noise-growth"},
      {"--selectors inl --budget 50", "--budget does nothing here; expected with it "},
      {"--selectors random --strategy greedy", "--strategy does nothing here; expected with it "},
      {"--selectors md --epsilon 0.2", "--epsilon does nothing here; expected with it "},
      {"--selectors random --weighting measurement", "--weighting does nothing here; expected with it "},
      {"--selectors md --batch 4", "--batch does nothing here; expected with it "},
      {"--selectors md --pool 150", "--pool does nothing here; expected with it "},
      {"--selectors inl,md --strategy greedy --epsilon 0.2", "--epsilon does nothing here; expected with it "}};
  for (const auto& [arguments, message] : bad) expect_refused(track(arguments), message);
  const std::pair<const char*, std::vector<const char*>> bad_values[] = {
      {"--budget", {"0", "-5", "many", "100,0", "''"}},
      {"--selectors", {"''"}},
      {"--threads", {"0"}},
      {"--frames", {"-1", "''"}},
      {"--overlays", {"-1"}},
      {"--pool", {"-1", "''"}},
      {"--seed", {"''"}},
      {"--weighting", {"''"}},
      {"--epsilon", {"''"}}};
  for (const auto& [option, values] : bad_values) {
    for (const char* const value : values) expect_refused(track(option + (" " + std::string(value))), option);
  }
  expect_refused(run("--dataset images --output results --runs 0"), "--runs");
  expect_refused(run("--dataset images --output results --features 5"), "--features");
  const Outcome help = run("--help");
  EXPECT_EQ(help.exit_code, 0);
  EXPECT_NE(help.out.find("--dataset"), std::string::npos);
}

TEST_F(StereoProgram, refuses_datasets_that_are_not_whole) {
  expect_refused(run("--dataset nowhere --output results"), "nowhere: is not a folder");
  fs::create_directories(path("empty"));
  expect_refused(run("--dataset empty --output results"), "empty: holds no stereo images");

  write(image("r", 3), "no picture");
  expect_refused(track("--selectors md"), "image_r/000003.png: cannot be read");
  fs::remove(path(image("r", 3)));
  expect_refused(track("--selectors md"), "image_l/000003.png: has no partner");
  write("images/calib.txt", "300 0 239.5 0 0 oops\n");
  expect_refused(track("--selectors md"), "images/calib.txt:1: ");
}

TEST_F(StereoProgram, refuses_an_output_folder_that_cannot_be_made) {
  write("file", "");
  expect_refused(run("--dataset images --output file/results --selectors md"), "file/results");
  expect_refused(run("--dataset images --output file --selectors md"), "file: cannot be made");
}

// Numbers within rounding, because a file has 1 / sigma^2 where the tracker has sigma.
void expect_same(const nlohmann::json& a, const nlohmann::json& b, const std::string& place) {
  if (a.is_number() && b.is_number()) {
    EXPECT_NEAR(a.get<double>(), b.get<double>(), 1e-6 * std::abs(a.get<double>())) << place;
  } else if (a.is_structured()) {
    ASSERT_EQ(a.size(), b.size()) << place;
    for (const auto& [key, value] : a.items()) {
      expect_same(value, a.is_object() ? b.at(key) : b.at(std::stoul(key)), place + '/' + key);
    }
  } else {
    EXPECT_EQ(a, b) << place;
  }
}

TEST_F(StereoProgram, compares_on_the_same_frames_what_it_records) {
  for (const std::string options : {"", "--weights measurement --residuals monocular"}) {
    SCOPED_TRACE(options);
    const std::string folder = options.empty() ? "recorded" : "recorded/monocular";
    const Outcome outcome = track("--selectors md --overlays 0 --record " + folder + " " + options);
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    const auto written = nlohmann::json::parse(text_of(path("results/same_frame.json")));
    EXPECT_EQ(written.at("frames"), frames - 1) << "the first begins the map";
    EXPECT_NE(outcome.out.find(std::string(written.at("verdict"))), std::string::npos);
    const std::vector<sim::Frame> recorded = sim::read_frames(path(folder));
    sim::EvaluationOptions how;
    how.weighting = options.empty() ? Weighting::measurement_and_map : Weighting::measurement;
    expect_same(written, nlohmann::json::parse(to_json(evaluate({recorded}, how, 1)).dump()), "same_frame.json");
    for (const sim::Frame& frame : recorded) {
      EXPECT_TRUE(frame.T_cw_true && frame.has_quality && frame.has_selection);
      EXPECT_EQ(frame.width, RenderedWorld::width);
      EXPECT_EQ(frame.camera.depth_cue() == DepthCue::stereo, options.empty());
      EXPECT_EQ(frame.map_covariances.size(), frame.matches.size());
    }
  }
}

TEST_F(StereoProgram, compares_orders_of_matching_on_the_same_frames) {
  ASSERT_EQ(track("--selectors active_random --budget 60 --overlays 0").exit_code, 0);
  EXPECT_EQ(summary()[1].at("selector"), "inl") << "always";
  const auto list = nlohmann::json::parse(text_of(path("results/matching.json")));
  std::set<std::string> orders;
  for (const auto& entry : list) {
    orders.insert(entry.at("order"));
    EXPECT_LE(entry.at("frames"), frames - 1) << "those with more inliers than the budget";
    EXPECT_EQ(entry.at("frames") == frames - 1, entry.at("budget") <= 100);
    EXPECT_LE(entry.at("matched"), entry.at("budget"));
    EXPECT_GE(entry.at("searched"), entry.at("matched"));
    EXPECT_LE(entry.at("translation_mm").at("low"), entry.at("translation_mm").at("high"));
    EXPECT_EQ(entry.contains("rotation_of_random_order"), entry.at("order") == "active");
  }
  EXPECT_EQ(orders, std::set<std::string>({"active", "active_random", "md", "random"}));
}

TEST_F(StereoProgram, compares_nothing_where_nothing_is_tracked) {
  const Outcome outcome = track("--selectors md --frames 1 --overlays 0");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("inl tracks no frame"), std::string::npos) << outcome.err;
  EXPECT_FALSE(fs::exists(path("results/same_frame.json")));
}

TEST_F(StereoProgram, mixes_no_recordings) {
  fs::create_directories(path("recorded"));
  write("recorded/frame_000007.csv", "");
  expect_refused(track("--record recorded"), "recorded: holds frame_000007.csv; expected a folder without");
  write("file", "");
  expect_refused(track("--record file"), "file: cannot be made");
}

TEST_F(StereoProgram, writes_residuals) {
  ASSERT_EQ(track("--selectors inl --frames 4 --write-residuals --noise online").exit_code, 0);
  EXPECT_GT(lines_of("inl/residuals.csv"), 300U);
}

TEST_F(StereoProgram, noise_is_used) {
  const auto errors_with = [&](const std::string& noise) {
    EXPECT_EQ(track("--selectors inl --frames 5 " + noise).exit_code, 0);
    return summary()[0].at("rpe_m_per_s").get<double>();
  };
  const double motion = errors_with("");
  EXPECT_EQ(motion, errors_with("--noise motion"));
  EXPECT_NE(motion, errors_with("--noise constant"));
  EXPECT_NE(motion, errors_with("--noise online"));
  EXPECT_NE(motion, errors_with("--noise-growth 0.3"));
  EXPECT_NE(motion, errors_with("--weights measurement"));
}

}  // namespace
}  // namespace maxlogdet::test
