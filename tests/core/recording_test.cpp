// SPDX-License-Identifier: MIT
// What GoodFeatures::record() and a FrameRecorder write reads back bit for bit; and that no problem with files changes
// a selection.
#include "tests/support/recording.hpp"
#include "tests/core/feature_frame.hpp"
#include "tests/support/numbers.hpp"
#include "tests/support/traced_random.hpp"

#include <maxlogdet/frame_recorder.hpp>

#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <clocale>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <limits>
#include <locale>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace maxlogdet::test {
namespace {

using Covariances = FeatureKind::Covariances;

const char* const first_frame = "frame_000000.csv";

std::vector<double> entries_of(const RigidTransform& T) { return {T.data(), T.data() + 12}; }

// All that a file can hold: every camera model, third measurements where there are any, alone and on a rig.
std::vector<FeatureKind> recordable_kinds() {
  std::vector<FeatureKind> kinds;
  for (const CameraModel model : camera_models) {
    for (const auto depth_cue : {DepthCue::none, DepthCue::stereo, DepthCue::depth}) {
      for (const bool has_rig : {false, true}) {
        if (depth_cue == DepthCue::stereo && (has_rig || model != CameraModel::pinhole)) continue;
        for (const auto covariances : {Covariances::none, Covariances::some, Covariances::all}) {
          kinds.push_back({model, depth_cue, has_rig, covariances});
        }
      }
    }
  }
  return kinds;
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

// Names and values of a row.
std::vector<std::pair<std::string, double>> columns_of(const FeatureFrame& frame, std::size_t i, bool is_selected) {
  const FeatureMatch& match = frame.matches[i];
  const bool has_cue = frame.has_depth_cue[i] != 0;
  std::vector<std::pair<std::string, double>> columns = {
      {"mp_id", -1},         {"X", match.point[0]},    {"Y", match.point[1]},
      {"Z", match.point[2]}, {"u", match.measured[0]}, {"v", match.measured[1]},
      {"kp", match.id}};
  if (frame.kind.has_rig) columns.emplace_back("camera", match.camera_id);
  if (frame.kind.depth_cue == DepthCue::stereo) columns.emplace_back("u_right", has_cue ? match.u_right : -1);
  if (frame.kind.depth_cue == DepthCue::depth) columns.emplace_back("depth", has_cue ? match.depth : -1);
  columns.emplace_back("inv_sigma2", 1 / (match.sigma * match.sigma));
  if (frame.kind.covariances != Covariances::none) {
    const double* const covariance = frame.knows_covariance[i] != 0 ? &frame.covariances[9 * i] : nullptr;
    std::size_t entry = 0;
    for (const char* const name : {"cov_xx", "cov_xy", "cov_xz", "", "cov_yy", "cov_yz", "", "", "cov_zz"}) {
      if (*name != '\0') columns.emplace_back(name, covariance == nullptr ? -1 : covariance[entry]);
      ++entry;
    }
  }
  columns.emplace_back("selected", is_selected ? 1 : 0);
  return columns;
}

TEST(Recording, good_features_records_every_field_bit_for_bit) {
  GoodFeatures good(120);
  std::uint64_t variation = 0;
  for (const FeatureKind& kind : recordable_kinds()) {
    TracedRandom random(variation++);
    const FeatureFrame frame(random, 120, kind);
    const TemporaryFolder folder;
    ASSERT_TRUE(good.record(folder.path().c_str()));
    frame.gather(good);
    ASSERT_EQ(good.select(with_budget(30)).status, Status::ok);
    ASSERT_EQ(folder.files(), std::vector<std::string>{first_frame});
    const RecordedFrame recorded(folder / first_frame);
    expect_comments(recorded, frame);
    std::size_t row = 0;
    for (std::size_t i = 0; i < 120; ++i) {  // those behind the camera, too
      const double* const uv = frame.matches[i].measured;
      if (!std::isfinite(uv[0]) || !std::isfinite(uv[1])) continue;
      ASSERT_LT(row, recorded.rows.size());
      std::vector<std::string> names;
      for (const auto& [name, value] : columns_of(frame, i, good.is_selected(i))) {
        names.push_back(name);
        EXPECT_EQ(recorded.at(row, name), value) << name;
      }
      EXPECT_EQ(recorded.columns, names);
      ++row;
    }
    EXPECT_EQ(row, recorded.rows.size());
    EXPECT_GT(row, 100U);
  }
  good.record(nullptr);
}

TEST(Recording, right_columns_are_those_of_an_image_with_the_same_cx) {
  const TemporaryFolder folder;
  GoodFeatures good(200);
  ASSERT_TRUE(good.record(folder.path().c_str()));
  good.start(Camera(458, 457, 367, 248, 50, 367 + 32), RigidTransform::identity());
  for (const double u_right : {300.0, 32.0, 31.0, -1.0}) {
    const double p_w[3] = {0, 0, 3};
    FeatureMatch match(p_w, p_w);
    match.u_right = u_right;
    good.add(match);
  }
  good.select(Options());
  const RecordedFrame recorded(folder / first_frame);
  EXPECT_EQ(recorded.at(0, "u_right"), 268);
  EXPECT_EQ(recorded.at(1, "u_right"), 0);
  EXPECT_EQ(recorded.at(2, "u_right"), -1) << "no such column";
  EXPECT_EQ(recorded.at(3, "u_right"), -1);
}

TEST(Recording, numbers_of_map_points_and_keyframes_are_written_and_frames_numbered) {
  const TemporaryFolder folder;
  GoodFeatures good(200);
  ASSERT_TRUE(good.record((folder.path() + "/run/").c_str())) << "a folder that is missing is created";
  for (std::int64_t frame = 0; frame < 3; ++frame) {
    good.start(Camera(458, 457, 367, 248), RigidTransform::identity());
    for (std::int64_t i = 0; i < 4; ++i) {
      const double p_w[3] = {0, 0, 3};
      FeatureMatch match(p_w, p_w);
      if (i > 0) match.point_id = std::numeric_limits<std::int64_t>::max() - i;
      if (frame == 2 && i > 0) match.keyframe = 10 * i;
      good.add(match);
    }
    EXPECT_EQ(good.select(Options()).status, Status::all_selected);
  }
  const RecordedFrame first(folder / "run/frame_000000.csv"), last(folder / "run/frame_000002.csv");
  EXPECT_EQ(first.rows.at(0).at("mp_id"), "-1");
  EXPECT_EQ(first.rows.at(2).at("mp_id"), "9223372036854775805");
  EXPECT_EQ(first.rows.at(2).at("selected"), "1");
  EXPECT_EQ(first.rows.at(2).count("keyframe"), 0U) << "known of no match";
  EXPECT_EQ(last.rows.at(0).at("keyframe"), "-1");
  EXPECT_EQ(last.rows.at(2).at("keyframe"), "20");
}

// A decimal comma, of C++ streams and, where the machine has such a locale, of C.
struct DecimalComma {
  struct Comma : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
    char do_thousands_sep() const override { return '.'; }
    std::string do_grouping() const override { return "\3"; }
  };
  DecimalComma() : before(std::locale::global(std::locale(std::locale::classic(), new Comma))) {
    for (const char* const name : {"de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8", "de_DE"}) {
      if (std::setlocale(LC_NUMERIC, name) != nullptr) break;
    }
    std::printf("the decimal point of C is '%s'\n", std::localeconv()->decimal_point);
  }
  ~DecimalComma() {
    std::locale::global(before);
    std::setlocale(LC_NUMERIC, "C");
  }
  DecimalComma(const DecimalComma&) = delete;
  DecimalComma& operator=(const DecimalComma&) = delete;
  std::locale before;
};

TEST(Recording, numbers_have_the_fewest_digits_that_read_back_whatever_the_locale_is) {
  const TemporaryFolder folder;
  const std::vector<std::pair<double, std::string>> numbers = {
      {0.1, "0.1"},
      {718, "718"},
      {-12345.5, "-12345.5"},
      {5e-324, "5e-324"},
      {1e23, "1e+23"},
      {0.1 + 0.2, "0.30000000000000004"},
      {1 / 3.0, "0.3333333333333333"},
      {std::numeric_limits<double>::max(), "1.7976931348623157e+308"},
      {static_cast<double>(367.215F), "367.2149963378906"}};
  {
    const DecimalComma comma;
    FrameRecorder recorder;
    ASSERT_TRUE(recorder.open(folder.path().c_str()));
    ASSERT_TRUE(recorder.start(Camera(458.5, 457, 367, 248), RigidTransform::identity()));
    for (const auto& number : numbers) {
      FeatureMatch match;
      match.measured[0] = number.first;
      EXPECT_TRUE(recorder.add(match, false));
    }
    EXPECT_TRUE(recorder.finish());
  }
  const RecordedFrame recorded(folder / first_frame);
  EXPECT_EQ(recorded.comments.at("fx,fy,cx,cy,bf"), (std::vector<std::string>{"458.5", "457", "367", "248", "0"}));
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    EXPECT_EQ(recorded.at(i, "u"), numbers[i].first);
    EXPECT_EQ(recorded.rows[i].at("u").size(), numbers[i].second.size()) << recorded.rows[i].at("u");
  }
}

TEST(Recording, a_match_that_the_file_cannot_hold_is_left_out) {
  const TemporaryFolder folder;
  FrameRecorder recorder;
  ASSERT_TRUE(recorder.open(folder.path().c_str()));
  FrameDetails details;
  details.depth_cue = DepthCue::stereo;
  details.has_covariances = details.has_descriptor_distances = true;
  ASSERT_TRUE(recorder.start(Camera(458, 457, 367, 248, 50), RigidTransform::identity(), details));
  const double origin[3] = {};
  EXPECT_FALSE(recorder.add(FeatureMatch(origin), false)) << "not measured";
  const auto is_added = [&](auto change) {
    FeatureMatch match(origin, origin);
    change(match);
    return recorder.add(match, false);
  };
  EXPECT_TRUE(is_added([](FeatureMatch&) {}));
  for (const double bad : {nan, infinity, -infinity}) {
    EXPECT_FALSE(is_added([&](FeatureMatch& match) { match.measured[0] = bad; }));
    EXPECT_FALSE(is_added([&](FeatureMatch& match) { match.measured[1] = bad; }));
    EXPECT_FALSE(is_added([&](FeatureMatch& match) { match.point[2] = bad; }));
    EXPECT_FALSE(is_added([&](FeatureMatch& match) { match.sigma = bad; }));
    EXPECT_TRUE(is_added([&](FeatureMatch& match) { match.u_right = bad; })) << "not measured";
    EXPECT_FALSE(recorder.add(FeatureMatch(origin, origin), false, bad)) << "descriptor distance";
    const double covariance[9] = {1, 0, 0, 0, 1, 0, 0, 0, bad};
    EXPECT_FALSE(is_added([&](FeatureMatch& match) { match.covariance = covariance; }));
  }
  for (const std::size_t diagonal : {0U, 4U, 8U}) {
    double negative[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    negative[diagonal] = -1;
    EXPECT_FALSE(is_added([&](FeatureMatch& match) { match.covariance = negative; }));
  }
  EXPECT_FALSE(is_added([](FeatureMatch& match) { match.sigma = 0; }));
  EXPECT_FALSE(is_added([](FeatureMatch& match) { match.sigma = 1e200; })) << "1 / sigma^2 is 0";
  EXPECT_FALSE(is_added([](FeatureMatch& match) { match.camera_id = 3; })) << "there is one camera";
  EXPECT_TRUE(recorder.finish());
  EXPECT_EQ(RecordedFrame(folder / first_frame).rows.size(), 4U);
}

TEST(Recording, a_frame_recorder_writes_true_pose_image_size_and_descriptor_distances) {
  TracedRandom random;
  const TemporaryFolder folder;
  FrameRecorder recorder;
  ASSERT_TRUE(recorder.open(folder.path().c_str()));
  FrameDetails details;
  details.T_cw_true = rows_of(random_isometry(random, 2, 1));
  details.width = 752;
  details.height = 480;
  details.has_descriptor_distances = true;
  ASSERT_TRUE(recorder.start(typical_camera(CameraModel::pinhole), rows_of(random_isometry(random, 2, 1)), details));
  EXPECT_TRUE(recorder.add(FeatureMatch(std::array<double, 3>{}, std::array<double, 2>{}), true, 38));
  EXPECT_TRUE(recorder.finish());
  EXPECT_FALSE(recorder.finish()) << "a frame is written once";
  EXPECT_FALSE(recorder.add(FeatureMatch(), true)) << "no frame is started";
  const RecordedFrame recorded(folder / first_frame);
  EXPECT_EQ(recorded.numbers("Tcw_true"), entries_of(details.T_cw_true));
  EXPECT_EQ(recorded.numbers("image width,height"), (std::vector<double>{752, 480}));
  EXPECT_EQ(recorded.rows.at(0).at("desc_dist"), "38");
  EXPECT_EQ(folder.files().size(), 1U);
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
  EXPECT_EQ(watched.select(), "");
  EXPECT_EQ(watched.folder.files().size(), 0U);
  watched.frame.gather(watched.good);
  EXPECT_EQ(watched.record(watched.folder.path(), true), "");
  EXPECT_EQ(watched.good.select(with_budget(30)).status, Status::ok);
  EXPECT_EQ(watched.folder.files().size(), 0U) << "this frame had been started";
  EXPECT_EQ(watched.select(), "");
  EXPECT_EQ(watched.folder.files().size(), 1U);
  EXPECT_EQ(watched.record(watched.folder.path(), true), "") << "a recording under way goes on";
  EXPECT_EQ(watched.select(), "");
  EXPECT_EQ(watched.folder.files().size(), 2U);
  EXPECT_FALSE(watched.good.record(nullptr));
  EXPECT_EQ(watched.record("", false), "");
  EXPECT_EQ(watched.select(), "");
  EXPECT_EQ(watched.folder.files().size(), 2U);
}

TEST(Recording, a_folder_that_cannot_be_written_is_said_once_and_changes_no_selection) {
  Watched watched;
  std::ofstream(watched.folder / "file") << "text";
  for (const std::string name : {"file", "file/frames", "no/such/folder"}) {
    const std::string path = watched.folder / name;
    const std::string said = watched.record(path, false);
    EXPECT_EQ(said.rfind("maxlogdet: " + path + ": ", 0), 0U) << said;
    EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 1) << said;
    EXPECT_EQ(watched.record(path, false), "") << "once";
    EXPECT_EQ(watched.select(), "");
  }
  EXPECT_EQ(watched.folder.files().size(), 1U);
}

TEST(Recording, two_recordings_are_never_mixed) {
  Watched watched;
  EXPECT_EQ(watched.record(watched.folder.path(), true), "");
  EXPECT_EQ(watched.select(), "");
  const std::string before = text_of(watched.folder / first_frame);
  GoodFeatures second(100);
  ::testing::internal::CaptureStderr();
  EXPECT_FALSE(second.record(watched.folder.path().c_str()));
  EXPECT_EQ(::testing::internal::GetCapturedStderr(),
            "maxlogdet: " + watched.folder.path() +
                ": it holds frame_*.csv of another recording: choose another folder, or empty it; nothing is "
                "recorded\n");
  watched.frame.gather(second);
  EXPECT_EQ(second.select(with_budget(20)).status, Status::ok);
  EXPECT_EQ(text_of(watched.folder / first_frame), before);
  EXPECT_EQ(watched.folder.files().size(), 1U);
}

// What another program has written since is not overwritten, and neither is a folder that has vanished made again.
TEST(Recording, a_later_problem_is_said_once_and_ends_the_recording) {
  Watched watched;
  EXPECT_EQ(watched.record(watched.folder.path(), true), "");
  EXPECT_EQ(watched.select(), "");
  std::ofstream(watched.folder / "frame_000001.csv") << "another";
  EXPECT_NE(watched.select().find("; the recording ends\n"), std::string::npos);
  EXPECT_EQ(watched.select(), "");
  EXPECT_EQ(text_of(watched.folder / "frame_000001.csv"), "another");
  EXPECT_EQ(watched.record(watched.folder / "inner", true), "");
  std::filesystem::remove(watched.folder / "inner");
  EXPECT_NE(watched.select(), "");
  EXPECT_EQ(watched.select(), "");
  EXPECT_EQ(watched.folder.files().size(), 2U);
}

TEST(Recording, of_a_file_that_does_not_fit_nothing_stays) {
  Watched watched;
  EXPECT_EQ(watched.record(watched.folder.path(), true), "");
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  rlimit small = before;
  small.rlim_cur = 1000;
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);  // what is beyond the limit then fails, as on a full disk
  const std::string folder = watched.folder.path();
  watched.frame.gather(watched.good);
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  const Status status =
      watched.good.select(with_budget(30)).status;  // says it on stderr, whose file may be at its limit
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(status, Status::ok);
  EXPECT_EQ(watched.good.selection().size, 30U);
  EXPECT_EQ(watched.folder.files().size(), 0U);
  EXPECT_EQ(watched.select(), "");
  EXPECT_EQ(watched.folder.files().size(), 0U) << "the recording has ended";
}

// The folder gets no file, not even one with a header only; one line a recording says why, the first time.
TEST(Recording, a_frame_that_is_not_recorded_is_said_once) {
  const PinholeCamera pinhole(458, 457, 367, 248);
  const auto add = [](GoodFeatures& good, std::size_t n, bool is_measured) {
    for (std::size_t i = 0; i < n; ++i) {
      const auto x = static_cast<double>(i % 7);
      FeatureMatch match(Eigen::Vector3d(0.1 * x, 0, 3 + x));
      if (is_measured) match.measured[0] = match.measured[1] = 100 + x;
      good.add(match);
    }
  };
  const struct {
    const char* why;
    Camera camera;
    RigidTransform T_cw;
    std::size_t matches;
    bool is_measured;
  } cases[] = {{"no pose", pinhole, nullptr, 40, true},
               {"not a rotation", pinhole, Eigen::Matrix4d(2 * Eigen::Matrix4d::Identity()), 40, true},
               {"no camera", Camera(0, 457, 367, 248), RigidTransform::identity(), 40, true},
               {"no principal point", Camera(458, 457, nan, 248), RigidTransform::identity(), 40, true},
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
        add(watched.good, of.matches, of.is_measured);
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

TEST(Recording, what_a_file_has_no_place_for_ends_the_recording) {
  FeatureKind kind;
  kind.has_rig = true;
  kind.depth_cue = DepthCue::stereo;
  Watched watched;
  EXPECT_EQ(watched.record(watched.folder.path(), true), "");
  const FeatureFrame plain = watched.frame;
  watched.frame = FeatureFrame(watched.random, 100, kind);
  const std::string said = watched.select();
  EXPECT_NE(said.find("a rig with right columns"), std::string::npos) << said;
  EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 1);
  EXPECT_EQ(watched.select(), "");
  watched.frame = plain;
  EXPECT_EQ(watched.select(), "");
  EXPECT_EQ(watched.folder.files().size(), 0U);
}

}  // namespace
}  // namespace maxlogdet::test
