// SPDX-License-Identifier: MIT
// ImageCells against a division that sorts, and what GoodFeatures makes of it.
#include "tests/core/feature_frame.hpp"
#include "tests/support/numbers.hpp"
#include "tests/support/sweeps.hpp"
#include "tests/support/traced_random.hpp"

#include <maxlogdet/image_cells.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <new>
#include <numeric>
#include <set>
#include <utility>
#include <vector>

namespace maxlogdet::test {
namespace {

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

Cells cells_of(const ImageCells& cells, std::size_t n) {
  std::map<std::uint32_t, Cell> matches;
  for (std::uint32_t i = 0; i < n; ++i) {
    EXPECT_LT(cells.groups()[i], cells.count());
    matches[cells.groups()[i]].push_back(i);
  }
  EXPECT_EQ(matches.size(), cells.count()) << "a cell without a match";
  Cells all;
  for (const auto& [group, of_group] : matches) all.insert(of_group);
  return all;
}

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

// And hold equally many matches, up to rounding.
TEST(ImageCells, are_those_of_a_division_that_sorts) {
  ImageCells cells(1000);
  for (std::uint64_t variation = 0; variation < trials(300); ++variation) {
    TracedRandom random(variation);
    const auto n = static_cast<std::size_t>(random.integer(0, variation % 3 == 0 ? 1000 : 300));
    const auto wanted = static_cast<std::size_t>(random.integer(0, 400));
    const std::vector<double> uv = random_positions(random, n);
    ASSERT_TRUE(cells.assign(uv.data(), 2, n, wanted));
    Cell all(n);
    std::iota(all.begin(), all.end(), 0U);
    Cells expected;
    divide(uv, all, wanted, expected);
    EXPECT_EQ(cells_of(cells, n), expected);
    EXPECT_EQ(cells.count(), std::min(std::max<std::size_t>(wanted, 1), n));
    const double share = static_cast<double>(n) / static_cast<double>(cells.count());
    for (const Cell& cell : expected) EXPECT_NEAR(static_cast<double>(cell.size()), share, 0.3 * share + 2);
  }
}

TEST(ImageCells, a_match_without_a_place_and_one_that_is_not_spread_are_groups_of_their_own) {
  const std::vector<double> uv = {1, 1, nan, 2, 3, infinity, 4, 4, 5, 5, 6, 6};
  const unsigned char is_spread[] = {1, 1, 1, 0, 1, 1};
  ImageCells cells(6);
  ASSERT_TRUE(cells.assign(uv.data(), 2, 6, 1, is_spread));
  EXPECT_EQ(cells_of(cells, 6), (Cells{{1}, {2}, {3}, {0, 4, 5}}));
}

TEST(ImageCells, no_cell_has_matches_of_two_cameras_and_each_has_its_share) {
  ImageCells cells(400);
  for_each_trial(100, [&](Random& random) {
    const std::vector<double> uv = random_positions(random, 400);
    std::vector<std::uint8_t> camera_ids;
    for (std::size_t i = 0; i < 400; ++i) camera_ids.push_back(i % 4 == 0 ? 7 : 2);  // a quarter
    ASSERT_TRUE(cells.assign(uv.data(), 2, 400, 40, nullptr, camera_ids.data()));
    std::map<std::uint8_t, std::size_t> of_camera;
    for (const Cell& cell : cells_of(cells, 400)) {
      for (const std::uint32_t i : cell) EXPECT_EQ(camera_ids[i], camera_ids[cell.front()]);
      ++of_camera[camera_ids[cell.front()]];
    }
    EXPECT_EQ(of_camera[7], 10U);
    EXPECT_EQ(of_camera[2], 30U);
  });
}

TEST(ImageCells, more_matches_than_the_capacity_are_refused_and_change_nothing) {
  const std::vector<double> uv(8, 1.0);
  ImageCells cells(3);
  ASSERT_TRUE(cells.assign(uv.data(), 2, 3, 2));
  const Cells before = cells_of(cells, 3);
  EXPECT_FALSE(cells.assign(uv.data(), 2, 4, 2));
  EXPECT_EQ(cells_of(cells, 3), before);
}

// Any number of cells may be asked for: no cell holds two matches, so that each is in one of its own.
TEST(ImageCells, more_cells_than_matches_hold_one_match_each) {
  constexpr std::size_t n = 1000;
  std::vector<double> uv;
  for (std::size_t i = 0; i < n; ++i) {
    uv.push_back(static_cast<double>(i % 37));
    uv.push_back(static_cast<double>(i % 29));
  }
  ImageCells cells(n);
  for (const std::size_t wanted : {n, n + 1, std::size_t{1} << 32U, std::size_t{1} << 62U, std::size_t{1} << 63U,
                                   std::numeric_limits<std::size_t>::max()}) {
    ASSERT_TRUE(cells.assign(uv.data(), 2, n, wanted));
    EXPECT_EQ(cells.count(), n) << wanted;
    for (const Cell& cell : cells_of(cells, n)) EXPECT_EQ(cell.size(), 1U) << wanted;
  }
}

TEST(ImageCells, a_capacity_beyond_what_an_index_can_count_is_refused) {
  EXPECT_THROW(ImageCells{std::size_t{1} << 32U}, std::bad_alloc);
  EXPECT_THROW(ImageCells{std::numeric_limits<std::size_t>::max()}, std::bad_alloc);
}

// On frames of all kinds: the budget is filled, required matches are in, and of the others no two share a cell.
TEST(GoodFeatures, spread_fills_the_budget_with_one_match_of_a_cell_besides_required_ones) {
  GoodFeatures good(300);
  good.spread = 1.5;
  for_frames_of_all_kinds(trials(100), 300, [&](Random&, FeatureFrame frame) {
    for (std::size_t i = 0; i < 300; i += 60) frame.matches[i].is_required = true;
    frame.gather(good);
    const Options options = with_budget(60);
    ASSERT_EQ(good.select(options).status, Status::ok) << good.reason();
    std::vector<unsigned char> is_spread(300);
    std::vector<double> uv;
    std::vector<std::uint8_t> camera_ids;
    for (std::size_t i = 0; i < 300; ++i) {
      const FeatureMatch& match = frame.matches[i];
      EXPECT_TRUE(good.is_selected(i) || !match.is_required);
      is_spread[i] = good.blocks().is_valid(i) && !match.is_required ? 1 : 0;
      uv.insert(uv.end(), match.measured, match.measured + 2);
      camera_ids.push_back(frame.kind.has_rig ? match.camera_id : std::uint8_t{0});
    }
    EXPECT_EQ(good.selection().size, 60U);
    ImageCells cells(300);
    ASSERT_TRUE(cells.assign(uv.data(), 2, 300, 90, is_spread.data(), camera_ids.data()));
    std::vector<int> selected_of_cell(cells.count());
    for (const std::uint32_t i : selected_of(good)) ++selected_of_cell[cells.groups()[i]];
    EXPECT_LE(*std::max_element(selected_of_cell.begin(), selected_of_cell.end()), 1);
  });
}

// Fewer cells than the budget: one match of each.
TEST(GoodFeatures, spread_below_one_selects_one_match_of_a_cell) {
  constexpr std::size_t n = 1000;
  GoodFeatures good(n);
  good.spread = 0.1;
  good.start(typical_camera(CameraModel::pinhole), RigidTransform::identity());
  for (std::size_t i = 0; i < n; ++i) {
    const double u = static_cast<double>(7 * i % 752), v = static_cast<double>(11 * i % 480);
    const double z = 2 + static_cast<double>(i % 17);
    good.add(Eigen::Vector3d((u - 367) / 458 * z, (v - 248) / 457 * z, z), Eigen::Vector2d(u, v));
  }
  EXPECT_EQ(good.select(900).status, Status::all_selected);
  EXPECT_EQ(good.selection().size, 90U);
  good.spread = 1e-9;
  EXPECT_EQ(good.select(900).size, 1U) << "at least one cell";
  good.spread = 1e300;
  EXPECT_EQ(good.select(900).size, 900U) << "as many cells as matches";
}

TEST(GoodFeatures, spread_that_is_no_number_selects_all_and_says_so) {
  Gathered it(200);
  for (const double spread : {-1.0, nan, infinity}) {
    it.good.spread = spread;
    EXPECT_EQ(it.good.select(50).error, Error::invalid_groups);
    EXPECT_EQ(it.good.selection().size, 200U);
  }
}

TEST(GoodFeatures, groups_of_the_caller_replace_spread) {
  Gathered it(200);
  std::vector<std::uint32_t> halves(200);
  for (std::size_t i = 0; i < 200; ++i) halves[i] = i % 2;
  Options options = with_budget(50);
  options.groups.ids = halves.data();
  options.groups.count = 2;
  options.groups.maximum = 25;
  ASSERT_EQ(it.good.select(options).status, Status::ok);
  const std::vector<std::uint32_t> expected = selected_of(it.good);
  it.good.spread = 1.5;
  ASSERT_EQ(it.good.select(options).status, Status::ok);
  EXPECT_EQ(selected_of(it.good), expected);
}

}  // namespace
}  // namespace maxlogdet::test
