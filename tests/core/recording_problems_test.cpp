// SPDX-License-Identifier: MIT
// When GoodFeatures::record() writes, and that no problem with files changes a selection.
#include "tests/core/feature_frame.hpp"
#include "tests/support/numbers.hpp"
#include "tests/support/recording.hpp"

#include <sys/resource.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace maxlogdet::test {
namespace {

const char* const first_frame = "frame_000000.csv";

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
    ::testing::internal::CaptureStderr();
    for (int frame = 0; frame < 3; ++frame) {
      watched.good.start(of.camera, of.T_cw);
      add(watched.good, of.matches, of.is_measured);
      watched.good.select(30);
    }
    const std::string said = ::testing::internal::GetCapturedStderr();
    const std::string start = "maxlogdet: " + watched.folder.path() + ": a frame is not recorded: ";
    EXPECT_EQ(said.rfind(start, 0), 0U) << said;
    EXPECT_GT(said.size(), start.size() + 1) << "a reason";
    EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 1) << said;
    EXPECT_EQ(watched.folder.files().size(), 0U);
    EXPECT_EQ(watched.select(), "") << "the recording goes on";
    EXPECT_EQ(watched.folder.files(), std::vector<std::string>{first_frame});
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

TEST(Recording, says_in_each_recording_once_that_frames_are_left_out) {
  const TemporaryFolder folder;
  FrameRecorder recorder;
  for (const std::string name : {"first", "second"}) {
    ASSERT_TRUE(recorder.open((folder / name).c_str()));
    ::testing::internal::CaptureStderr();
    for (int frame = 0; frame < 3; ++frame) recorder.skip("it is too long");
    const std::string said = ::testing::internal::GetCapturedStderr();
    EXPECT_NE(said.find("it is too long"), std::string::npos);
    EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 1);
  }
}

}  // namespace
}  // namespace maxlogdet::test
