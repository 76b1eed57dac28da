// SPDX-License-Identifier: MIT
// Handles: what a store counts, what cannot be created, and null instead of any of them.
#include "tests/api/c_api_tests.h"
#include "tests/api/c_check.h"

#include <float.h>

void a_store_counts_what_it_holds(void) {
  maxlogdet_block_store* blocks = NULL;
  CHECK(maxlogdet_block_store_create(4, &blocks) == MAXLOGDET_ERROR_NONE);
  REQUIRE(blocks != NULL);
  CHECK(maxlogdet_block_store_size(blocks) == 0 && maxlogdet_block_store_capacity(blocks) == 4);
  CHECK(maxlogdet_block_store_rows(blocks) == 0 && maxlogdet_block_store_is_valid(blocks, 0) == 0);
  double block[24];
  for (size_t e = 0; e < 24; ++e) block[e] = random_entry();
  CHECK(maxlogdet_block_store_push_back(blocks, block, 1) == MAXLOGDET_ERROR_NONE);
  CHECK(maxlogdet_block_store_rows(blocks) == 1);
  CHECK(maxlogdet_block_store_push_back(blocks, block, 3) == MAXLOGDET_ERROR_NONE);
  CHECK(maxlogdet_block_store_rows(blocks) == 3 && maxlogdet_block_store_invalid_count(blocks) == 0);
  CHECK(maxlogdet_block_store_push_back_invalid(blocks) == MAXLOGDET_ERROR_NONE);
  // Kept as invalid: without a block, of an invalid number of rows, not finite, beyond float32.
  CHECK(maxlogdet_block_store_push_back(blocks, NULL, 2) == MAXLOGDET_ERROR_NONE);
  CHECK(maxlogdet_block_store_push_back(blocks, block, 0) == MAXLOGDET_ERROR_NONE);
  CHECK(maxlogdet_block_store_push_back(blocks, block, 4) == MAXLOGDET_ERROR_NONE);
  CHECK(maxlogdet_block_store_push_back(blocks, block, INT32_MIN) == MAXLOGDET_ERROR_NONE);
  block[5] = (double)NAN;
  CHECK(maxlogdet_block_store_push_back(blocks, block, 2) == MAXLOGDET_ERROR_NONE);
  block[5] = DBL_MAX;
  CHECK(maxlogdet_block_store_push_back(blocks, block, 2) == MAXLOGDET_ERROR_NONE);
  CHECK(maxlogdet_block_store_size(blocks) == 9 && maxlogdet_block_store_invalid_count(blocks) == 7);
  CHECK(maxlogdet_block_store_capacity(blocks) >= 9);
  for (size_t i = 0; i < 9; ++i) CHECK(maxlogdet_block_store_is_valid(blocks, i) == (i < 2));
  CHECK(maxlogdet_block_store_is_valid(blocks, 9) == 0 && maxlogdet_block_store_is_valid(blocks, SIZE_MAX) == 0);

  CHECK(maxlogdet_block_store_reserve(blocks, 1000) == MAXLOGDET_ERROR_NONE);
  CHECK(maxlogdet_block_store_capacity(blocks) == 1000 && maxlogdet_block_store_size(blocks) == 9);
  CHECK(maxlogdet_block_store_reserve(blocks, SIZE_MAX) == MAXLOGDET_ERROR_OUT_OF_MEMORY);
  CHECK(maxlogdet_block_store_reserve(blocks, (size_t)UINT32_MAX + 1) == MAXLOGDET_ERROR_OUT_OF_MEMORY);
  CHECK(maxlogdet_block_store_capacity(blocks) == 1000 && maxlogdet_block_store_is_valid(blocks, 1) == 1);
  CHECK(maxlogdet_block_store_clear(blocks) == MAXLOGDET_ERROR_NONE);
  CHECK(maxlogdet_block_store_size(blocks) == 0 && maxlogdet_block_store_capacity(blocks) == 1000);
  CHECK(maxlogdet_block_store_invalid_count(blocks) == 0 && maxlogdet_block_store_rows(blocks) == 0);
  maxlogdet_block_store_destroy(blocks);
}

void what_cannot_be_created_is_told_and_null(void) {
  int something = 0;  // what may not stay in the pointers
  maxlogdet_block_store* blocks = (maxlogdet_block_store*)&something;
  CHECK(maxlogdet_block_store_create(SIZE_MAX, &blocks) == MAXLOGDET_ERROR_OUT_OF_MEMORY && blocks == NULL);
  maxlogdet_selector* selector = (maxlogdet_selector*)&something;
  CHECK(maxlogdet_selector_create(SIZE_MAX, NULL, &selector) == MAXLOGDET_ERROR_OUT_OF_MEMORY && selector == NULL);
  maxlogdet_active_selection* active = (maxlogdet_active_selection*)&something;
  CHECK(maxlogdet_active_selection_create(SIZE_MAX, &active) == MAXLOGDET_ERROR_OUT_OF_MEMORY && active == NULL);
}

static const maxlogdet_error refused = MAXLOGDET_ERROR_INVALID_ARGUMENT;
static const double block_of_one_row[6] = {1, 2, 3, 4, 5, 6};

static void check_null_stores(void) {
  CHECK(maxlogdet_block_store_create(1, NULL) == refused);
  CHECK(maxlogdet_block_store_reserve(NULL, 1) == refused);
  CHECK(maxlogdet_block_store_clear(NULL) == refused);
  CHECK(maxlogdet_block_store_push_back(NULL, block_of_one_row, 1) == refused);
  CHECK(maxlogdet_block_store_push_back_invalid(NULL) == refused);
  CHECK(maxlogdet_block_store_size(NULL) == 0 && maxlogdet_block_store_capacity(NULL) == 0);
  CHECK(maxlogdet_block_store_rows(NULL) == 0 && maxlogdet_block_store_is_valid(NULL, 0) == 0);
  CHECK(maxlogdet_block_store_invalid_count(NULL) == 0);
  maxlogdet_block_store_destroy(NULL);
}

static void check_refusal(const maxlogdet_selection* selection) {
  CHECK(selection->status == MAXLOGDET_STATUS_ERROR && selection->error == refused);
  CHECK(selection->size == 0 && selection->searched == 0 && selection->indices == NULL);
  CHECK(isnan(selection->log_det) && isnan(selection->upper_bound));
  CHECK(isnan(selection->efficiency) && isnan(selection->translation_sigma));
  CHECK(isnan(selection->rotation_sigma) && selection->threads == 1);
  CHECK(strcmp(maxlogdet_selection_reason(selection), "invalid_argument") == 0);
  CHECK(maxlogdet_selection_has_answer(selection) == 0 && isnan(maxlogdet_selection_certified_efficiency(selection)));
}

static void check_null_selectors(const maxlogdet_block_store* blocks, const maxlogdet_options* options) {
  CHECK(maxlogdet_selector_create(1, NULL, NULL) == refused);
  CHECK(maxlogdet_selector_capacity(NULL) == 0);
  maxlogdet_selector_destroy(NULL);
  maxlogdet_selector* selector = NULL;
  REQUIRE(maxlogdet_selector_create(10, NULL, &selector) == MAXLOGDET_ERROR_NONE);
  check_refusal(maxlogdet_selector_select(NULL, blocks, options));
  check_refusal(maxlogdet_selector_select(selector, NULL, options));
  check_refusal(maxlogdet_selector_select(selector, blocks, NULL));
  check_refusal(maxlogdet_selector_select(NULL, NULL, NULL));
  check_refusal(maxlogdet_active_selection_selection(NULL));
  CHECK(strcmp(maxlogdet_selection_reason(NULL), "invalid_argument") == 0);
  CHECK(maxlogdet_selection_has_answer(NULL) == 0 && isnan(maxlogdet_selection_certified_efficiency(NULL)));
  maxlogdet_selector_destroy(selector);
}

static void check_null_active_selections(const maxlogdet_block_store* blocks, const maxlogdet_options* options) {
  CHECK(maxlogdet_active_selection_create(1, NULL) == refused);
  CHECK(maxlogdet_active_selection_capacity(NULL) == 0);
  CHECK(maxlogdet_active_selection_start(NULL, blocks, options) == refused);
  CHECK(maxlogdet_active_selection_next(NULL) == MAXLOGDET_NONE);
  CHECK(maxlogdet_active_selection_accept(NULL) == refused);
  CHECK(maxlogdet_active_selection_accept_block(NULL, block_of_one_row, 1) == refused);
  CHECK(maxlogdet_active_selection_reject(NULL) == refused);
  uint32_t index = 5;
  const uint8_t matched[1] = {1};
  CHECK(maxlogdet_active_selection_next_batch(NULL, &index, 1) == 0 && index == 5);
  CHECK(maxlogdet_active_selection_accept_index(NULL, 0) == refused);
  CHECK(maxlogdet_active_selection_accept_block_index(NULL, 0, block_of_one_row, 1) == refused);
  CHECK(maxlogdet_active_selection_reject_index(NULL, 0) == refused);
  CHECK(maxlogdet_active_selection_answer(NULL, matched, 1) == refused);
  maxlogdet_active_selection_destroy(NULL);
}

void null_is_refused_everywhere(void) {
  const maxlogdet_options options = default_options();
  check_null_stores();
  maxlogdet_block_store* const blocks = random_blocks(10);
  check_null_selectors(blocks, &options);
  check_null_active_selections(blocks, &options);
  maxlogdet_block_store_destroy(blocks);
}
