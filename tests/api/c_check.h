// SPDX-License-Identifier: MIT
#pragma once

// What a test in C needs: assertions that no NDEBUG takes away, and candidates.

#include <float.h>
#include <math.h>
#include <maxlogdet/maxlogdet.h>
#include <stddef.h>
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

int check(int holds, const char* condition, const char* file, int line);

// The program's exit code.
int report(void);

// Uniform in [-1, 1), the same on every machine.
double random_entry(void);

// n candidates of 1 to 3 rows, every 50th without a block.
maxlogdet_block_store* random_blocks(size_t n);

maxlogdet_options default_options(void);

int same_answer(const maxlogdet_selection* a, const maxlogdet_selection* b);

extern const double identity_pose[12];
