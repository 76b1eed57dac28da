// SPDX-License-Identifier: MIT
// Selections: answers, targets, and the name of every error.
#include "tests/api/c_api_tests.h"
#include "tests/api/c_check.h"

enum { n = 300 };

static void check_answers(maxlogdet_selector* selector, const maxlogdet_block_store* blocks) {
  maxlogdet_options options = default_options();
  options.certificate_compute = 1;
  options.budget = 50;
  const maxlogdet_selection* answer = maxlogdet_selector_select(selector, blocks, &options);
  CHECK(answer->status == MAXLOGDET_STATUS_OK && answer->size == 50 && answer->searched == 50);
  CHECK(answer->threads == 1 && strcmp(maxlogdet_selection_reason(answer), "ok") == 0);
  CHECK(answer->strategy == MAXLOGDET_STRATEGY_LAZY_GREEDY && answer->invalid_candidates == 6);
  CHECK(answer->evaluations > n && answer->error == MAXLOGDET_ERROR_NONE &&
        maxlogdet_selection_has_answer(answer) == 1);
  CHECK(answer->log_det <= answer->upper_bound);
  const double efficiency = maxlogdet_selection_certified_efficiency(answer);
  CHECK(efficiency > 0.5 && efficiency <= 1);
  double sum = 6 * log(1e-5);
  for (size_t i = 0; i < 50; ++i) {
    sum += answer->gains[i];
    CHECK(answer->indices[i] < n && maxlogdet_block_store_is_valid(blocks, answer->indices[i]) == 1);
  }
  CHECK(fabs(sum - answer->log_det) < 1e-6);

  options.certificate_compute = 0;
  answer = maxlogdet_selector_select(selector, blocks, &options);
  CHECK(isnan(answer->upper_bound) && isnan(maxlogdet_selection_certified_efficiency(answer)));
  options.budget = 295;
  options.strategy = MAXLOGDET_STRATEGY_AUTOMATIC;
  answer = maxlogdet_selector_select(selector, blocks, &options);
  CHECK(answer->status == MAXLOGDET_STATUS_ALL_SELECTED && answer->size == 294);
  CHECK(answer->strategy == MAXLOGDET_STRATEGY_BACKWARD_GREEDY && maxlogdet_selection_has_answer(answer) == 1);
}

static void check_targets(maxlogdet_selector* selector, const maxlogdet_block_store* blocks) {
  maxlogdet_options options = default_options();
  options.budget = 50;
  options.target_efficiency = 0.1;
  const maxlogdet_selection* answer = maxlogdet_selector_select(selector, blocks, &options);
  CHECK(answer->status == MAXLOGDET_STATUS_TARGET_REACHED && maxlogdet_selection_has_answer(answer) == 1);
  CHECK(answer->size > 0 && answer->size < 50 && answer->efficiency >= 0.1 - 1e-12);
  CHECK(isnan(answer->translation_sigma) && isnan(answer->rotation_sigma));
  options.target_efficiency = 1.5;
  answer = maxlogdet_selector_select(selector, blocks, &options);
  CHECK(answer->status == MAXLOGDET_STATUS_ERROR && answer->error == MAXLOGDET_ERROR_INVALID_TARGET);
  CHECK(strcmp(maxlogdet_selection_reason(answer), "invalid_target") == 0 &&
        maxlogdet_selection_has_answer(answer) == 0);
  options.target_efficiency = 0;
  options.target_translation_sigma = options.target_rotation_sigma = 100;
  answer = maxlogdet_selector_select(selector, blocks, &options);
  CHECK(answer->status == MAXLOGDET_STATUS_TARGET_REACHED && answer->translation_sigma <= 100);
  CHECK(answer->rotation_sigma <= 100 && isnan(answer->efficiency));
}

static void check_time_limits(maxlogdet_selector* selector, const maxlogdet_block_store* blocks) {
  maxlogdet_options options = default_options();
  options.time_limit = 1e-9;
  const maxlogdet_selection* answer = maxlogdet_selector_select(selector, blocks, &options);
  CHECK(answer->status == MAXLOGDET_STATUS_DEADLINE_REACHED && maxlogdet_selection_has_answer(answer) == 1);
  CHECK(answer->size == options.budget && answer->searched == 0);
  options.time_limit = (double)NAN;
  answer = maxlogdet_selector_select(selector, blocks, &options);
  CHECK(answer->error == MAXLOGDET_ERROR_INVALID_TIME_LIMIT && maxlogdet_selection_has_answer(answer) == 0);
  CHECK(answer->size == 0 && isnan(answer->log_det));
}

static void check_errors(maxlogdet_selector* selector, const maxlogdet_block_store* blocks) {
  maxlogdet_options options = default_options();
  options.strategy = 1000;
  CHECK(maxlogdet_selector_select(selector, blocks, &options)->error == MAXLOGDET_ERROR_INVALID_STRATEGY);
  options.strategy = MAXLOGDET_STRATEGY_STOCHASTIC_GREEDY;
  options.stochastic_epsilon = 1;
  CHECK(maxlogdet_selector_select(selector, blocks, &options)->error == MAXLOGDET_ERROR_INVALID_EPSILON);
  options = default_options();
  options.threads = -1;
  CHECK(maxlogdet_selector_select(selector, blocks, &options)->error == MAXLOGDET_ERROR_INVALID_THREADS);
  const double zeros[36] = {0};
  options = default_options();
  options.prior = zeros;
  CHECK(maxlogdet_selector_select(selector, blocks, &options)->error == MAXLOGDET_ERROR_INVALID_PRIOR);
}

void selections_answer_and_name_errors(void) {
  maxlogdet_block_store* const blocks = random_blocks(n);
  maxlogdet_selector* selector = NULL;
  REQUIRE(maxlogdet_selector_create(n, NULL, &selector) == MAXLOGDET_ERROR_NONE);
  CHECK(maxlogdet_selector_capacity(selector) == n);
  check_answers(selector, blocks);
  check_targets(selector, blocks);
  check_time_limits(selector, blocks);
  check_errors(selector, blocks);
  maxlogdet_selector_destroy(selector);

  REQUIRE(maxlogdet_selector_create(n - 1, NULL, &selector) == MAXLOGDET_ERROR_NONE);
  const maxlogdet_options options = default_options();
  CHECK(maxlogdet_selector_select(selector, blocks, &options)->error == MAXLOGDET_ERROR_CAPACITY_EXCEEDED);
  maxlogdet_selector_destroy(selector);
  maxlogdet_block_store_destroy(blocks);
}
