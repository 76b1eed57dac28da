// SPDX-License-Identifier: MIT
// GoodFeatures against append_blocks and a Selector on the same matches, every way in which nothing is selected, and
// one object over many frames of all kinds.
#include "tests/core/feature_frame.hpp"
#include "tests/support/answer.hpp"
#include "tests/support/numbers.hpp"
#include "tests/support/oracle.hpp"

#include <maxlogdet/match_information.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
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
    EXPECT_EQ(good.selection().size, 0U) << "before select()";
    const Options options = with_budget(40);
    const BlockStore blocks = frame.blocks();
    ASSERT_EQ(good.select(options).status, Status::ok);
    expect_equal_blocks(good.blocks(), blocks);
    EXPECT_EQ(selected_of(good), sorted(select_indices(blocks, options)));
    EXPECT_EQ(good.selection().size, 40U);
  }
}

// The options of blocks may change between two calls for one frame, and with them the value of an unknown covariance.
TEST(GoodFeatures, a_match_without_a_covariance_has_the_current_map_sigma) {
  FeatureKind kind;
  kind.covariances = FeatureKind::Covariances::some;
  Gathered it(100, kind);
  for (const double map_sigma : {3.0, 0.11}) {
    it.good.block_options.map_sigma = map_sigma;
    ASSERT_EQ(it.good.select(30).error, Error::none);
  }
  expect_equal_blocks(it.good.blocks(), it.frame.blocks());
}

// What an error leaves: every usable match, in order, and no number that is not known.
void expect_usable(const Selection& selection, const GoodFeatures& good, const std::vector<std::uint32_t>& usable,
                   Error error) {
  EXPECT_EQ(selection.status, Status::error);
  EXPECT_EQ(selection.error, error);
  EXPECT_STREQ(selection.reason(), to_string(error));
  EXPECT_STREQ(good.reason(), to_string(error));
  EXPECT_EQ(indices_of(selection), usable);
  EXPECT_EQ(selected_of(good), usable);
  for (std::size_t j = 0; j < selection.size; ++j) EXPECT_TRUE(std::isnan(selection.gains[j]));
  EXPECT_TRUE(std::isnan(selection.log_det) && std::isnan(selection.upper_bound));
}

// A frame of 200 matches, of which some cannot be optimised with.
struct Troubled {
  Troubled() : frame(random, 200) {
    for (std::uint32_t i = 0; i < 200; ++i) {
      FeatureMatch& match = frame.matches[i];
      if (i % 20 == 1) match.point[i % 3] = nan;
      if (i % 20 == 2) match.measured[i % 2] = i % 3 == 0 ? infinity : nan;
      if (i % 20 == 3) match.sigma = i % 3 == 0 ? 0 : nan;
      const bool is_broken = i % 20 >= 1 && i % 20 <= 3;
      (is_broken ? broken : usable).push_back(i);
    }
  }

  Random random;
  ::testing::ScopedTrace trace{__FILE__, __LINE__, random.name()};
  FeatureFrame frame;
  std::vector<std::uint32_t> usable, broken;
  GoodFeatures good = GoodFeatures(300);
};

TEST(GoodFeatures, after_an_error_all_usable_matches_are_selected) {
  Troubled it;
  const RigidTransform T_cw = rows_of(it.frame.T_cw);
  const Camera pinhole = typical_camera(CameraModel::pinhole);
  const EigenPrior no_prior(Matrix6(-Matrix6::Identity()));
  const std::vector<unsigned char> nothing(200, 0);
  Options options;
  const std::pair<Error, std::function<void()>> mistakes[] = {
      {Error::invalid_time_limit, [&] { options.time_limit = -1; }},
      {Error::invalid_strategy, [&] { options.strategy = Strategy(99); }},
      {Error::invalid_threads, [&] { options.threads = -1; }},
      {Error::invalid_target, [&] { options.target.efficiency = 2; }},
      {Error::invalid_prior, [&] { options.prior = no_prior.data(); }},
      {Error::misplaced_required, [&] { options.required = nothing.data(); }},
      {Error::infeasible,
       [&] {
         for (std::size_t i = 0; i < 60; ++i) it.frame.matches[i].is_required = true;
       }},
      {Error::invalid_camera, [&] { it.good.start(Camera(), T_cw); }},
      {Error::invalid_pose, [&] { it.good.start(pinhole, nullptr); }},
      {Error::invalid_pose, [&] { it.good.start(pinhole, Eigen::Matrix4d::Zero()); }},
      // A rig without cameras is an error, not the camera of the frame before.
      {Error::invalid_camera, [&] { it.good.start(nullptr, 0, T_cw); }},
      {Error::invalid_block_options, [&] { it.good.block_options.min_depth = -1; }},
      {Error::mixed_depth_cues, [&] {
         it.frame.matches[5].u_right = 100;
         it.frame.matches[6].depth = 3;
       }}};
  const std::vector<FeatureMatch> matches = it.frame.matches;
  for (const auto& [error, make] : mistakes) {
    SCOPED_TRACE(to_string(error));
    it.frame.matches = matches;
    it.frame.gather(it.good);
    EXPECT_EQ(it.good.select(50).size, 50U) << "after the error before";
    it.frame.start(it.good);
    options = Options(50);
    make();
    for (const FeatureMatch& match : it.frame.matches) it.good.add(match);
    expect_usable(it.good.select(options), it.good, it.usable, error);
    if (it.good.align().error != Error::none) {
      EXPECT_STREQ(it.good.alignment().reason(), to_string(error));
      for (const std::uint32_t i : it.usable) EXPECT_TRUE(it.good.is_inlier(i)) << i;
    }
    EXPECT_TRUE(std::isnan(efficiency(it.good)));
  }
}

// Whatever the budget, the limit and the pose: as many as the budget, or all that there are; never one that is broken.
TEST(GoodFeatures, selects_a_full_budget_of_usable_matches_and_never_a_broken_one) {
  Troubled it;
  const Eigen::Isometry3d away(Eigen::AngleAxisd(3.1, Eigen::Vector3d::UnitY()));
  for (const bool is_behind : {false, true}) {
    for (const double limit : {0.0, 1e-9, 1e-6, 1.0}) {
      for (const std::size_t budget : {std::size_t{0}, std::size_t{1}, std::size_t{50}, std::size_t{140},
                                       it.usable.size(), std::size_t{200}, std::size_t{10000}}) {
        it.frame.gather(it.good);
        if (is_behind) {
          it.good.start(typical_camera(CameraModel::pinhole), away * it.frame.T_cw);
          for (const FeatureMatch& match : it.frame.matches) it.good.add(match);
        }
        Options options(budget);
        options.time_limit = limit;
        const Selection selection = it.good.select(options);
        SCOPED_TRACE(std::to_string(budget) + " in " + std::to_string(limit) + " s: " + selection.reason());
        EXPECT_TRUE(selection.has_answer());
        EXPECT_EQ(selection.size, std::min(budget, it.usable.size()));
        const std::vector<std::uint32_t> numbers = sorted(indices_of(selection));
        EXPECT_TRUE(std::includes(it.usable.begin(), it.usable.end(), numbers.begin(), numbers.end()));
        EXPECT_EQ(std::adjacent_find(numbers.begin(), numbers.end()), numbers.end());
        EXPECT_EQ(selected_of(it.good), numbers);
        if (is_behind && limit == 0 && budget == 50) {
          EXPECT_EQ(selection.status, Status::few_candidates);
        }
        if (limit == 0 && budget >= it.usable.size()) {
          EXPECT_EQ(selection.status, Status::all_selected);
        }
      }
    }
  }
}

TEST(GoodFeatures, what_is_broken_is_an_outlier_and_what_is_not_measured_is_none) {
  Troubled it;
  it.frame.gather(it.good);
  it.good.select(50);
  const IndexRange outliers = it.good.outliers(rows_of(it.frame.T_cw));
  const std::vector<std::uint32_t> flagged(outliers.begin(), outliers.end());
  EXPECT_TRUE(std::includes(flagged.begin(), flagged.end(), it.broken.begin(), it.broken.end()));
  for (std::uint32_t i = 0; i < 200; ++i) {
    EXPECT_EQ(it.good.is_outlier(i), std::binary_search(flagged.begin(), flagged.end(), i)) << i;
  }
  it.good.start(typical_camera(CameraModel::pinhole), rows_of(it.frame.T_cw));
  for (std::uint32_t i = 0; i < 200; ++i) it.good.add(it.frame.point(i), it.frame.sigmas[i]);
  EXPECT_EQ(it.good.select(50).size, 50U);
  EXPECT_EQ(it.good.outliers(rows_of(it.frame.T_cw)).size(), 0U);
}

// ORB-SLAM's -1, and NaN: not measured.
TEST(GoodFeatures, a_negative_right_column_is_none) {
  Gathered it(100);
  const FeatureFrame& frame = it.frame;
  GoodFeatures& good = it.good;
  GoodFeatures with_columns(100);
  frame.start(with_columns);
  for (FeatureMatch match : frame.matches) {
    match.u_right = match.id % 2 == 0 ? -1 : nan;
    match.depth = match.id % 2 == 0 ? 0 : infinity;
    with_columns.add(match);
  }
  EXPECT_EQ(indices_of(with_columns.select(30)), indices_of(good.select(30)));
  const RigidTransform T_cw = rows_of(frame.T_cw);
  EXPECT_EQ(with_columns.outliers(T_cw).size(), good.outliers(T_cw).size());
  for (std::size_t i = 0; i < 100; ++i) {
    if (good.is_selected(i)) continue;
    EXPECT_EQ(with_columns.chi2(i), good.chi2(i)) << i;
  }
}

TEST(GoodFeatures, fewer_are_selected_where_they_meet_the_targets) {
  Gathered it(200);
  GoodFeatures& good = it.good;
  Options options(150);
  options.target.efficiency = 0.4;
  const Selection selection = good.select(options);
  EXPECT_EQ(selection.status, Status::target_reached);
  EXPECT_STREQ(good.reason(), "target_reached");
  Selector selector(200);
  const Selection expected = selector.select(good.blocks(), options);
  ASSERT_EQ(expected.status, Status::target_reached);
  EXPECT_EQ(indices_of(selection), indices_of(expected));
  EXPECT_EQ(selection.efficiency, expected.efficiency);
  EXPECT_NEAR(efficiency(good), expected.efficiency, 1e-9);
  options.budget = 10;
  EXPECT_EQ(good.select(options).status, Status::ok) << "the budget ends before the target";
  EXPECT_EQ(good.selection().size, 10U);
}

TEST(GoodFeatures, matches_beyond_the_capacity_are_counted_and_not_selected) {
  Gathered it(101);
  const FeatureFrame& frame = it.frame;
  GoodFeatures good(100), fitting(100);
  frame.gather(good);
  frame.start(fitting);
  for (std::size_t i = 0; i < 100; ++i) fitting.add(frame.matches[i]);
  EXPECT_EQ(indices_of(good.select(10)), indices_of(fitting.select(10)));
  EXPECT_STREQ(good.reason(), "capacity_exceeded");
  EXPECT_EQ(fitting.selection().status, Status::ok);
  EXPECT_EQ(good.size(), 101U);
  EXPECT_EQ(good.id(100), no_id);
  good.outliers(rows_of(frame.T_cw));
  EXPECT_TRUE(std::isnan(good.chi2(100)));
  EXPECT_FALSE(good.is_outlier(100) || good.is_selected(100));
  GoodFeatures none(0);
  none.start(typical_camera(CameraModel::pinhole), rows_of(frame.T_cw));
  none.add(FeatureMatch());
  EXPECT_EQ(none.select(0).size, 0U);
}

// A match that is required without a block takes a place of the budget as any other does.
TEST(GoodFeatures, what_is_required_is_selected_also_without_a_block_and_counts_towards_the_budget) {
  Gathered it(200);
  const BlockStore blocks = it.frame.blocks();
  const auto next = [&](bool is_valid, std::uint32_t i) {
    while (blocks.is_valid(i) != is_valid) ++i;
    return i;
  };
  const std::uint32_t invalid = next(false, 0), one = next(true, 0);
  it.frame.matches[one].is_required = it.frame.matches[invalid].is_required = true;
  it.frame.gather(it.good);
  std::vector<unsigned char> required(200, 0);
  required[one] = 1;
  Options with_a_block(19);
  with_a_block.required = required.data();
  std::vector<std::uint32_t> expected = select_indices(blocks, with_a_block);
  expected.push_back(invalid);
  for (int again = 0; again < 2; ++again) {
    ASSERT_EQ(it.good.select(20).status, Status::ok);
    EXPECT_EQ(selected_of(it.good), sorted(expected));
    EXPECT_EQ(it.good.selection().size, 20U);
  }
}

// 50 matches in front of the camera, and five that are required, of which four are behind it.
void gather_required_behind(GoodFeatures& good) {
  good.start(Camera(458, 457, 367, 248), RigidTransform::identity());
  for (int i = 0; i < 55; ++i) {
    const double x = 0.1 * (i % 7 - 3), y = 0.1 * (i % 5 - 2), z = i >= 50 && i < 54 ? -3 : 2 + i % 17;
    FeatureMatch match(Eigen::Vector3d(x * z, y * z, z), Eigen::Vector2d(367 + 458 * x, 248 + 457 * y));
    match.is_required = i >= 50;
    good.add(match);
  }
}

TEST(GoodFeatures, more_required_than_the_budget_are_infeasible_whatever_has_a_block) {
  GoodFeatures good(100);
  gather_required_behind(good);
  for (const std::size_t budget : {0U, 3U, 4U}) {
    const Selection selection = good.select(budget);
    EXPECT_EQ(selection.error, Error::infeasible) << budget;
    EXPECT_EQ(selection.size, 55U) << "all that are usable";
  }
  for (const std::size_t budget : {5U, 6U, 10U, 54U}) {
    EXPECT_EQ(good.select(budget).status, Status::ok) << good.reason();
    EXPECT_EQ(good.selection().size, budget);
    for (std::size_t i = 50; i < 55; ++i) EXPECT_TRUE(good.is_selected(i)) << i << " of " << budget;
  }
  EXPECT_EQ(good.select(55).status, Status::all_selected);
}

// A frame of 50 matches, of stereo where bf is given.
std::vector<FeatureMatch> plain_matches(double bf) {
  std::vector<FeatureMatch> matches;
  for (int i = 0; i < 50; ++i) {
    const double x = 0.1 * (i % 7 - 3), y = 0.1 * (i % 5 - 2), z = 2 + i % 17;
    matches.emplace_back(Eigen::Vector3d(x * z, y * z, z), Eigen::Vector2d(367 + 458 * x, 248 + 457 * y));
    if (bf > 0) matches.back().u_right = matches.back().measured[0] - bf / z;
  }
  return matches;
}

// Only usable matches set what a frame has: a third measurement, covariances, cameras.
TEST(GoodFeatures, a_match_that_is_never_usable_changes_nothing_for_the_others) {
  const double covariance[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  FeatureMatch with_depth(Eigen::Vector3d(0, 0, 3), Eigen::Vector2d(nan, 248));
  FeatureMatch with_column = with_depth, with_covariance = with_depth;
  with_depth.depth = 3;
  with_column.u_right = 3;
  with_covariance.covariance = covariance;
  const std::pair<double, FeatureMatch> cases[] = {
      {40, with_depth}, {0, with_depth}, {0, with_column}, {40, with_covariance}, {0, with_covariance}};
  GoodFeatures good(51);
  for (const auto& [bf, broken] : cases) {
    SCOPED_TRACE("bf " + std::to_string(bf) + ", depth " + std::to_string(broken.depth > 0));
    good.start(Camera(458, 457, 367, 248, bf), RigidTransform::identity());
    for (const FeatureMatch& match : plain_matches(bf)) good.add(match);
    const Answer expected(good.select(10));
    EXPECT_EQ(expected.reason, "ok");
    good.add(broken);
    EXPECT_EQ(Answer(good.select(10)), expected);
    EXPECT_FALSE(good.is_selected(50));
  }
}

// A usable match with a right column shows that the camera is wrong.
TEST(GoodFeatures, a_right_column_needs_a_camera_with_bf) {
  GoodFeatures good(50);
  good.start(Camera(458, 457, 367, 248), RigidTransform::identity());
  for (FeatureMatch match : plain_matches(0)) {
    if (good.size() == 7) match.u_right = 100;
    good.add(match);
  }
  EXPECT_EQ(good.select(10).size, 50U);
  EXPECT_STREQ(good.reason(), "invalid_camera");
}

// An unknown camera_id is a fault of that match, not of the frame; alone, a camera has number 0.
TEST(GoodFeatures, a_match_of_a_camera_that_is_not_there_is_unusable_alone) {
  for (const bool is_rig : {false, true}) {
    Gathered it(200, {CameraModel::pinhole, DepthCue::none, is_rig, FeatureKind::Covariances::none});
    const auto gather_with = [&](std::uint8_t camera_id, bool is_error) {
      it.frame.start(it.good);
      for (std::size_t i = 0; i < 200; ++i) {
        FeatureMatch match = it.frame.matches[i];
        if (i % 10 == 1) match.camera_id = camera_id;
        it.good.add(match);
      }
      Options options(50);
      options.time_limit = is_error ? -1 : 0;
      return it.good.select(options);
    };
    for (const int camera_id : {is_rig ? 2 : 1, 255}) {
      const Selection selection = gather_with(static_cast<std::uint8_t>(camera_id), false);
      EXPECT_EQ(selection.status, Status::ok) << it.good.reason();
      EXPECT_EQ(selection.size, 50U);
      EXPECT_EQ(gather_with(static_cast<std::uint8_t>(camera_id), true).size, 180U) << "all usable ones";
      it.good.outliers(rows_of(it.frame.T_cw));
      for (std::size_t i = 1; i < 200; i += 10) {
        EXPECT_FALSE(it.good.is_selected(i)) << i;
        EXPECT_EQ(it.good.chi2(i), infinity);
        double omega[9];
        EXPECT_FALSE(match_information(it.good, i, omega));
      }
    }
  }
}

TEST(GoodFeatures, groups_go_by_the_numbers_of_matches) {
  Gathered it(200);
  std::vector<std::uint32_t> groups(200);
  for (std::uint32_t i = 0; i < 200; ++i) groups[i] = i % 30;
  Options options = with_budget(20);
  options.groups.ids = groups.data();
  options.groups.count = 30;
  ASSERT_EQ(it.good.select(options).status, Status::ok);
  EXPECT_EQ(selected_of(it.good), sorted(select_indices(it.frame.blocks(), options)));
}

TEST(GoodFeatures, the_share_compares_the_selection_with_all_matches) {
  GoodFeatures good(300);
  for_frames_of_all_kinds(trials(40), 200, [&](Random& random, const FeatureFrame& frame) {
    const BlockStore blocks = frame.blocks();
    std::vector<std::uint32_t> all;
    for (std::uint32_t i = 0; i < 200; ++i) {
      if (blocks.is_valid(i)) all.push_back(i);
    }
    frame.gather(good);
    for (const bool has_prior : {false, true}) {
      const Matrix6 prior = has_prior ? Matrix6(1e4 * random_prior(random)) : default_information(blocks);
      Options options = with_budget(50);
      const EigenPrior entries(prior);
      if (has_prior) options.prior = entries.data();
      ASSERT_EQ(good.select(options).status, Status::ok);
      const std::vector<std::uint32_t> selected = selected_of(good);
      const long double expected = std::exp((log_det_of(blocks, selected, prior) - log_det_of(blocks, all, prior)) / 6);
      EXPECT_NEAR(efficiency(good), static_cast<double>(expected), 1e-6);
      EXPECT_LT(efficiency(good), 1) << "again";
      EXPECT_EQ(selected_of(good), selected) << "the selection stays";
    }
    good.select(1000);
    EXPECT_NEAR(efficiency(good), 1, 1e-12);
  });
}

TEST(GoodFeatures, moves_with_its_frame_and_may_be_assigned_to_afterwards) {
  Gathered it(200);
  GoodFeatures& good = it.good;
  ASSERT_EQ(good.select(with_budget(50)).status, Status::ok);
  const std::vector<std::uint32_t> selected = selected_of(good);
  GoodFeatures taker(std::move(good));
  EXPECT_EQ(selected_of(taker), selected);
  good = std::move(taker);  // NOLINT(bugprone-use-after-move): what the class allows
  EXPECT_EQ(selected_of(good), selected);
  it.frame.gather(good);
  EXPECT_EQ(good.select(20).status, Status::ok);
  EXPECT_EQ(good.selection().size, 20U);
  static_assert(!std::is_copy_constructible<GoodFeatures>::value, "its memory is its own");
  static_assert(noexcept(good.select(Options()))&& noexcept(good.add(FeatureMatch())), "it throws nothing");
}

TEST(GoodFeatures, efficiency_needs_a_single_block) {
  const double pixel[2] = {320, 240};
  GoodFeatures good(10);
  for (const double z : {2.0, -2.0}) {
    const double point[3] = {0, 0, z};
    good.start(Camera(400, 400, 320, 240), RigidTransform::identity());
    good.add(FeatureMatch(point, pixel));
    good.select(10);
    EXPECT_EQ(std::isnan(efficiency(good)), z < 0) << efficiency(good);
  }
}

}  // namespace
}  // namespace maxlogdet::test
