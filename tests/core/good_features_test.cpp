// SPDX-License-Identifier: MIT
// GoodFeatures, which rejects nothing here, against append_blocks and a Selector on the same matches: one object over
// frames of all kinds, some of whose matches are odd, and every error; and ImageCells against a division that sorts.
#include "kernel/image_cells.hpp"
#include "tests/core/feature_frame.hpp"
#include "tests/support/oracle.hpp"
#include "tests/support/request.hpp"
#include "tests/support/support.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <new>
#include <set>
#include <utility>
#include <vector>

namespace maxlogdet::test {
namespace {

std::vector<std::uint32_t> sorted(std::vector<std::uint32_t> indices) {
  std::sort(indices.begin(), indices.end());
  return indices;
}

std::vector<std::uint32_t> usable_of(const FeatureFrame& frame) {
  std::vector<std::uint32_t> usable;
  for (std::uint32_t i = 0; i < frame.matches.size(); ++i) {
    if (frame.usable[i] != 0) usable.push_back(i);
  }
  return usable;
}

using Expected = std::pair<std::vector<std::uint32_t>, Status>;

// Required matches without a block take their places of the budget first, what the Selector leaves of it is filled with
// other usable matches, and after an error all of these are selected.
Expected expected_answer(const FeatureFrame& frame, const BlockStore& blocks, const Options& asked) {
  const std::vector<std::uint32_t> usable = usable_of(frame);
  std::vector<std::uint32_t> indices;
  std::vector<unsigned char> required(frame.matches.size());
  for (const std::uint32_t i : usable) {
    if (!frame.matches[i].is_required) continue;
    required[i] = blocks.is_valid(i) ? 1 : 0;
    if (!blocks.is_valid(i)) indices.push_back(i);
  }
  const auto with_block = static_cast<std::size_t>(std::count(required.begin(), required.end(), 1));
  if (indices.size() + with_block > asked.budget) return {usable, Status::error};
  Options options = asked;
  options.required = required.data();
  options.budget -= indices.size();
  const Answer answer = answer_to(blocks, options);
  if (answer.status == Status::error) return {usable, Status::error};
  indices.insert(indices.end(), answer.indices.begin(), answer.indices.end());
  if (answer.status == Status::target_reached) return {indices, answer.status};
  const std::size_t candidates = indices.size();
  const bool has_groups = asked.groups.ids != nullptr;
  for (const std::uint32_t i : usable) {
    const bool is_in = std::find(indices.begin(), indices.end(), i) != indices.end();
    if (!has_groups && !is_in && indices.size() < asked.budget) indices.push_back(i);
  }
  if (indices.size() == usable.size()) return {indices, Status::all_selected};
  if (indices.size() > candidates) return {indices, Status::few_candidates};
  return {indices, !has_groups || indices.size() == asked.budget ? Status::ok : answer.status};
}

// A frame of any kind, some of them of matches that are odd, some with all points behind the camera.
FeatureFrame random_frame(Random& random) {
  FeatureFrame frame(random, static_cast<std::size_t>(random.integer(100, 330)), random_kind(random));
  frame.make_odd(random, random.chance(0.3) ? 0 : 0.15);
  if (random.chance(0.1)) frame.T_cw = Eigen::Isometry3d(Eigen::AngleAxisd(3.1, Eigen::Vector3d::UnitY())) * frame.T_cw;
  return frame;
}

// One object for all frames, so that leftovers of a frame would show. Some frames exceed its capacity, some have groups
// or a target.
TEST(GoodFeatures, selects_as_append_blocks_and_a_selector_do_and_fills_the_budget_with_usable_matches) {
  constexpr std::size_t capacity = 300;
  GoodFeatures good(capacity);
  std::map<Status, int> seen;
  for_each_trial(400, [&](Random& random) {
    const FeatureFrame frame = random_frame(random);
    FeatureFrame kept = frame;
    kept.matches.resize(std::min(frame.matches.size(), capacity));
    const std::vector<std::uint32_t> usable = usable_of(kept);
    const std::size_t budgets[] = {0, 1, 5, 40, 40, 150, usable.size(), 10000};
    Options options = with_budget(budgets[random.integer(0, 7)]);
    std::vector<std::uint32_t> groups(frame.matches.size());
    for (std::uint32_t& group : groups) group = static_cast<std::uint32_t>(random.integer(0, 29));
    if (random.chance(0.2)) options.groups.ids = groups.data();
    options.groups.count = 30;
    good.spread = options.groups.ids != nullptr && random.chance(0.5) ? 1.5 : 0;  // which the groups replace
    if (random.chance(0.2)) options.target_efficiency = 0.4;

    frame.gather(good);
    ASSERT_EQ(good.size(), frame.matches.size());
    EXPECT_EQ(good.id(7), 1007U);
    EXPECT_EQ(good.id(capacity), no_id);
    EXPECT_EQ(good.blocks().size() + good.selection().size, 0U) << "of the frame before";
    if (random.chance(0.3)) {  // deviations that change between two calls for one frame
      good.block_options.map_sigma = 3;
      good.select(options);
      good.block_options.map_sigma = frame.options.map_sigma;
    }
    const Selection selection = good.select(options);
    const BlockStore blocks = kept.blocks();
    const auto [indices, status] = expected_answer(kept, blocks, options);
    ++seen[selection.status];
    EXPECT_EQ(bytes_of(good.blocks()), bytes_of(blocks));
    EXPECT_EQ(selection.status, status) << good.reason();
    EXPECT_EQ(indices_of(selection), indices);
    EXPECT_EQ(selected_of(good), sorted(indices));
    const bool are_all_kept = frame.matches.size() <= capacity;
    EXPECT_STREQ(good.reason(), are_all_kept || !selection.has_answer() ? selection.reason() : "capacity_exceeded");
    if (status == Status::error || options.groups.ids != nullptr || options.target_efficiency > 0) return;

    for (const double limit : {1e-9, 1e-6, 1.0}) {
      options.time_limit = limit;
      const std::vector<std::uint32_t> in_time = sorted(indices_of(good.select(options)));
      EXPECT_EQ(in_time.size(), std::min(options.budget, usable.size()));
      EXPECT_TRUE(std::includes(usable.begin(), usable.end(), in_time.begin(), in_time.end()));
      EXPECT_EQ(std::adjacent_find(in_time.begin(), in_time.end()), in_time.end());
      EXPECT_EQ(selected_of(good), in_time);
    }
  });
  if (trials(400) < 100) return;  // a share of the trials
  for (const Status status :
       {Status::ok, Status::all_selected, Status::target_reached, Status::few_candidates, Status::error})
    EXPECT_GT(seen[status], 0) << to_string(status);
}

// In order, and no number is one that is not known.
TEST(GoodFeatures, after_an_error_all_usable_matches_are_selected) {
  Gathered it(200);
  it.frame.make_odd(it.random, 0.15);
  for (FeatureMatch& match : it.frame.matches) {
    match.is_required = false;
    if (match.camera_id != 0) match.sigma = nan;  // of no use also where no camera is known
  }
  const std::vector<std::uint32_t> usable = usable_of(it.frame);
  const RigidTransform T_cw = rows_of(it.frame.T_cw);
  const Camera pinhole = typical_camera(CameraModel::pinhole);
  const Matrix6 no_prior = -Matrix6::Identity();
  const std::vector<unsigned char> nothing(200, 0);
  Options options;
  const std::pair<Error, std::function<void()>> mistakes[] = {
      {Error::invalid_time_limit, [&] { options.time_limit = -1; }},
      {Error::invalid_threads, [&] { options.threads = -1; }},
      {Error::invalid_prior, [&] { options.prior = no_prior.data(); }},
      {Error::misplaced_required, [&] { options.required = nothing.data(); }},
      {Error::infeasible,
       [&] {
         for (std::size_t i = 0; i < 80; ++i) it.frame.matches[i].is_required = true;
       }},
      {Error::invalid_groups, [&] { it.good.spread = -1; }},
      {Error::invalid_groups, [&] { it.good.spread = nan; }},
      {Error::invalid_groups, [&] { it.good.spread = infinity; }},
      {Error::invalid_camera, [&] { it.good.start(Camera(), T_cw); }},
      {Error::invalid_camera,
       [&] {  // a usable match with a right column shows that the camera is wrong
         it.good.start(Camera(458, 457, 367, 248), T_cw);
         it.frame.matches[usable[7]].u_right = 100;
       }},
      {Error::invalid_pose, [&] { it.good.start(pinhole, nullptr); }},
      // A rig without cameras is an error, not the camera of the frame before.
      {Error::invalid_camera, [&] { it.good.start(nullptr, 0, T_cw); }},
      {Error::invalid_block_options, [&] { it.good.block_options.map_sigma = -1; }},
      {Error::mixed_depth_cues, [&] {
         it.frame.matches[usable[5]].u_right = 100;
         it.frame.matches[usable[6]].depth = 3;
       }}};
  const std::vector<FeatureMatch> matches = it.frame.matches;
  for (const auto& [error, make] : mistakes) {
    SCOPED_TRACE(to_string(error));
    it.frame.matches = matches;
    it.good.spread = 0;
    it.frame.gather(it.good);
    EXPECT_EQ(it.good.select(50).size, 50U) << "after the error before";
    it.frame.start(it.good);
    options = Options(50);
    make();
    for (const FeatureMatch& match : it.frame.matches) it.good.add(match);
    const Selection selection = it.good.select(options);
    EXPECT_EQ(selection.status, Status::error);
    EXPECT_EQ(selection.error, error);
    EXPECT_STREQ(selection.reason(), to_string(error));
    EXPECT_STREQ(it.good.reason(), to_string(error));
    EXPECT_EQ(indices_of(selection), usable);
    EXPECT_EQ(selected_of(it.good), usable);
    for (std::size_t j = 0; j < selection.size; ++j) EXPECT_TRUE(std::isnan(selection.gains[j]));
    EXPECT_TRUE(std::isnan(selection.log_det) && std::isnan(selection.upper_bound));
    if (it.good.align().error != Error::none) {
      EXPECT_STREQ(it.good.alignment().reason(), to_string(error));
      for (const std::uint32_t i : usable) EXPECT_TRUE(it.good.is_inlier(i)) << i;
    }
    EXPECT_TRUE(std::isnan(it.good.efficiency()));
  }
}

TEST(GoodFeatures, efficiency_compares_the_selection_with_all_matches) {
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
      if (has_prior) options.prior = prior.data();
      ASSERT_EQ(good.select(options).status, Status::ok);
      const std::vector<std::uint32_t> selected = selected_of(good);
      const long double expected = std::exp((log_det_of(blocks, selected, prior) - log_det_of(blocks, all, prior)) / 6);
      EXPECT_NEAR(good.efficiency(), static_cast<double>(expected), 1e-6);
      EXPECT_LT(good.efficiency(), 1) << "again";
      EXPECT_EQ(selected_of(good), selected) << "the selection stays";
    }
    good.select(1000);
    EXPECT_NEAR(good.efficiency(), 1, 1e-12);
  });
  for (const double z : {2.0, -2.0}) {
    good.start(Camera(400, 400, 320, 240), RigidTransform::identity());
    good.add(Eigen::Vector3d(0, 0, z), Eigen::Vector2d(320, 240));
    good.select(10);
    EXPECT_EQ(std::isnan(good.efficiency()), z < 0) << "it needs a single block";
  }
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
}

constexpr std::size_t no_limit = std::numeric_limits<std::size_t>::max();

using Cell = std::vector<std::uint32_t>;  // its matches
using Cells = std::set<Cell>;

// Of equal positions many, as keypoints at whole pixels have.
std::vector<double> random_positions(Random& random, std::size_t n) {
  const bool are_whole = random.integer(0, 1) == 1;
  std::vector<double> uv;
  for (std::size_t i = 0; i < 2 * n; ++i) {
    const double at = random.uniform(-20, i % 2 == 0 ? 60 : 20);
    uv.push_back(are_whole ? std::round(at) : at);
  }
  return uv;
}

// The cells of matches at `uv`.
class Divided {
 public:
  explicit Divided(std::size_t capacity) : cells_(capacity) {}

  Cells divide(const std::vector<double>& uv, std::size_t cells, const std::vector<unsigned char>& is_spread,
               const std::vector<std::uint8_t>& camera_ids = {}) {
    std::vector<FeatureMatch> matches(is_spread.size());
    for (std::size_t i = 0; i < matches.size(); ++i) {
      std::copy_n(&uv[2 * i], 2, matches[i].measured);
      if (!camera_ids.empty()) matches[i].camera_id = camera_ids[i];
    }
    Options options;
    cells_.limit(matches.data(), matches.size(), is_spread.data(), cells, options);
    EXPECT_EQ(options.groups.maximum, 1U);
    std::map<std::uint32_t, Cell> by_group;
    for (std::uint32_t i = 0; i < matches.size(); ++i) {
      EXPECT_LT(options.groups.ids[i], options.groups.count);
      by_group[options.groups.ids[i]].push_back(i);
    }
    EXPECT_EQ(by_group.size(), options.groups.count) << "a cell without a match";
    Cells all;
    for (const auto& [group, of_group] : by_group) all.insert(of_group);
    return all;
  }

 private:
  ImageCells cells_;
};

// The definition, by sorting.
void divide(const std::vector<double>& uv, Cell matches, std::size_t cells, Cells& result) {
  cells = std::min(cells, matches.size());
  if (cells <= 1) {
    std::sort(matches.begin(), matches.end());
    if (!matches.empty()) result.insert(matches);
    return;
  }
  const auto extent = [&](std::size_t axis) {
    const auto less = [&](std::uint32_t a, std::uint32_t b) { return uv[2 * a + axis] < uv[2 * b + axis]; };
    const auto [low, high] = std::minmax_element(matches.begin(), matches.end(), less);
    return uv[2 * *high + axis] - uv[2 * *low + axis];
  };
  const std::size_t axis = extent(1) > extent(0) ? 1 : 0;
  std::sort(matches.begin(), matches.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::make_pair(uv[2 * a + axis], a) < std::make_pair(uv[2 * b + axis], b);
  });
  const std::size_t lower = cells / 2;
  const double share = static_cast<double>(matches.size() * lower) / static_cast<double>(cells);
  const auto middle = matches.begin() + static_cast<std::ptrdiff_t>(std::lround(share));
  divide(uv, {matches.begin(), middle}, lower, result);
  divide(uv, {middle, matches.end()}, cells - lower, result);
}

// And hold equally many matches, up to rounding. A match that is not spread is a group of its own.
TEST(ImageCells, are_those_of_a_division_that_sorts) {
  Divided divided_by_cells(1000);
  for_each_trial(300, [&](Random& random) {
    const std::size_t n = random.index(random.chance(0.3) ? 1001 : 301);
    const std::size_t beyond[] = {n, n + 1, std::size_t{1} << 32U, std::size_t{1} << 63U, no_limit};
    const std::size_t wanted = random.chance(0.2) ? beyond[random.integer(0, 4)] : random.index(401);
    const std::vector<double> uv = random_positions(random, n);
    std::vector<unsigned char> is_spread(n, 1);
    const double odd = random.chance(0.5) ? 0.1 : 0;
    Cell divided;
    Cells expected;
    for (std::uint32_t i = 0; i < n; ++i) {
      if (random.chance(odd)) is_spread[i] = 0;
      if (is_spread[i] != 0) {
        divided.push_back(i);
      } else {
        expected.insert({i});
      }
    }
    Cells of_division;
    divide(uv, divided, wanted, of_division);
    EXPECT_EQ(of_division.size(), std::min(std::max<std::size_t>(wanted, 1), divided.size()));
    const double share = static_cast<double>(divided.size()) / static_cast<double>(of_division.size());
    for (const Cell& cell : of_division) EXPECT_NEAR(static_cast<double>(cell.size()), share, 0.3 * share + 2);
    expected.insert(of_division.begin(), of_division.end());
    EXPECT_EQ(divided_by_cells.divide(uv, wanted, is_spread), expected);
  });
}

TEST(ImageCells, no_cell_has_matches_of_two_cameras_and_each_has_its_share) {
  Divided divided(400);
  for_each_trial(100, [&](Random& random) {
    const std::vector<double> uv = random_positions(random, 400);
    std::vector<std::uint8_t> camera_ids;
    for (std::size_t i = 0; i < 400; ++i) camera_ids.push_back(i % 4 == 0 ? 7 : 2);  // a quarter
    std::map<std::uint8_t, std::size_t> of_camera;
    for (const Cell& cell : divided.divide(uv, 40, std::vector<unsigned char>(400, 1), camera_ids)) {
      for (const std::uint32_t i : cell) EXPECT_EQ(camera_ids[i], camera_ids[cell.front()]);
      ++of_camera[camera_ids[cell.front()]];
    }
    EXPECT_EQ(of_camera[7], 10U);
    EXPECT_EQ(of_camera[2], 30U);
  });
}

// Required matches are in, and of the others no two share a cell; below one there are fewer cells than the budget, and
// one match of each is selected.
TEST(GoodFeatures, spread_selects_at_most_one_match_of_a_cell_besides_required_ones) {
  GoodFeatures good(300);
  for_frames_of_all_kinds(trials(100), 300, [&](Random& random, FeatureFrame frame) {
    for (std::size_t i = 0; i < 300; i += 60) frame.matches[i].is_required = true;
    const double spreads[] = {1.5, 1.5, 0.5, 1e-9, 1e300};
    good.spread = spreads[random.integer(0, 4)];
    frame.gather(good);
    const Selection selection = good.select(with_budget(60));
    std::vector<unsigned char> is_spread(300);
    std::vector<double> uv;
    std::vector<std::uint8_t> camera_ids;
    for (std::size_t i = 0; i < 300; ++i) {
      const FeatureMatch& match = frame.matches[i];
      EXPECT_TRUE(good.is_selected(i) || !match.is_required);
      is_spread[i] = good.blocks().is_valid(i) && !match.is_required ? 1 : 0;
      uv.insert(uv.end(), match.measured, match.measured + 2);
      camera_ids.push_back(match.camera_id);
    }
    const auto wanted = static_cast<std::size_t>(std::min(std::max(std::round(60 * good.spread), 1.0), 300.0));
    std::size_t cells = 0;
    for (const Cell& cell : Divided(300).divide(uv, wanted, is_spread, camera_ids)) {
      if (is_spread[cell.front()] == 0) continue;
      ++cells;
      EXPECT_LE(std::count_if(cell.begin(), cell.end(), [&](std::size_t i) { return good.is_selected(i); }), 1);
    }
    EXPECT_EQ(selection.size, good.spread > 1 ? 60 : cells + 5);
    EXPECT_EQ(selection.status, good.spread > 1 ? Status::ok : Status::all_selected) << good.reason();
  });
}

}  // namespace
}  // namespace maxlogdet::test
