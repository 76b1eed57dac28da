// SPDX-License-Identifier: MIT
// GoodFeatures against append_blocks and a Selector on the same matches, every way in which nothing is selected, and
// one object over many frames of all kinds.
#include "tests/core/feature_frame.hpp"
#include "tests/support/oracle.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <type_traits>
#include <utility>

namespace maxlogdet::test {
namespace {

void expect_equal_blocks(const BlockStore& actual, const BlockStore& expected) {
  ASSERT_EQ(actual.size(), expected.size());
  for (std::size_t i = 0; i < actual.size(); ++i) {
    ASSERT_EQ(actual.is_valid(i), expected.is_valid(i)) << i;
    if (actual.is_valid(i)) {
      EXPECT_EQ(stored_block(actual, i), stored_block(expected, i)) << i;
    }
  }
}

std::vector<std::uint32_t> sorted(std::vector<std::uint32_t> indices) {
  std::sort(indices.begin(), indices.end());
  return indices;
}

void expect_all_selected(const GoodFeatures& good, std::size_t count) {
  EXPECT_EQ(good.size(), count);
  EXPECT_EQ(good.selected_count(), count);
  EXPECT_EQ(selected_of(good).size(), count);
}

// A frame, and what has gathered its matches.
struct Gathered {
  explicit Gathered(std::size_t n, const FeatureKind& kind = FeatureKind()) : frame(random, n, kind), good(n) {
    frame.gather(good);
  }

  Random random;
  ::testing::ScopedTrace trace{__FILE__, __LINE__, random.name()};
  FeatureFrame frame;
  GoodFeatures good;
};

// One object for all frames, so that leftovers of a frame would show.
TEST(GoodFeatures, selects_as_append_blocks_and_a_selector_do_on_frames_of_all_kinds_one_after_the_other) {
  GoodFeatures good(300);
  for (std::uint64_t variation = 0; variation < trials(200); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const FeatureFrame frame(random, static_cast<std::size_t>(random.integer(100, 300)), random_kind(random));
    frame.gather(good);
    ASSERT_EQ(good.size(), frame.matches.size());
    EXPECT_EQ(good.id(7), 1007U);
    EXPECT_EQ(good.blocks().size(), 0U) << "of the frame before";
    EXPECT_EQ(good.selected_count(), frame.matches.size()) << "before select()";
    const Options options = with_budget(40);
    const BlockStore blocks = frame.blocks();
    ASSERT_EQ(good.select(options), Status::ok);
    expect_equal_blocks(good.blocks(), blocks);
    EXPECT_EQ(selected_of(good), sorted(select_indices(blocks, options)));
    EXPECT_EQ(good.selected_count(), 40U);
    EXPECT_STREQ(good.reason(), "ok");
  }
}

TEST(GoodFeatures, build_makes_the_same_blocks_and_selects_nothing) {
  Gathered gathered(100);
  const FeatureFrame& frame = gathered.frame;
  GoodFeatures& good = gathered.good;
  EXPECT_TRUE(good.build());
  expect_equal_blocks(good.blocks(), frame.blocks());
  expect_all_selected(good, 100);
}

// The options of blocks may change between two calls for one frame, and with them the value of an unknown covariance.
TEST(GoodFeatures, a_match_without_a_covariance_has_the_current_map_sigma) {
  FeatureKind kind;
  kind.covariances = FeatureKind::Covariances::some;
  Gathered gathered(100, kind);
  const FeatureFrame& frame = gathered.frame;
  GoodFeatures& good = gathered.good;
  good.block_options.map_sigma = 3;
  ASSERT_TRUE(good.build());
  good.block_options.map_sigma = 0.11;
  ASSERT_TRUE(good.build());
  expect_equal_blocks(good.blocks(), frame.blocks());
}

TEST(GoodFeatures, a_match_without_a_jacobian_beside_others_with_one_is_no_candidate) {
  Random random;
  SCOPED_TRACE(random.name());
  const FeatureFrame frame(random, 50);
  const double jacobian[6] = {300, 0, 10, 0, 300, 20};
  for (const std::size_t without : {std::size_t{0}, std::size_t{20}}) {
    GoodFeatures good(50);
    frame.start(good);
    for (std::size_t i = 0; i < 50; ++i) {
      FeatureMatch match;
      std::copy_n(&frame.points[3 * i], 3, match.point);
      match.jacobian = i == without ? nullptr : jacobian;
      good.add(match);
    }
    good.select(with_budget(10));
    EXPECT_FALSE(good.blocks().is_valid(without));
    EXPECT_EQ(good.block_report().error, Error::invalid_jacobians);
    EXPECT_EQ(good.block_report().invalid_jacobians, 1U);
    EXPECT_EQ(good.status(), Status::ok);
  }
}

// Whatever the reason is: all matches are selected, and none is an outlier.
void expect_all(GoodFeatures& good, const FeatureFrame& frame, const Options& options, Status status,
                const std::string& reason) {
  SCOPED_TRACE(reason);
  EXPECT_EQ(good.select(options), status);
  EXPECT_EQ(good.status(), status);
  EXPECT_EQ(good.reason(), reason);
  expect_all_selected(good, frame.matches.size());
  good.judge(rows_of(frame.T_cw));
  for (std::size_t i = 0; i < good.size(); ++i) EXPECT_FALSE(good.is_outlier(i));
}

// Options that cannot be answered; the next frame is selected from again.
void expect_all_with(void (*change)(Options&), GoodFeatures& good, const FeatureFrame& frame, Status status) {
  Options options = with_budget(50);
  change(options);
  frame.gather(good);
  expect_all(good, frame, options, status, to_string(status));
  frame.gather(good);
  EXPECT_EQ(good.select(with_budget(50)), Status::ok);
  EXPECT_EQ(good.selected_count(), 50U);
}

// Restarts with a camera, pose or rig that gives no blocks.
template <class Start>
void expect_all_started(const Start& start, GoodFeatures& good, const FeatureFrame& frame, const std::string& reason) {
  frame.gather(good);
  start();
  for (const FeatureMatch& match : frame.matches) good.add(match);
  expect_all(good, frame, with_budget(50), Error::invalid_block, reason);
}

TEST(GoodFeatures, whatever_goes_wrong_all_matches_are_selected) {
  Random random;
  SCOPED_TRACE(random.name());
  const FeatureFrame frame(random, 200);
  GoodFeatures good(300);
  const auto with = [&](void (*change)(Options&), Status status) { expect_all_with(change, good, frame, status); };
  with([](Options& o) { o.budget = 200; }, Status::all_selected);
  with([](Options& o) { o.budget = 301; }, Error::invalid_budget);
  with([](Options& o) { o.time_limit = 1e-9; }, Status::deadline_reached);
  with([](Options& o) { o.time_limit = -1; }, Error::invalid_time_limit);
  with([](Options& o) { o.strategy = Strategy(99); }, Error::invalid_strategy);
  with([](Options& o) { o.threads = -1; }, Error::invalid_threads);
  static const double no_prior[36] = {};
  with([](Options& o) { o.prior = no_prior; }, Error::invalid_prior);
  static const std::vector<unsigned char> everything(200, 1);
  with([](Options& o) { o.required = everything.data(); }, Error::infeasible);

  frame.gather(good);
  good.block_options.min_depth = -1;
  expect_all(good, frame, with_budget(50), Error::invalid_block, "invalid_options");
  const RigidTransform T_cw = rows_of(frame.T_cw);
  const Camera pinhole = typical_camera(CameraModel::pinhole);
  const auto none = DepthCue::none;
  expect_all_started([&] { good.start(Camera(), T_cw, none); }, good, frame, "invalid_camera");
  expect_all_started([&] { good.start(pinhole, RigidTransform(nullptr), none); }, good, frame, "invalid_pose");
  // A rig without cameras is an error, not the camera of the frame before.
  expect_all_started([&] { good.start(Rig(), T_cw, none); }, good, frame, "invalid_camera_id");
}

TEST(GoodFeatures, fewer_are_selected_where_they_meet_the_targets) {
  Gathered gathered(200);
  const FeatureFrame& frame = gathered.frame;
  GoodFeatures& good = gathered.good;
  Options options = with_budget(150);
  options.target.efficiency = 0.4;
  EXPECT_FALSE(good.is_target_reached());
  EXPECT_EQ(good.select(options), Status::ok) << "there are matches that are not selected";
  EXPECT_STREQ(good.reason(), "ok");
  EXPECT_TRUE(good.is_target_reached());
  Selector selector(200);
  const Selection expected = selector.select(good.blocks(), options);
  ASSERT_EQ(expected.status, Status::target_reached);
  EXPECT_EQ(good.selected_count(), expected.size);
  for (const std::uint32_t i : expected) EXPECT_TRUE(good.is_selected(i));
  EXPECT_NEAR(good.share_of_all(), expected.efficiency, 1e-9);
  good.judge(rows_of(frame.T_cw));
  const auto with = [&](double share, std::size_t budget, Status status, bool is_reached) {
    SCOPED_TRACE(share);
    options.target.efficiency = share;
    options.budget = budget;
    frame.gather(good);
    EXPECT_FALSE(good.is_target_reached()) << "of the frame before";
    EXPECT_EQ(good.select(options), status);
    EXPECT_EQ(good.is_target_reached(), is_reached);
  };
  with(0.4, 10, Status::ok, false);
  const std::size_t valid = good.blocks().stored();
  with(1 - 1e-9, valid - 1, Status::ok, false);
  with(1 - 1e-9, 200, Status::all_selected, true);
  expect_all_selected(good, 200);
  with(0.4, 150, Status::ok, true);
  with(2, 150, Error::invalid_target, false);
  expect_all_selected(good, 200);
  EXPECT_STREQ(good.reason(), "invalid_target");
}

TEST(GoodFeatures, a_frame_of_more_than_the_capacity_is_not_selected_from) {
  Random random;
  SCOPED_TRACE(random.name());
  const FeatureFrame frame(random, 101);
  GoodFeatures good(100);
  frame.gather(good);
  EXPECT_FALSE(good.build());
  EXPECT_EQ(good.select(with_budget(10)), Error::capacity_exceeded);
  EXPECT_STREQ(good.reason(), "capacity_exceeded");
  expect_all_selected(good, 101);
  EXPECT_EQ(good.id(100), GoodFeatures::no_id);
  good.judge(rows_of(frame.T_cw));
  EXPECT_TRUE(std::isnan(good.chi2(100)));
  EXPECT_FALSE(good.is_outlier(100));
  frame.start(good);
  for (std::size_t i = 0; i < 100; ++i) good.add(frame.matches[i]);
  EXPECT_EQ(good.select(with_budget(10)), Status::ok) << "the next frame has room";
  GoodFeatures none(0);
  none.start(typical_camera(CameraModel::pinhole), rows_of(frame.T_cw), DepthCue::none);
  none.add(FeatureMatch());
  EXPECT_EQ(none.select(with_budget(0)), Error::capacity_exceeded);
  expect_all_selected(none, 1);
}

// Required by the match, by the options, or by both; several times for one frame.
TEST(GoodFeatures, what_is_required_is_selected_also_where_it_can_be_no_candidate) {
  Random random;
  SCOPED_TRACE(random.name());
  FeatureFrame frame(random, 200);
  const BlockStore blocks = frame.blocks();
  std::size_t invalid = 0, one = 0;
  while (blocks.is_valid(invalid)) ++invalid;
  while (!blocks.is_valid(one)) ++one;
  std::size_t other = one + 1;
  while (!blocks.is_valid(other)) ++other;
  frame.matches[one].is_required = frame.matches[invalid].is_required = true;
  std::vector<unsigned char> required(200, 0), by_options(200, 0);
  required[one] = by_options[other] = required[other] = 1;
  GoodFeatures good(200);
  frame.gather(good);
  for (int time = 0; time < 3; ++time) {
    Options options = with_budget(20);
    options.required = required.data();
    std::vector<std::uint32_t> expected = select_indices(blocks, options);
    expected.push_back(static_cast<std::uint32_t>(invalid));
    options.required = by_options.data();
    ASSERT_EQ(good.select(options), Status::ok);
    EXPECT_EQ(selected_of(good), sorted(expected)) << "time " << time;
    EXPECT_EQ(good.selected_count(), 21U);
  }
  // What the options required is not required of the next selection.
  Options options = with_budget(20);
  required[other] = 0;
  options.required = required.data();
  std::vector<std::uint32_t> expected = select_indices(blocks, options);
  expected.push_back(static_cast<std::uint32_t>(invalid));
  ASSERT_EQ(good.select(with_budget(20)), Status::ok);
  EXPECT_EQ(selected_of(good), sorted(expected));
}

TEST(GoodFeatures, excluded_matches_and_groups_go_by_the_numbers_of_matches) {
  Random random;
  SCOPED_TRACE(random.name());
  const FeatureFrame frame(random, 200);
  std::vector<unsigned char> excluded(200, 0);
  std::vector<std::uint32_t> groups(200);
  for (std::uint32_t i = 0; i < 200; ++i) {
    excluded[i] = i % 5 == 0 ? 1 : 0;
    groups[i] = i % 30;
  }
  Options options = with_budget(20);
  options.excluded = excluded.data();
  options.groups.ids = groups.data();
  options.groups.count = 30;
  GoodFeatures good(200);
  frame.gather(good);
  ASSERT_EQ(good.select(options), Status::ok);
  EXPECT_EQ(selected_of(good), sorted(select_indices(frame.blocks(), options)));
}

TEST(GoodFeatures, the_share_compares_the_selection_with_all_matches) {
  for (std::uint64_t variation = 0; variation < trials(40); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const FeatureFrame frame(random, 200, random_kind(random));
    const BlockStore blocks = frame.blocks();
    GoodFeatures good(300);
    for (const bool has_prior : {false, true}) {
      const Matrix6 prior = has_prior ? Matrix6(1e4 * random_prior(random)) : default_information();
      Options options = with_budget(50);
      const EigenPrior entries(prior);
      if (has_prior) options.prior = entries.data();
      frame.gather(good);
      ASSERT_EQ(good.select(options), Status::ok);
      const std::vector<std::uint32_t> selected = selected_of(good);
      std::vector<std::uint32_t> all;
      for (std::uint32_t i = 0; i < 200; ++i) {
        if (blocks.is_valid(i)) all.push_back(i);
      }
      const long double expected = std::exp((log_det_of(blocks, selected, prior) - log_det_of(blocks, all, prior)) / 6);
      EXPECT_NEAR(good.share_of_all(), static_cast<double>(expected), 1e-6);
      EXPECT_LT(good.share_of_all(), 1) << "again";
      EXPECT_EQ(selected_of(good), selected) << "the selection stays";
    }
    good.select(with_budget(200));
    EXPECT_EQ(good.share_of_all(), 1);
    good.select(with_budget(1000));
    EXPECT_TRUE(std::isnan(good.share_of_all())) << "after an error";
  }
}

TEST(GoodFeatures, moves_with_its_frame_and_may_be_assigned_to_afterwards) {
  Gathered gathered(200);
  const FeatureFrame& frame = gathered.frame;
  GoodFeatures& good = gathered.good;
  ASSERT_EQ(good.select(with_budget(50)), Status::ok);
  const std::vector<std::uint32_t> selected = selected_of(good);
  GoodFeatures taker(std::move(good));
  EXPECT_EQ(selected_of(taker), selected);
  good = std::move(taker);  // NOLINT(bugprone-use-after-move): what the class allows
  EXPECT_EQ(selected_of(good), selected);
  frame.gather(good);
  EXPECT_EQ(good.select(with_budget(20)), Status::ok);
  EXPECT_EQ(good.selected_count(), 20U);
  static_assert(!std::is_copy_constructible<GoodFeatures>::value, "its memory is its own");
  static_assert(noexcept(good.select(Options()))&& noexcept(good.add(FeatureMatch())), "it throws nothing");
}

}  // namespace
}  // namespace maxlogdet::test
