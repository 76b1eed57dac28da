// SPDX-License-Identifier: MIT
// Help from oneTBB, in C, by the installed headers alone.
#include <maxlogdet/tbb.h>
#include <stdio.h>
#include <string.h>

enum { n = 20000 };

int main(void) {
  maxlogdet_block_store* blocks;
  if (maxlogdet_block_store_create(n, &blocks) != MAXLOGDET_ERROR_NONE) return 1;
  for (int i = 0; i < n; ++i) {
    double block[12];
    for (int e = 0; e < 12; ++e) block[e] = (i * 7919 % 1000 + e * 104729 % 1000 + i % 1000 * e) % 1000 / 500.0 - 1;
    if (maxlogdet_block_store_push_back(blocks, block, 2) != MAXLOGDET_ERROR_NONE) return 1;
  }
  maxlogdet_options options;
  maxlogdet_executor executor;
  maxlogdet_selector *helped, *alone;
  if (maxlogdet_options_init(&options, sizeof options) != MAXLOGDET_ERROR_NONE ||
      maxlogdet_tbb_executor_init(&executor, sizeof executor) != MAXLOGDET_ERROR_NONE ||
      maxlogdet_selector_create(n, &executor, &helped) != MAXLOGDET_ERROR_NONE ||
      maxlogdet_selector_create(n, NULL, &alone) != MAXLOGDET_ERROR_NONE) {
    return 1;
  }
  options.budget = 100;
  options.strategy = MAXLOGDET_STRATEGY_GREEDY;  // which chooses all threads for so many candidates
  const maxlogdet_selection* of_helped = maxlogdet_selector_select(helped, blocks, &options);
  const maxlogdet_selection* of_alone = maxlogdet_selector_select(alone, blocks, &options);
  const int32_t slots = executor.concurrency(executor.user_data);
  const int is_right = of_alone->size == 100 && of_helped->size == 100 &&
                       memcmp(of_alone->indices, of_helped->indices, 100 * sizeof(uint32_t)) == 0 &&
                       of_helped->threads == (slots < 16 ? slots : 16);
  printf("in C on %d threads: %s\n", (int)of_helped->threads, is_right ? "right" : "WRONG");
  maxlogdet_selector_destroy(alone);
  maxlogdet_selector_destroy(helped);
  maxlogdet_block_store_destroy(blocks);
  return is_right ? 0 : 1;
}
