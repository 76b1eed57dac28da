// SPDX-License-Identifier: MIT
// Active selections: proposals one by one, in batches, and a start that is refused.
#include "tests/api/c_api_tests.h"
#include "tests/api/c_check.h"

enum { candidates = 100 };

static maxlogdet_active_selection* new_active_selection(void) {
  maxlogdet_active_selection* active = NULL;
  REQUIRE(maxlogdet_active_selection_create(candidates, &active) == MAXLOGDET_ERROR_NONE);
  CHECK(maxlogdet_active_selection_capacity(active) == candidates);
  return active;
}

// Accepting every proposal is what a selector selects.
static void check_accepting_all(maxlogdet_active_selection* active, const maxlogdet_block_store* blocks,
                                const maxlogdet_options* options) {
  maxlogdet_selector* selector = NULL;
  REQUIRE(maxlogdet_selector_create(candidates, NULL, &selector) == MAXLOGDET_ERROR_NONE);
  CHECK(maxlogdet_active_selection_start(active, blocks, options) == MAXLOGDET_ERROR_NONE);
  size_t accepted = 0;
  while (maxlogdet_active_selection_next(active) != MAXLOGDET_NONE) {
    CHECK(maxlogdet_active_selection_accept(active) == MAXLOGDET_ERROR_NONE);
    CHECK(maxlogdet_active_selection_selection(active)->size == ++accepted);
  }
  CHECK(accepted == 30);
  CHECK(
      same_answer(maxlogdet_active_selection_selection(active), maxlogdet_selector_select(selector, blocks, options)));
  maxlogdet_selector_destroy(selector);
}

static void check_measured_and_rejected(maxlogdet_active_selection* active, const maxlogdet_block_store* blocks,
                                        const maxlogdet_options* options) {
  const double block[12] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};
  const double not_finite[6] = {1, 2, 3, 4, 5, (double)INFINITY};
  CHECK(maxlogdet_active_selection_start(active, blocks, options) == MAXLOGDET_ERROR_NONE);
  const uint32_t first = maxlogdet_active_selection_next(active);
  CHECK(maxlogdet_active_selection_accept_block(active, NULL, 2) == MAXLOGDET_ERROR_INVALID_BLOCK);
  CHECK(maxlogdet_active_selection_accept_block(active, block, 0) == MAXLOGDET_ERROR_INVALID_BLOCK);
  CHECK(maxlogdet_active_selection_accept_block(active, block, 4) == MAXLOGDET_ERROR_INVALID_BLOCK);
  CHECK(maxlogdet_active_selection_accept_block(active, not_finite, 1) == MAXLOGDET_ERROR_INVALID_BLOCK);
  CHECK(maxlogdet_active_selection_next(active) == first);
  CHECK(maxlogdet_active_selection_accept_block(active, block, 2) == MAXLOGDET_ERROR_NONE);
  CHECK(maxlogdet_active_selection_accept_block(active, block, 2) == MAXLOGDET_ERROR_NOTHING_PROPOSED);
  const uint32_t second = maxlogdet_active_selection_next(active);
  CHECK(second != first && second < candidates);
  CHECK(maxlogdet_active_selection_reject(active) == MAXLOGDET_ERROR_NONE);
  CHECK(maxlogdet_active_selection_reject(active) == MAXLOGDET_ERROR_NOTHING_PROPOSED);
  CHECK(maxlogdet_active_selection_next(active) != second);
  const maxlogdet_selection* const selection = maxlogdet_active_selection_selection(active);
  CHECK(selection->size == 1 && selection->indices[0] == first && selection->status == MAXLOGDET_STATUS_OK);
}

void active_selection_proposes_and_takes_answers(void) {
  maxlogdet_block_store* const blocks = random_blocks(candidates);
  maxlogdet_active_selection* const active = new_active_selection();
  CHECK(maxlogdet_active_selection_next(active) == MAXLOGDET_NONE);
  CHECK(maxlogdet_active_selection_accept(active) == MAXLOGDET_ERROR_NOTHING_PROPOSED);
  CHECK(maxlogdet_active_selection_selection(active)->error == MAXLOGDET_ERROR_NOTHING_PROPOSED);

  maxlogdet_options options = default_options();
  options.budget = 30;
  check_accepting_all(active, blocks, &options);
  check_measured_and_rejected(active, blocks, &options);
  options.strategy = MAXLOGDET_STRATEGY_RELAXED;
  CHECK(maxlogdet_active_selection_start(active, blocks, &options) == MAXLOGDET_ERROR_INVALID_STRATEGY);
  maxlogdet_active_selection_destroy(active);
  maxlogdet_block_store_destroy(blocks);
}

void active_selection_proposes_batches(void) {
  maxlogdet_block_store* const blocks = random_blocks(candidates);
  maxlogdet_active_selection* const active = new_active_selection();
  maxlogdet_options options = default_options();
  options.budget = 10;
  CHECK(maxlogdet_active_selection_start(active, blocks, &options) == MAXLOGDET_ERROR_NONE);

  const double block[12] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};
  uint32_t batch[candidates];
  uint32_t again[candidates];
  CHECK(maxlogdet_active_selection_next_batch(active, NULL, 5) == 0);
  CHECK(maxlogdet_active_selection_next_batch(active, batch, 0) == 0);
  REQUIRE(maxlogdet_active_selection_next_batch(active, batch, 6) == 6);
  CHECK(maxlogdet_active_selection_next_batch(active, again, candidates) == 6 &&
        memcmp(again, batch, 6 * sizeof *batch) == 0);
  CHECK(maxlogdet_active_selection_next(active) == batch[0]);
  CHECK(maxlogdet_active_selection_accept_index(active, batch[4]) == MAXLOGDET_ERROR_NONE);
  CHECK(maxlogdet_active_selection_accept_index(active, batch[4]) == MAXLOGDET_ERROR_NOTHING_PROPOSED);
  CHECK(maxlogdet_active_selection_reject_index(active, batch[0]) == MAXLOGDET_ERROR_NONE);
  CHECK(maxlogdet_active_selection_reject_index(active, candidates) == MAXLOGDET_ERROR_NOTHING_PROPOSED);
  CHECK(maxlogdet_active_selection_accept_block_index(active, batch[2], NULL, 2) == MAXLOGDET_ERROR_INVALID_BLOCK);
  CHECK(maxlogdet_active_selection_accept_block_index(active, batch[2], block, 2) == MAXLOGDET_ERROR_NONE);
  const uint8_t matched[3] = {0, 1, 1};  // of 1, 3, 5
  CHECK(maxlogdet_active_selection_answer(active, matched, 2) == MAXLOGDET_ERROR_NOTHING_PROPOSED);
  CHECK(maxlogdet_active_selection_answer(active, NULL, 3) == MAXLOGDET_ERROR_NOTHING_PROPOSED);
  CHECK(maxlogdet_active_selection_answer(active, matched, 3) == MAXLOGDET_STATUS_OK);
  CHECK(maxlogdet_active_selection_answer(active, matched, 3) == MAXLOGDET_ERROR_NOTHING_PROPOSED);
  const maxlogdet_selection* const selection = maxlogdet_active_selection_selection(active);
  CHECK(selection->size == 4 && selection->indices[0] == batch[4] && selection->indices[1] == batch[2]);
  CHECK(selection->indices[2] == batch[3] && selection->indices[3] == batch[5]);
  CHECK(maxlogdet_active_selection_next_batch(active, batch, candidates) == 6);  // what the budget leaves
  maxlogdet_active_selection_destroy(active);
  maxlogdet_block_store_destroy(blocks);
}

// Whatever is asked or answered: nothing is under way.
static void check_nothing_to_answer(maxlogdet_active_selection* active, uint32_t index) {
  const uint8_t matched[1] = {1};
  CHECK(maxlogdet_active_selection_next(active) == MAXLOGDET_NONE);
  CHECK(maxlogdet_active_selection_accept(active) == MAXLOGDET_ERROR_NOTHING_PROPOSED);
  CHECK(maxlogdet_active_selection_accept_block(active, NULL, 1) == MAXLOGDET_ERROR_NOTHING_PROPOSED);
  CHECK(maxlogdet_active_selection_reject(active) == MAXLOGDET_ERROR_NOTHING_PROPOSED);
  CHECK(maxlogdet_active_selection_next_batch(active, &index, 1) == 0);
  CHECK(maxlogdet_active_selection_accept_index(active, index) == MAXLOGDET_ERROR_NOTHING_PROPOSED);
  CHECK(maxlogdet_active_selection_accept_block_index(active, index, NULL, 1) == MAXLOGDET_ERROR_NOTHING_PROPOSED);
  CHECK(maxlogdet_active_selection_reject_index(active, index) == MAXLOGDET_ERROR_NOTHING_PROPOSED);
  CHECK(maxlogdet_active_selection_answer(active, matched, 1) == MAXLOGDET_ERROR_NOTHING_PROPOSED);
  CHECK(maxlogdet_active_selection_selection(active)->error == MAXLOGDET_ERROR_INVALID_ARGUMENT);
  CHECK(maxlogdet_active_selection_selection(active)->size == 0);
}

// The candidates of the previous start may no longer exist: nothing may access them.
void a_start_that_is_refused_ends_what_was_under_way(void) {
  maxlogdet_block_store* blocks = random_blocks(20);
  maxlogdet_active_selection* active = NULL;
  REQUIRE(maxlogdet_active_selection_create(20, &active) == MAXLOGDET_ERROR_NONE);
  maxlogdet_options options = default_options();
  options.budget = 10;
  maxlogdet_options broken = options;
  broken.struct_size = 3;
  for (int way = 0; way < 3; ++way) {
    CHECK(maxlogdet_active_selection_start(active, blocks, &options) == MAXLOGDET_ERROR_NONE);
    uint32_t index = MAXLOGDET_NONE;
    CHECK(maxlogdet_active_selection_next_batch(active, &index, 1) == 1 && index < 20);
    const maxlogdet_error error = maxlogdet_active_selection_start(active, way == 0 ? NULL : blocks,
                                                                   way == 1   ? NULL
                                                                   : way == 2 ? &broken
                                                                              : &options);
    CHECK(error == MAXLOGDET_ERROR_INVALID_ARGUMENT);
    maxlogdet_block_store_destroy(blocks);
    check_nothing_to_answer(active, index);
    blocks = random_blocks(20);
  }
  maxlogdet_active_selection_destroy(active);
  maxlogdet_block_store_destroy(blocks);
}
