// SPDX-License-Identifier: MIT
#include "tests/api/c_check.h"

static int failures = 0;
static int checks = 0;
static const uint64_t seed = 20180703;
static uint64_t random_state = 20180703;

const double identity_pose[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

int check(int holds, const char* condition, const char* file, int line) {
  ++checks;
  if (holds) return 1;
  ++failures;
  fprintf(stderr, "%s:%d: does not hold: %s (seed %llu)\n", file, line, condition, (unsigned long long)seed);
  return 0;
}

int report(void) {
  printf("%d checks, %d failed\n", checks, failures);
  return failures == 0 ? 0 : 1;
}

double random_entry(void) {
  random_state = random_state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
  return (double)(random_state >> 11) / 4503599627370496.0 - 1;
}

maxlogdet_block_store* random_blocks(size_t n) {
  maxlogdet_block_store* blocks = NULL;
  REQUIRE(maxlogdet_block_store_create(n, &blocks) == MAXLOGDET_ERROR_NONE);
  for (size_t i = 0; i < n; ++i) {
    double block[18];
    for (size_t e = 0; e < 18; ++e) block[e] = random_entry();
    if (i % 50 == 7) {
      CHECK(maxlogdet_block_store_push_back_invalid(blocks) == MAXLOGDET_ERROR_NONE);
    } else {
      CHECK(maxlogdet_block_store_push_back(blocks, block, (int32_t)(1 + i % 3)) == MAXLOGDET_ERROR_NONE);
    }
  }
  return blocks;
}

maxlogdet_options default_options(void) {
  maxlogdet_options options;
  REQUIRE(maxlogdet_options_init(&options, sizeof options) == MAXLOGDET_ERROR_NONE);
  return options;
}

static int same_value(double a, double b) { return a == b || (isnan(a) && isnan(b)); }

int same_answer(const maxlogdet_selection* a, const maxlogdet_selection* b) {
  int is_same = a->status == b->status && a->error == b->error && a->size == b->size && a->searched == b->searched &&
                same_value(a->log_det, b->log_det);
  for (size_t i = 0; is_same && i < a->size; ++i) {
    is_same = a->indices[i] == b->indices[i] && same_value(a->gains[i], b->gains[i]);
  }
  return is_same;
}
