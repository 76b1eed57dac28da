// SPDX-License-Identifier: MIT
#pragma once

// What a test in C needs: assertions that no NDEBUG takes away, and candidates.

#include <math.h>
#include <maxlogdet/maxlogdet.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CHECK(condition) check((condition) ? 1 : 0, #condition, __FILE__, __LINE__)
// For what the rest of a test cannot do without.
#define REQUIRE(condition)                 \
  do {                                     \
    if (!CHECK(condition)) exit(report()); \
  } while (0)

static int failures = 0;
static int checks = 0;
static const uint64_t seed = 20180703;
static uint64_t random_state = 20180703;

static int check(int holds, const char* condition, const char* file, int line) {
  ++checks;
  if (holds) return 1;
  ++failures;
  fprintf(stderr, "%s:%d: does not hold: %s (seed %llu)\n", file, line, condition, (unsigned long long)seed);
  return 0;
}

static int report(void) {
  printf("%d checks, %d failed\n", checks, failures);
  return failures == 0 ? 0 : 1;
}

// Uniform in [-1, 1), the same on every machine.
static double random_entry(void) {
  random_state = random_state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
  return (double)(random_state >> 11) / 4503599627370496.0 - 1;
}

// n candidates of 1 to 3 rows, every 50th without a block.
static maxlogdet_block_store* random_blocks(size_t n) {
  maxlogdet_block_store* blocks = NULL;
  REQUIRE(maxlogdet_block_store_create(n, &blocks) == MAXLOGDET_STATUS_OK);
  for (size_t i = 0; i < n; ++i) {
    double block[18];
    for (size_t e = 0; e < 18; ++e) block[e] = random_entry();
    if (i % 50 == 7) {
      CHECK(maxlogdet_block_store_push_back_invalid(blocks) == MAXLOGDET_STATUS_OK);
    } else {
      CHECK(maxlogdet_block_store_push_back(blocks, block, (int32_t)(1 + i % 3)) == MAXLOGDET_STATUS_OK);
    }
  }
  return blocks;
}

static maxlogdet_options default_options(void) {
  maxlogdet_options options;
  REQUIRE(maxlogdet_options_init(&options, sizeof options) == MAXLOGDET_STATUS_OK);
  return options;
}

static int same_value(double a, double b) { return a == b || (isnan(a) && isnan(b)); }

static int same_answer(const maxlogdet_selection* a, const maxlogdet_selection* b) {
  int is_same = a->status == b->status && a->size == b->size && same_value(a->log_det, b->log_det);
  for (size_t i = 0; is_same && i < a->size; ++i) {
    is_same = a->indices[i] == b->indices[i] && same_value(a->gains[i], b->gains[i]);
  }
  return is_same;
}
