// SPDX-License-Identifier: MIT
// The C API allocates only where it says, and a lack of memory is a status.
#include "tests/api/c_api.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/support.hpp"
#include "tests/support/traced_random.hpp"

#include <cstddef>
#include <iterator>
#include <vector>

namespace maxlogdet::test {
namespace {

constexpr auto strategy_count = static_cast<maxlogdet_strategy>(std::size(strategies));

int answers_of_every_strategy(maxlogdet_selector* selector, const maxlogdet_block_store* blocks) {
  maxlogdet_options options;
  maxlogdet_options_init(&options, sizeof options);
  options.budget = 100;
  options.certificate_compute = 1;
  options.exchange_sweeps = 1;
  int answers = 0;
  for (const double limit : {0.0, 1e-5, -1.0}) {
    for (maxlogdet_strategy strategy = 0; strategy <= strategy_count; ++strategy) {  // the last is unknown
      options.time_limit = limit;
      options.strategy = strategy;
      answers += maxlogdet_selection_has_answer(maxlogdet_selector_select(selector, blocks, &options));
    }
  }
  options.struct_size = 1;
  maxlogdet_selector_select(selector, blocks, &options);
  return answers;
}

// Accepts, measures and rejects proposals in turn; returns how many candidates are selected.
std::size_t actively_selected(maxlogdet_active_selection* active, const maxlogdet_block_store* blocks,
                              const Block& measured) {
  maxlogdet_options options;
  maxlogdet_options_init(&options, sizeof options);
  options.budget = 100;
  maxlogdet_active_selection_start(active, blocks, &options);
  for (int i = 0; maxlogdet_active_selection_next(active) != MAXLOGDET_NONE; ++i) {
    if (i % 3 == 0) maxlogdet_active_selection_accept(active);
    if (i % 3 == 1) maxlogdet_active_selection_accept_block(active, measured.data(), 3);
    if (i % 3 == 2) maxlogdet_active_selection_reject(active);
  }
  return maxlogdet_active_selection_selection(active)->size;
}

constexpr double identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

// A frame of 400 matches.
void give_frame(maxlogdet_good_features* good) {
  maxlogdet_camera camera;
  maxlogdet_match match;
  maxlogdet_camera_init(&camera, sizeof camera);
  maxlogdet_match_init(&match, sizeof match);
  camera.fx = camera.fy = 450;
  maxlogdet_good_features_start(good, &camera, identity);
  for (int i = 0; i < 400; ++i) {
    match.point[0] = i % 20 - 9.5;
    match.point[1] = i / 20 - 9.5;
    match.point[2] = 10 + i % 7;
    match.measured[0] = match.measured[1] = 0;
    maxlogdet_good_features_add(good, &match);
  }
}

// Selects from a frame, judges the rest, and matches it actively; returns how many are selected.
std::size_t good_features_selected(maxlogdet_good_features* good) {
  maxlogdet_options options;
  maxlogdet_options_init(&options, sizeof options);
  options.budget = 100;
  give_frame(good);
  const std::size_t selected = maxlogdet_good_features_select(good, &options)->size;
  const std::uint32_t* outliers = nullptr;
  const std::size_t judged = maxlogdet_good_features_outliers(good, identity, &outliers);
  maxlogdet_good_features_select(good, nullptr);
  const auto find_all = [](void*, std::size_t, maxlogdet_match*) -> std::int32_t { return 1; };
  const std::size_t matched = maxlogdet_good_features_match(good, &options, find_all, nullptr)->size;
  return judged > 200 && matched == selected ? selected : 0;
}

TEST(RealTime, the_c_api_allocates_nothing_either) {
  TracedRandom random;
  const Block block = random_block(random, 3);
  const CBlocks blocks = c_blocks(400);
  const CSelector selector = c_selector(400);
  const CActive active = c_active(400);
  const CGoodFeatures good = c_good_features(400);
  good_features_selected(good.get());  // the first match() allocates
  int answers = 0;
  std::size_t accepted = 0;
  std::size_t selected = 0;
  EXPECT_EQ(allocations_in([&] {
              for (int i = 0; i < 400; ++i) maxlogdet_block_store_push_back(blocks.get(), block.data(), 1 + i % 3);
              answers = answers_of_every_strategy(selector.get(), blocks.get());
              accepted = actively_selected(active.get(), blocks.get(), block);
              selected = good_features_selected(good.get());
            }),
            0);
  EXPECT_EQ(answers, 2 * strategy_count) << "with each of the valid time limits";
  EXPECT_EQ(accepted, 100U);
  EXPECT_EQ(selected, 100U);
}

// Calls create() with ever more memory until it has enough; returns how often it had not.
template <class Create>
long failures_of(const Create& create) {
  for (long memory = 0;; ++memory) {
    fail_malloc_after(memory);
    const maxlogdet_error error = create();
    fail_malloc_after(-1);
    if (error == MAXLOGDET_ERROR_NONE || memory > 1000) return memory;
    EXPECT_EQ(error, MAXLOGDET_ERROR_OUT_OF_MEMORY);
  }
}

// Appends 1000 matches.
maxlogdet_error append(maxlogdet_block_store* blocks, const std::vector<double>& points) {
  maxlogdet_camera camera;
  maxlogdet_matches matches;
  maxlogdet_block_options options;
  maxlogdet_camera_init(&camera, sizeof camera);
  maxlogdet_matches_init(&matches, sizeof matches);
  maxlogdet_block_options_init(&options, sizeof options);
  camera.fx = camera.fy = 450;
  matches.size = 1000;
  matches.points = points.data();
  return maxlogdet_append_blocks(&camera, identity, &matches, &options, blocks, nullptr)->error;
}

// Whichever allocation fails: a status, nothing half created, and nothing lost.
TEST(RealTime, in_c_no_memory_is_a_status) {
#if defined(MAXLOGDET_HAS_SANITIZER)
  GTEST_SKIP() << "malloc is the sanitizer's";
#endif
  constexpr long arrays_of_store = 3;  // planes, validity and indices
  maxlogdet_block_store* blocks = nullptr;
  EXPECT_EQ(failures_of([&] { return maxlogdet_block_store_create(10, &blocks); }),
            2 + arrays_of_store);  // handle, store
  const CBlocks owned_blocks(blocks);
  maxlogdet_selector* selector = nullptr;
  const long of_selector = failures_of([&] { return maxlogdet_selector_create(10, nullptr, &selector); });
  const CSelector owned_selector(selector);
  EXPECT_GT(of_selector, 10);
  maxlogdet_active_selection* active = nullptr;
  const long of_active = failures_of([&] { return maxlogdet_active_selection_create(10, &active); });
  const CActive owned_active(active);
  EXPECT_GT(of_active, 10);
  maxlogdet_good_features* good = nullptr;
  EXPECT_GT(failures_of([&] { return maxlogdet_good_features_create(10, nullptr, &good); }), of_selector);
  const CGoodFeatures owned_good(good);
  give_frame(good);
  maxlogdet_options options;
  maxlogdet_options_init(&options, sizeof options);
  const auto find_none = [](void*, std::size_t, maxlogdet_match*) -> std::int32_t { return 0; };
  EXPECT_GT(failures_of([&] { return maxlogdet_good_features_match(good, &options, find_none, nullptr)->error; }),
            of_active);
  EXPECT_LT(of_active, of_selector) << "a search alone, without the memory of strategies";

  const double block[6] = {1, 2, 3, 4, 5, 6};
  for (int i = 0; i < 10; ++i) ASSERT_EQ(maxlogdet_block_store_push_back(blocks, block, 1), MAXLOGDET_ERROR_NONE);
  EXPECT_EQ(failures_of([&] { return maxlogdet_block_store_push_back(blocks, block, 1); }), arrays_of_store);
  EXPECT_EQ(maxlogdet_block_store_size(blocks), 11U);
  EXPECT_EQ(failures_of([&] { return maxlogdet_block_store_reserve(blocks, 1000); }), arrays_of_store);
  const std::vector<double> points(3000, 1);
  EXPECT_EQ(failures_of([&] { return append(blocks, points); }), arrays_of_store);
  EXPECT_EQ(maxlogdet_block_store_size(blocks), 1011U);
}

}  // namespace
}  // namespace maxlogdet::test
