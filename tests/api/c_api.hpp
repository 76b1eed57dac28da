// SPDX-License-Identifier: MIT
#pragma once

#include "tests/support/numbers.hpp"
#include "tests/support/support.hpp"

#include <gtest/gtest.h>
#include <maxlogdet/maxlogdet.h>
#include <maxlogdet/maxlogdet.hpp>

#include <memory>
#include <vector>

namespace maxlogdet::test {

struct DestroyInC {
  void operator()(maxlogdet_block_store* blocks) const { maxlogdet_block_store_destroy(blocks); }
  void operator()(maxlogdet_selector* selector) const { maxlogdet_selector_destroy(selector); }
  void operator()(maxlogdet_active_selection* active) const { maxlogdet_active_selection_destroy(active); }
};
/// Owns what a function of the C API has created.
template <class Handle>
using Owned = std::unique_ptr<Handle, DestroyInC>;

using CBlocks = Owned<maxlogdet_block_store>;
using CSelector = Owned<maxlogdet_selector>;
using CActive = Owned<maxlogdet_active_selection>;

inline CBlocks c_blocks(std::size_t capacity) {
  maxlogdet_block_store* made = nullptr;
  EXPECT_EQ(maxlogdet_block_store_create(capacity, &made), MAXLOGDET_STATUS_OK);
  return CBlocks(made);
}

inline CSelector c_selector(std::size_t capacity) {
  maxlogdet_selector* made = nullptr;
  EXPECT_EQ(maxlogdet_selector_create(capacity, nullptr, &made), MAXLOGDET_STATUS_OK);
  return CSelector(made);
}

inline CActive c_active(std::size_t capacity) {
  maxlogdet_active_selection* made = nullptr;
  EXPECT_EQ(maxlogdet_active_selection_create(capacity, &made), MAXLOGDET_STATUS_OK);
  return CActive(made);
}

/// The same as a C caller puts it: what is not 0 is true.
inline maxlogdet_options options_in_c(const Options& options) {
  maxlogdet_options made;
  maxlogdet_options_init(&made, sizeof made);
  made.budget = options.budget;
  made.strategy = static_cast<maxlogdet_strategy>(options.strategy);
  made.threads = options.threads;
  made.stochastic.epsilon = options.stochastic.epsilon;
  made.stochastic.seed = options.stochastic.seed;
  made.prior = options.prior;
  made.time_limit = options.time_limit;
  made.certificate.compute = options.certificate.compute ? 7 : 0;
  made.certificate.passes = options.certificate.passes;
  made.exchange.sweeps = options.exchange.sweeps;
  made.required = options.required;
  made.excluded = options.excluded;
  made.groups = options.groups;
  made.groups.count = options.groups.count;
  made.groups.maximum = options.groups.maximum;
  made.groups.maxima = options.groups.maxima;
  made.target.efficiency = options.target.efficiency;
  made.target.translation_sigma = options.target.translation_sigma;
  made.target.rotation_sigma = options.target.rotation_sigma;
  return made;
}

/// Expects as many candidates, the same of them valid: stored entries are out of sight in C.
inline void expect_same(const maxlogdet_block_store& in_c, const BlockStore& in_cpp) {
  EXPECT_EQ(maxlogdet_block_store_size(&in_c), in_cpp.size());
  EXPECT_EQ(maxlogdet_block_store_rows(&in_c), in_cpp.rows());
  EXPECT_EQ(maxlogdet_block_store_invalid_count(&in_c), in_cpp.invalid_count());
  for (std::size_t i = 0; i < in_cpp.size(); ++i) {
    EXPECT_EQ(maxlogdet_block_store_is_valid(&in_c, i) != 0, in_cpp.is_valid(i)) << i;
  }
}

/// Expects the same selection, bit for bit.
inline void expect_same(const maxlogdet_selection& in_c, const Selection& in_cpp) {
  ASSERT_EQ(in_c.status, static_cast<int>(in_cpp.status)) << maxlogdet_status_name(in_c.status);
  ASSERT_EQ(in_c.size, in_cpp.size);
  EXPECT_EQ(std::vector<std::uint32_t>(in_c.indices, in_c.indices + in_c.size), indices_of(in_cpp));
  for (std::size_t i = 0; i < in_c.size; ++i) EXPECT_TRUE(same_value(in_c.gains[i], in_cpp.gains[i])) << i;
  EXPECT_TRUE(same_value(in_c.log_det, in_cpp.log_det));
  EXPECT_TRUE(same_value(in_c.upper_bound, in_cpp.upper_bound));
  EXPECT_TRUE(same_value(maxlogdet_selection_efficiency(&in_c), in_cpp.efficiency()));
  EXPECT_TRUE(same_value(in_c.efficiency, in_cpp.efficiency));
  EXPECT_TRUE(same_value(in_c.translation_sigma, in_cpp.translation_sigma));
  EXPECT_TRUE(same_value(in_c.rotation_sigma, in_cpp.rotation_sigma));
  EXPECT_EQ(in_c.evaluations, in_cpp.evaluations);
  EXPECT_EQ(in_c.float64_decisions, in_cpp.float64_decisions);
  EXPECT_EQ(in_c.invalid_candidates, in_cpp.invalid_candidates);
  EXPECT_EQ(in_c.strategy, static_cast<int>(in_cpp.strategy));
  EXPECT_EQ(in_c.threads, in_cpp.threads);
  EXPECT_EQ(maxlogdet_selection_has_answer(&in_c) != 0, in_cpp.has_answer());
}

}  // namespace maxlogdet::test
