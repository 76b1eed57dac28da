// SPDX-License-Identifier: MIT
// What GoodFeatures::record() writes reads back bit for bit; and that no problem with files changes
// a selection.
#include "kernel/frame_recorder.hpp"
#include "tests/core/feature_frame.hpp"
#include "tests/support/support.hpp"
#include "tests/support/text_folder.hpp"

#include <sys/resource.h>

#include <algorithm>
#include <clocale>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <locale>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace maxlogdet::test {
namespace {

const char* const first_frame = "frame_000000.csv";

std::vector<double> entries_of(const RigidTransform& T) { return {T.data(), T.data() + 12}; }

// Any kind that a file can hold, with matches that are odd, numbers of map points, and perhaps of keyframes.
FeatureFrame recordable_frame(Random& random, bool has_keyframes) {
  FeatureKind kind = random_kind(random);
  if (kind.depth_cue == DepthCue::stereo) kind.has_rig = false;
  if (kind.depth_cue == DepthCue::none && random.chance(0.3)) kind.depth_cue = DepthCue::depth;
  FeatureFrame frame(random, 120, kind);
  frame.make_odd(random, 0.2);
  for (double& entry : frame.covariances) entry = random.uniform(0, 1);
  for (FeatureMatch& match : frame.matches) {
    if (random.chance(0.7)) match.point_id = std::numeric_limits<std::int64_t>::max() - random.integer(0, 1000);
    if (has_keyframes && random.chance(0.7)) match.keyframe = random.integer(0, 1000);
  }
  return frame;
}

// The numbers of comments; a name that is missing has none.
void expect_comments(const RecordedFrame& recorded, const FeatureFrame& frame) {
  const bool has_rig = frame.kind.has_rig;
  const bool is_rectified = !has_rig && frame.kind.model == CameraModel::pinhole;
  std::map<std::string, std::vector<double>> expected = {
      {"Tcw_prior", entries_of(rows_of(frame.T_cw))}, {"fx,fy,cx,cy,bf", {}}, {"camera", {}}, {"depth_sigma", {}}};
  if (frame.kind.depth_cue == DepthCue::depth) expected["depth_sigma"] = {0.07};
  for (std::size_t c = 0; c < (has_rig ? 2 : 1); ++c) {
    const Camera& camera = frame.cameras[c];
    const std::string place = has_rig ? " " + std::to_string(c) : "";
    const std::string name = is_rectified ? "fx,fy,cx,cy,bf" : "camera" + place;
    const PinholeCamera& p = camera.pinhole;
    std::vector<double>& numbers = expected[name] = {p.fx, p.fy, p.cx, p.cy};
    if (is_rectified) numbers.push_back(p.bf);
    numbers.insert(numbers.end(), camera.parameters, camera.parameters + parameter_count(camera.model));
    expected["T_cb" + place] = has_rig ? entries_of(frame.cameras[c].T_cb) : std::vector<double>();
    if (!is_rectified) {
      EXPECT_EQ(recorded.comments.at(name)[0], to_string(camera.model));
    }
  }
  for (const auto& [name, numbers] : expected) {
    EXPECT_EQ(recorded.numbers(name, name.rfind("camera", 0) == 0 ? 1 : 0), numbers) << name;
  }
}

// Names and values of a row, behind the number of the map point, which double cannot hold.
std::vector<std::pair<std::string, double>> columns_of(const FeatureFrame& frame, std::size_t i, bool has_keyframes,
                                                       bool is_selected) {
  const FeatureMatch& match = frame.matches[i];
  const bool has_cue = frame.has_depth_cue[i] != 0;
  std::vector<std::pair<std::string, double>> columns = {{"X", match.point[0]},    {"Y", match.point[1]},
                                                         {"Z", match.point[2]},    {"u", match.measured[0]},
                                                         {"v", match.measured[1]}, {"kp", match.id}};
  if (frame.kind.has_rig) columns.emplace_back("camera", match.camera_id);
  if (frame.kind.depth_cue == DepthCue::stereo) {
    const double column = match.u_right - frame.cameras[0].pinhole.shift_of_right;  // in an image with the same cx
    columns.emplace_back("u_right", has_cue && column >= 0 ? column : -1);
  }
  if (frame.kind.depth_cue == DepthCue::depth) columns.emplace_back("depth", has_cue ? match.depth : -1);
  columns.emplace_back("inv_sigma2", 1 / (match.sigma * match.sigma));
  if (frame.has_covariances()) {
    const std::pair<const char*, std::size_t> entries[] = {{"cov_xx", 0}, {"cov_xy", 1}, {"cov_xz", 2},
                                                           {"cov_yy", 4}, {"cov_yz", 5}, {"cov_zz", 8}};
    for (const auto& [name, entry] : entries) {
      columns.emplace_back(name, frame.knows_covariance[i] != 0 ? frame.covariances[9 * i + entry] : -1);
    }
  }
  if (has_keyframes) columns.emplace_back("keyframe", match.keyframe);
  columns.emplace_back("selected", is_selected ? 1 : 0);
  return columns;
}

TEST(Recording, good_features_records_every_field_bit_for_bit) {
  GoodFeatures good(120);
  for_each_trial(100, [&](Random& random) {
    const bool has_keyframes = random.chance(0.5);
    const FeatureFrame frame = recordable_frame(random, has_keyframes);
    const TemporaryFolder folder;
    ASSERT_TRUE(good.record((folder.path() + "/run/").c_str())) << "a folder that is missing is created";
    frame.gather(good);
    ASSERT_TRUE(good.select(with_budget(30)).has_answer());
    const RecordedFrame recorded(folder / "run/frame_000000.csv");
    expect_comments(recorded, frame);
    std::size_t row = 0;
    for (std::size_t i = 0; i < 120; ++i) {  // those behind the camera, too
      if (frame.usable[i] == 0 || frame.matches[i].measured[0] == unmeasured) continue;
      ASSERT_LT(row, recorded.rows.size());
      EXPECT_EQ(recorded.rows[row].at("mp_id"), std::to_string(frame.matches[i].point_id));
      std::vector<std::string> names = {"mp_id"};
      for (const auto& [name, value] : columns_of(frame, i, has_keyframes, good.is_selected(i))) {
        names.push_back(name);
        EXPECT_EQ(recorded.at(row, name), value) << name;
      }
      EXPECT_EQ(recorded.columns, names);
      ++row;
    }
    EXPECT_EQ(row, recorded.rows.size());
    EXPECT_GT(row, 50U);
  });
  good.record(nullptr);
}

// Of C++ streams.
struct DecimalComma : std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
  char do_thousands_sep() const override { return '.'; }
  std::string do_grouping() const override { return "\3"; }
};

TEST(Recording, numbers_have_the_fewest_digits_that_read_back_whatever_the_locale_is) {
  const TemporaryFolder folder;
  const std::vector<std::pair<double, std::string>> numbers = {
      {0.1, "0.1"},
      {-12345.5, "-12345.5"},
      {5e-324, "5e-324"},
      {1 / 3.0, "0.3333333333333333"},
      {std::numeric_limits<double>::max(), "1.7976931348623157e+308"}};
  const std::locale before = std::locale::global(std::locale(std::locale::classic(), new DecimalComma));
  for (const char* const name : {"de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8", "de_DE"}) {
    if (std::setlocale(LC_NUMERIC, name) != nullptr) break;  // of C, where the machine has such a locale
  }
  FrameRecorder recorder;
  EXPECT_TRUE(recorder.open(folder.path().c_str()));
  std::vector<FeatureMatch> matches(numbers.size());
  for (std::size_t i = 0; i < numbers.size(); ++i) matches[i].measured[0] = numbers[i].first;
  const Camera camera(458.5, 457, 367, 248);
  MatchedFrame frame;
  frame.cameras = &camera;
  frame.camera_count = 1;
  frame.T_bw = RigidTransform::identity();
  frame.matches = matches.data();
  frame.size = matches.size();
  EXPECT_TRUE(recorder.write(frame, std::vector<unsigned char>(numbers.size()).data()));
  std::locale::global(before);
  std::setlocale(LC_NUMERIC, "C");
  const RecordedFrame recorded(folder / first_frame);
  EXPECT_EQ(recorded.comments.at("fx,fy,cx,cy,bf"), (std::vector<std::string>{"458.5", "457", "367", "248", "0"}));
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    EXPECT_EQ(recorded.at(i, "u"), numbers[i].first);
#if defined(__cpp_lib_to_chars)
    EXPECT_EQ(recorded.rows[i].at("u").size(), numbers[i].second.size()) << recorded.rows[i].at("u");
#endif
  }
}

TEST(Recording, leaves_out_matches_that_the_file_cannot_hold) {
  const TemporaryFolder folder;
  GoodFeatures good(100);
  ASSERT_TRUE(good.record(folder.path().c_str()));
  good.start(Camera(458, 457, 367, 248, 50), RigidTransform::identity());
  std::vector<double> written;
  const double point[3] = {0, 0, 5};
  const auto add = [&](bool is_written, auto change) {
    FeatureMatch match(point, point);
    match.u_right = 1;
    match.id = static_cast<std::uint32_t>(good.size());
    change(match);
    if (is_written) written.push_back(match.id);
    good.add(match);
  };
  add(true, [](FeatureMatch&) {});
  add(false, [](FeatureMatch& match) { match.measured[0] = unmeasured; });
  for (const double bad : {nan, infinity, -infinity, -1.0}) {
    if (!std::isfinite(bad)) {
      add(false, [&](FeatureMatch& match) { match.measured[0] = bad; });
      add(false, [&](FeatureMatch& match) { match.measured[1] = bad; });
      add(false, [&](FeatureMatch& match) { match.point[2] = bad; });
      add(false, [&](FeatureMatch& match) { match.sigma = bad; });
      add(true, [&](FeatureMatch& match) { match.u_right = bad; });  // not measured
    }
    for (const std::size_t diagonal : {0U, 4U, 8U}) {
      double covariance[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
      covariance[diagonal] = bad;
      add(false, [&](FeatureMatch& match) { match.covariance = covariance; });
    }
  }
  for (const double sigma : {0.0, 1e200}) add(false, [&](FeatureMatch& match) { match.sigma = sigma; });
  add(false, [](FeatureMatch& match) { match.camera_id = 3; });  // there is one camera
  for (int i = 0; i < 2; ++i) ASSERT_TRUE(good.select(10).has_answer());
  EXPECT_EQ(folder.files().size(), 1U) << "a frame is written once";
  const RecordedFrame recorded(folder / first_frame);
  ASSERT_EQ(recorded.rows.size(), written.size());
  for (std::size_t i = 0; i < written.size(); ++i) EXPECT_EQ(recorded.at(i, "kp"), written[i]);
}

// A frame with a recording that may have problems; what it says on stderr.
struct Watched {
  Watched() : frame(random, 100) {}

  // Returns what select() has said.
  std::string select() {
    frame.gather(good);
    ::testing::internal::CaptureStderr();
    EXPECT_EQ(good.select(with_budget(30)).status, Status::ok);
    const std::string said = ::testing::internal::GetCapturedStderr();
    GoodFeatures other(100);
    frame.gather(other);
    EXPECT_EQ(other.select(with_budget(30)).status, Status::ok);
    EXPECT_EQ(selected_of(good), selected_of(other));
    return said;
  }
  std::string record(const std::string& path, bool expected) {
    ::testing::internal::CaptureStderr();
    EXPECT_EQ(good.record(path.c_str()), expected);
    return ::testing::internal::GetCapturedStderr();
  }

  TracedRandom random;
  FeatureFrame frame;
  GoodFeatures good{100};
  TemporaryFolder folder;
};

TEST(Recording, is_off_by_default_and_after_an_empty_name_and_starts_with_the_next_frame) {
  Watched watched;
  const auto expect_files_after_a_frame = [&](std::size_t count) {
    EXPECT_EQ(watched.select(), "");
    EXPECT_EQ(watched.folder.files().size(), count);
  };
  expect_files_after_a_frame(0);
  watched.frame.gather(watched.good);
  EXPECT_EQ(watched.record(watched.folder.path(), true), "");
  EXPECT_EQ(watched.good.select(with_budget(30)).status, Status::ok);
  EXPECT_EQ(watched.folder.files().size(), 0U) << "this frame had been started";
  expect_files_after_a_frame(1);
  EXPECT_EQ(watched.record(watched.folder.path(), true), "") << "a recording under way goes on";
  expect_files_after_a_frame(2);
  EXPECT_FALSE(watched.good.record(nullptr));
  EXPECT_EQ(watched.record("", false), "");
  expect_files_after_a_frame(2);
}

TEST(Recording, a_folder_that_cannot_be_written_or_has_another_recording_is_said_once_and_changes_no_selection) {
  Watched watched;
  std::ofstream(watched.folder / "file") << "text";
  GoodFeatures another(100);
  ASSERT_TRUE(another.record((watched.folder / "recorded").c_str()));
  watched.frame.gather(another);
  another.select(30);
  const std::string before = text_of(watched.folder / "recorded/frame_000000.csv");
  EXPECT_NE(before, "");
  for (const std::string name : {"file", "file/frames", "no/such/folder", "recorded"}) {
    const std::string path = watched.folder / name;
    const std::string said = watched.record(path, false);
    EXPECT_EQ(said.rfind("maxlogdet: " + path + ": ", 0), 0U) << said;
    EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 1) << said;
    EXPECT_EQ(said.find("another recording") != std::string::npos, name == "recorded") << said;
    EXPECT_EQ(watched.record(path, false), "") << "once";
    EXPECT_EQ(watched.select(), "");
  }
  EXPECT_EQ(text_of(watched.folder / "recorded/frame_000000.csv"), before);
  EXPECT_FALSE(std::filesystem::exists(watched.folder / "recorded/frame_000001.csv"));
  EXPECT_EQ(watched.folder.files().size(), 2U);
}

// What another program has written since is not overwritten, a folder that has vanished is not made again, of a file
// that does not fit nothing stays, and a frame that a file has no place for is not squeezed in.
TEST(Recording, a_later_problem_is_said_once_and_ends_the_recording) {
  rlimit unlimited{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &unlimited), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);  // what is beyond the limit then fails, as on a full disk
  const std::pair<const char*, std::function<void(Watched&)>> problems[] = {
      {"File exists", [](Watched& watched) { std::ofstream(watched.folder / "inner/frame_000001.csv") << "another"; }},
      {"No such file", [](Watched& watched) { std::filesystem::remove_all(watched.folder / "inner"); }},
      {"File too large",
       [&](Watched&) {
         rlimit small = unlimited;
         small.rlim_cur = 1000;
         ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
       }},
      {"a rig with right columns", [](Watched& watched) {
         FeatureKind kind;
         kind.has_rig = true;
         kind.depth_cue = DepthCue::stereo;
         watched.frame = FeatureFrame(watched.random, 100, kind);
       }}};
  for (const auto& [what, make] : problems) {
    SCOPED_TRACE(what);
    Watched watched;
    const FeatureFrame plain = watched.frame;
    EXPECT_EQ(watched.record(watched.folder / "inner", true), "");
    EXPECT_EQ(watched.select(), "");
    make(watched);
    const auto state = [&] {
      return text_of(watched.folder / "inner/frame_000000.csv") + text_of(watched.folder / "inner/frame_000001.csv");
    };
    const std::string before = state(), said = watched.select();
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &unlimited), 0);
    EXPECT_NE(said.find(what), std::string::npos) << said;
    EXPECT_NE(said.find("; the recording ends\n"), std::string::npos) << said;
    EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 1) << said;
    watched.frame = plain;
    EXPECT_EQ(watched.select(), "");
    EXPECT_EQ(state(), before);
    EXPECT_FALSE(std::filesystem::exists(watched.folder / "inner/frame_000002.csv"));
  }
  std::signal(SIGXFSZ, handler);
}

// The folder gets no file, not even one with a header only; one line a recording says why, the first time.
TEST(Recording, a_frame_that_is_not_recorded_is_said_once) {
  const PinholeCamera pinhole(458, 457, 367, 248);
  const struct {
    const char* why;
    Camera camera;
    RigidTransform T_cw;
    std::size_t matches;
    bool is_measured;
  } cases[] = {{"no pose", pinhole, nullptr, 40, true},
               {"no camera", Camera(0, 457, 367, 248), RigidTransform::identity(), 40, true},
               {"above the capacity", pinhole, RigidTransform::identity(), 101, true},
               {"nothing measured", pinhole, RigidTransform::identity(), 40, false},
               {"no matches", pinhole, RigidTransform::identity(), 0, true}};
  for (const auto& of : cases) {
    SCOPED_TRACE(of.why);
    Watched watched;
    EXPECT_EQ(watched.record(watched.folder.path(), true), "");
    const auto unrecorded = [&] {
      ::testing::internal::CaptureStderr();
      for (int frame = 0; frame < 3; ++frame) {
        watched.good.start(of.camera, of.T_cw);
        for (std::size_t i = 0; i < of.matches; ++i) {
          FeatureMatch match(Eigen::Vector3d(0.01 * static_cast<double>(i), 0, 3));
          if (of.is_measured) match.measured[0] = match.measured[1] = 100;
          watched.good.add(match);
        }
        watched.good.select(30);
      }
      return ::testing::internal::GetCapturedStderr();
    };
    const std::string said = unrecorded();
    const std::string start = "maxlogdet: " + watched.folder.path() + ": a frame is not recorded: ";
    EXPECT_EQ(said.rfind(start, 0), 0U) << said;
    EXPECT_GT(said.size(), start.size() + 1) << "a reason";
    EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 1) << said;
    EXPECT_EQ(watched.folder.files().size(), 0U);
    EXPECT_EQ(watched.select(), "") << "the recording goes on";
    EXPECT_EQ(watched.folder.files(), std::vector<std::string>{first_frame});
    EXPECT_EQ(watched.record(watched.folder / "second", true), "");
    EXPECT_NE(unrecorded(), "") << "in each recording once";
  }
}

}  // namespace
}  // namespace maxlogdet::test
