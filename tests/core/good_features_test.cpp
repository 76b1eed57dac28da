// SPDX-License-Identifier: MIT
// GoodFeatures against append_blocks and a Selector on the same matches, every way in which nothing is selected, and
// one object over many frames of all kinds.
#include "tests/core/feature_frame.hpp"
#include "tests/support/numbers.hpp"
#include "tests/support/oracle.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <string>
#include <thread>
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
    EXPECT_STREQ(good.reason(), "ok");
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

TEST(GoodFeatures, a_match_without_a_jacobian_beside_others_with_one_is_no_candidate) {
  Gathered it(50);
  const double jacobian[6] = {300, 0, 10, 0, 300, 20};
  for (const std::size_t without : {std::size_t{0}, std::size_t{20}}) {
    it.frame.start(it.good);
    for (std::size_t i = 0; i < 50; ++i) {
      FeatureMatch match(it.frame.point(i));
      match.jacobian = i == without ? nullptr : jacobian;
      it.good.add(match);
    }
    EXPECT_EQ(it.good.select(10).status, Status::ok);
    EXPECT_FALSE(it.good.blocks().is_valid(without));
    EXPECT_EQ(it.good.block_report().invalid_jacobians, 1U);
  }
}

// What an error leaves: every usable match that is not excluded, in order, and no number that is not known.
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

// A frame of 200 matches, of which some are excluded, and some cannot be optimised with.
struct Troubled {
  Troubled() : frame(random, 200), excluded(200, 0) {
    for (std::uint32_t i = 0; i < 200; ++i) {
      excluded[i] = i % 9 == 0 ? 1 : 0;
      FeatureMatch& match = frame.matches[i];
      if (i % 20 == 1) match.point[i % 3] = nan;
      if (i % 20 == 2) match.measured[i % 2] = i % 3 == 0 ? infinity : nan;
      if (i % 20 == 3) match.sigma = i % 3 == 0 ? 0 : nan;
      const bool is_broken = i % 20 >= 1 && i % 20 <= 3;
      if (!is_broken && excluded[i] == 0) usable.push_back(i);
      if (is_broken) broken.push_back(i);
    }
  }

  Options options(std::size_t budget) const {
    Options options(budget);
    options.excluded = excluded.data();
    return options;
  }

  Random random;
  ::testing::ScopedTrace trace{__FILE__, __LINE__, random.name()};
  FeatureFrame frame;
  std::vector<unsigned char> excluded;
  std::vector<std::uint32_t> usable, broken;
  GoodFeatures good = GoodFeatures(300);
};

TEST(GoodFeatures, after_an_error_all_usable_matches_are_selected) {
  Troubled it;
  const RigidTransform T_cw = rows_of(it.frame.T_cw);
  const Camera pinhole = typical_camera(CameraModel::pinhole);
  const double no_prior[36] = {};
  const std::vector<unsigned char> everything(200, 1);
  Options options;
  const std::pair<Error, std::function<void()>> mistakes[] = {
      {Error::invalid_time_limit, [&] { options.time_limit = -1; }},
      {Error::invalid_strategy, [&] { options.strategy = Strategy(99); }},
      {Error::invalid_threads, [&] { options.threads = -1; }},
      {Error::invalid_target, [&] { options.target.efficiency = 2; }},
      {Error::invalid_prior, [&] { options.prior = no_prior; }},
      {Error::infeasible, [&] { options.required = everything.data(); }},
      {Error::invalid_camera, [&] { it.good.start(Camera(), T_cw); }},
      {Error::invalid_pose, [&] { it.good.start(pinhole, nullptr); }},
      {Error::invalid_pose, [&] { it.good.start(pinhole, Eigen::Matrix4d::Zero()); }},
      // A rig without cameras is an error, not the camera of the frame before.
      {Error::invalid_camera_id, [&] { it.good.start(Rig(), T_cw); }},
      {Error::invalid_block_options, [&] { it.good.block_options.min_depth = -1; }},
      {Error::mixed_depth_cues, [&] {
         it.frame.matches[5].u_right = 100;
         it.frame.matches[6].depth = 3;
       }}};
  for (const auto& [error, make] : mistakes) {
    SCOPED_TRACE(to_string(error));
    it.frame.gather(it.good);
    EXPECT_EQ(it.good.select(50).size, 50U) << "after the error before";
    it.frame.start(it.good);
    options = it.options(50);
    make();
    for (const FeatureMatch& match : it.frame.matches) it.good.add(match);
    expect_usable(it.good.select(options), it.good, it.usable, error);
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
        Options options = it.options(budget);
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
  it.good.select(it.options(50));
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
  EXPECT_STREQ(fitting.reason(), "ok");
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

// Required by the match, by the options, or by both; several times for one frame. What the options required is not
// required of the next selection.
TEST(GoodFeatures, what_is_required_is_selected_also_where_it_can_be_no_candidate) {
  Gathered it(200);
  const BlockStore blocks = it.frame.blocks();
  const auto next = [&](bool is_valid, std::uint32_t i) {
    while (blocks.is_valid(i) != is_valid) ++i;
    return i;
  };
  const std::uint32_t invalid = next(false, 0), one = next(true, 0), other = next(true, one + 1);
  it.frame.matches[one].is_required = it.frame.matches[invalid].is_required = true;
  std::vector<unsigned char> by_options(200, 0);
  by_options[other] = 1;
  it.frame.gather(it.good);
  for (const bool is_by_options : {true, true, false}) {
    std::vector<unsigned char> required = is_by_options ? by_options : std::vector<unsigned char>(200, 0);
    required[one] = 1;
    Options options = with_budget(20);
    options.required = required.data();
    std::vector<std::uint32_t> expected = select_indices(blocks, options);
    expected.push_back(invalid);
    options.required = is_by_options ? by_options.data() : nullptr;
    ASSERT_EQ(it.good.select(options).status, Status::ok);
    EXPECT_EQ(selected_of(it.good), sorted(expected));
    EXPECT_EQ(it.good.selection().size, 21U);
  }
}

TEST(GoodFeatures, excluded_matches_and_groups_go_by_the_numbers_of_matches) {
  Gathered it(200);
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
      const Matrix6 prior = has_prior ? Matrix6(1e4 * random_prior(random)) : default_information();
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

// The clock starts with the call: required points are searched for in any case, and take their time.
TEST(GoodFeatures, matching_ends_with_what_is_found_in_time) {
  for (const double limit : {0.0, 60.0, 1e-3}) {
    Gathered it(200);
    it.frame.start(it.good);
    for (std::size_t i = 0; i < 200; ++i) {
      FeatureMatch match(it.frame.point(i));
      match.is_required = i < 3;
      it.good.add(match);
    }
    Options options(50);
    options.time_limit = limit;
    const auto find = [&](std::size_t i, FeatureMatch&) {
      if (i < 3) std::this_thread::sleep_for(std::chrono::milliseconds(1));
      return true;
    };
    const Selection found = it.good.match(options, find);
    const bool is_late = limit == 1e-3;
    EXPECT_EQ(found.status, is_late ? Status::deadline_reached : Status::ok) << limit;
    EXPECT_EQ(found.size, is_late ? 3U : 50U) << limit;
    for (std::size_t i = 0; i < 3; ++i) EXPECT_TRUE(it.good.is_selected(i)) << i;
  }
}

TEST(GoodFeatures, what_is_matched_counts_with_what_was_measured_and_stays_usable) {
  Gathered it(100);
  it.frame.start(it.good);
  for (std::size_t i = 0; i < 100; ++i) it.good.add(FeatureMatch(it.frame.point(i)));
  const auto find = [](std::size_t i, FeatureMatch& match) {
    match.sigma = 0.25;
    return i % 3 != 0;
  };
  const Selection found = it.good.match(Options(30), find);
  ASSERT_EQ(found.size, 30U);
  GoodFeatures measured(30);
  it.frame.start(measured);
  for (const std::uint32_t i : found) {
    FeatureMatch match(it.frame.point(i));
    match.sigma = 0.25;
    measured.add(match);
  }
  EXPECT_NEAR(measured.select(Options(30)).log_det, found.log_det, 1e-9);
  EXPECT_EQ(it.good.select(Options(100)).size, 30U) << "of those that were matched";
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

}  // namespace
}  // namespace maxlogdet::test
