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

TEST(Recording, frames_without_blocks_are_not_recorded) {
  Watched watched;
  EXPECT_EQ(watched.record(watched.folder.path(), true), "");
  GoodFeatures& good = watched.good;
  good.start(Camera(458, 457, 367, 248), nullptr);
  good.add(FeatureMatch());
  EXPECT_EQ(good.select(Options()).error, Error::invalid_pose);
  good.start(Camera(0, 457, 367, 248), RigidTransform::identity());
  EXPECT_EQ(good.select(Options()).error, Error::invalid_camera);
  good.start(Camera(458, 457, nan, 248), RigidTransform::identity());
  EXPECT_EQ(good.select(30).error, Error::invalid_camera);
  good.start(Camera(458, 457, 367, 248), RigidTransform::identity());
  for (int i = 0; i < 101; ++i) good.add(FeatureMatch());
  good.select(Options());
  EXPECT_STREQ(good.reason(), "capacity_exceeded");
  EXPECT_EQ(watched.folder.files().size(), 0U);
  EXPECT_EQ(watched.select(), "");
  EXPECT_EQ(watched.folder.files(), std::vector<std::string>{first_frame});
}

TEST(Recording, what_a_file_has_no_place_for_ends_the_recording) {
  for (const bool has_rig : {false, true}) {
    FeatureKind kind;
    kind.has_rig = has_rig;
    kind.has_jacobians = !has_rig;
    kind.depth_cue = has_rig ? DepthCue::stereo : DepthCue::none;
    Watched watched;
    EXPECT_EQ(watched.record(watched.folder.path(), true), "");
    const FeatureFrame plain = watched.frame;
    watched.frame = FeatureFrame(watched.random, 100, kind);
    const std::string said = watched.select();
    EXPECT_NE(said.find(has_rig ? "a rig with right columns" : "Jacobians of the caller"), std::string::npos) << said;
    EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 1);
    EXPECT_EQ(watched.select(), "");
    watched.frame = plain;
    EXPECT_EQ(watched.select(), "");
    EXPECT_EQ(watched.folder.files().size(), 0U);
  }
}

}  // namespace
}  // namespace maxlogdet::test
