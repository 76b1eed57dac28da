// SPDX-License-Identifier: MIT
// What GoodFeatures::record() and a FrameRecorder write reads back bit for bit; and that no problem with files changes
// a selection.
#include "tests/support/recording.hpp"
#include "tests/core/feature_frame.hpp"
#include "tests/support/numbers.hpp"

#include <maxlogdet/frame_recorder.hpp>

#include <algorithm>
#include <array>
#include <clocale>
#include <cmath>
#include <limits>
#include <locale>
#include <string>
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
          kinds.push_back({model, depth_cue, has_rig, false, covariances});
        }
      }
    }
  }
  return kinds;
}

std::vector<double> camera_numbers(const Camera& camera, bool is_rectified) {
  const PinholeCamera& p = camera.pinhole;
  std::vector<double> numbers = {p.fx, p.fy, p.cx, p.cy};
  if (is_rectified) numbers.push_back(p.bf);
  numbers.insert(numbers.end(), camera.parameters, camera.parameters + parameter_count(camera.model));
  return numbers;
}

void expect_cameras(const RecordedFrame& recorded, const FeatureFrame& frame) {
  EXPECT_EQ(recorded.numbers("Tcw_prior"), entries_of(rows_of(frame.T_cw)));
  if (!frame.kind.has_rig && frame.kind.model == CameraModel::pinhole) {
    EXPECT_EQ(recorded.numbers("fx,fy,cx,cy,bf"), camera_numbers(frame.rig_cameras[0].camera, true));
    EXPECT_EQ(recorded.comments.count("camera"), 0U);
    return;
  }
  EXPECT_EQ(recorded.comments.count("fx,fy,cx,cy,bf"), 0U);
  for (std::size_t c = 0; c < (frame.kind.has_rig ? 2 : 1); ++c) {
    const std::string place = frame.kind.has_rig ? " " + std::to_string(c) : "";
    const Camera& camera = frame.rig_cameras[c].camera;
    ASSERT_EQ(recorded.comments.count("camera" + place), 1U);
    EXPECT_EQ(recorded.comments.at("camera" + place)[0], to_string(camera.model));
    EXPECT_EQ(recorded.numbers("camera" + place, 1), camera_numbers(camera, false));
    const auto T_cb = frame.kind.has_rig ? entries_of(frame.rig_cameras[c].T_cb) : std::vector<double>();
    EXPECT_EQ(recorded.numbers("T_cb" + place), T_cb);
  }
}

void expect_match(const RecordedFrame& recorded, std::size_t row, const FeatureFrame& frame, std::size_t i) {
  const FeatureMatch& match = frame.matches[i];
  EXPECT_EQ(recorded.at(row, "kp"), match.id);
  EXPECT_EQ(recorded.at(row, "X"), match.point[0]);
  EXPECT_EQ(recorded.at(row, "Y"), match.point[1]);
  EXPECT_EQ(recorded.at(row, "Z"), match.point[2]);
  EXPECT_EQ(recorded.at(row, "u"), match.measured[0]);
  EXPECT_EQ(recorded.at(row, "v"), match.measured[1]);
  EXPECT_EQ(recorded.at(row, "inv_sigma2"), 1 / (match.sigma * match.sigma));
  if (frame.kind.has_rig) {
    EXPECT_EQ(recorded.at(row, "camera"), match.camera_id);
  }
  if (frame.kind.depth_cue != DepthCue::none) {
    const std::string column = frame.kind.depth_cue == DepthCue::depth ? "depth" : "u_right";
    EXPECT_EQ(recorded.at(row, column),
              frame.has_depth_cue[i] != 0 ? (column == "depth" ? match.depth : match.u_right) : -1);
  }
  if (std::count(frame.knows_covariance.begin(), frame.knows_covariance.end(), 1) == 0) return;
  const char* const names[] = {"cov_xx", "cov_xy", "cov_xz", "cov_yy", "cov_yz", "cov_zz"};
  const std::size_t entries[] = {0, 1, 2, 4, 5, 8};
  for (std::size_t e = 0; e < 6; ++e) {
    const double expected = frame.knows_covariance[i] != 0 ? frame.covariances[9 * i + entries[e]] : -1;
    EXPECT_EQ(recorded.at(row, names[e]), expected) << names[e];
  }
}

std::vector<std::string> columns_of(const FeatureFrame& frame) {
  std::string names = "mp_id,X,Y,Z,u,v,kp";
  if (frame.kind.has_rig) names += ",camera";
  if (frame.kind.depth_cue == DepthCue::stereo) names += ",u_right";
  if (frame.kind.depth_cue == DepthCue::depth) names += ",depth";
  names += ",inv_sigma2";
  if (frame.kind.covariances != Covariances::none) names += ",cov_xx,cov_xy,cov_xz,cov_yy,cov_yz,cov_zz";
  return RecordedFrame::fields_of(names + ",selected");
}

bool is_measured(const FeatureMatch& match) {
  return std::isfinite(match.measured[0]) && std::isfinite(match.measured[1]);
}

TEST(Recording, good_features_records_every_field_bit_for_bit) {
  GoodFeatures good(120);
  std::uint64_t variation = 0;
  for (const FeatureKind& kind : recordable_kinds()) {
    Random random(variation++);
    SCOPED_TRACE(random.name());
    const FeatureFrame frame(random, 120, kind);
    const TemporaryFolder folder;
    ASSERT_TRUE(good.record(folder.path().c_str()));
    frame.gather(good);
    ASSERT_EQ(good.select(with_budget(30)).status, Status::ok);
    ASSERT_EQ(folder.files(), std::vector<std::string>{first_frame});
    const RecordedFrame recorded(folder / first_frame);
    EXPECT_EQ(recorded.columns, columns_of(frame));
    expect_cameras(recorded, frame);
    const auto depth_sigma = kind.depth_cue == DepthCue::depth ? std::vector<double>{0.07} : std::vector<double>();
    EXPECT_EQ(recorded.numbers("depth_sigma"), depth_sigma);
    std::size_t row = 0;
    for (std::size_t i = 0; i < 120; ++i) {  // those behind the camera, too
      if (!is_measured(frame.matches[i])) continue;
      ASSERT_LT(row, recorded.rows.size());
      expect_match(recorded, row, frame, i);
      EXPECT_EQ(recorded.at(row, "selected"), good.is_selected(i) ? 1 : 0);
      ++row;
    }
    EXPECT_EQ(row, recorded.rows.size());
    EXPECT_GT(row, 100U);
  }
  good.record(nullptr);
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
  const double negative[9] = {-1, 0, 0, 0, 1, 0, 0, 0, 1};
  EXPECT_FALSE(is_added([&](FeatureMatch& match) { match.covariance = negative; }));
  EXPECT_FALSE(is_added([](FeatureMatch& match) { match.sigma = 0; }));
  EXPECT_FALSE(is_added([](FeatureMatch& match) { match.sigma = 1e200; })) << "1 / sigma^2 is 0";
  EXPECT_TRUE(is_added([](FeatureMatch& match) { match.camera_id = 3; })) << "not a rig";
  EXPECT_TRUE(recorder.finish());
  EXPECT_EQ(RecordedFrame(folder / first_frame).rows.size(), 5U);
}

TEST(Recording, a_frame_recorder_writes_true_pose_image_size_and_descriptor_distances) {
  Random random;
  SCOPED_TRACE(random.name());
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

}  // namespace
}  // namespace maxlogdet::test
