// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>
#include <maxlogdet/maxlogdet.h>
#include <maxlogdet/maxlogdet.hpp>

#include <cstddef>
#include <memory>

namespace maxlogdet::test {

struct DestroyInC {
  void operator()(maxlogdet_block_store* blocks) const { maxlogdet_block_store_destroy(blocks); }
  void operator()(maxlogdet_good_features* good) const { maxlogdet_good_features_destroy(good); }
  void operator()(maxlogdet_selector* selector) const { maxlogdet_selector_destroy(selector); }
  void operator()(maxlogdet_active_selection* active) const { maxlogdet_active_selection_destroy(active); }
};
/// Owns what a function of the C API has created.
template <class Handle>
using Owned = std::unique_ptr<Handle, DestroyInC>;

using CBlocks = Owned<maxlogdet_block_store>;
using CGoodFeatures = Owned<maxlogdet_good_features>;
using CSelector = Owned<maxlogdet_selector>;
using CActive = Owned<maxlogdet_active_selection>;

inline CBlocks c_blocks(std::size_t capacity) {
  maxlogdet_block_store* made = nullptr;
  EXPECT_EQ(maxlogdet_block_store_create(capacity, &made), MAXLOGDET_ERROR_NONE);
  return CBlocks(made);
}

inline CGoodFeatures c_good_features(std::size_t capacity) {
  maxlogdet_good_features* made = nullptr;
  EXPECT_EQ(maxlogdet_good_features_create(capacity, nullptr, &made), MAXLOGDET_ERROR_NONE);
  return CGoodFeatures(made);
}

inline CSelector c_selector(std::size_t capacity) {
  maxlogdet_selector* made = nullptr;
  EXPECT_EQ(maxlogdet_selector_create(capacity, nullptr, &made), MAXLOGDET_ERROR_NONE);
  return CSelector(made);
}

inline CActive c_active(std::size_t capacity) {
  maxlogdet_active_selection* made = nullptr;
  EXPECT_EQ(maxlogdet_active_selection_create(capacity, &made), MAXLOGDET_ERROR_NONE);
  return CActive(made);
}

/// The same as a C caller puts it: what is not 0 is true.
inline maxlogdet_options options_in_c(const Options& options) {
  maxlogdet_options made;
  maxlogdet_options_init(&made, sizeof made);
  made.budget = options.budget;
  made.prior = options.prior;
  made.time_limit = options.time_limit;
  made.strategy = static_cast<maxlogdet_strategy>(options.strategy);
  made.threads = options.threads;
  made.required = options.required;
  made.excluded = options.excluded;
  made.target_efficiency = options.target.efficiency;
  made.target_translation_sigma = options.target.translation_sigma;
  made.target_rotation_sigma = options.target.rotation_sigma;
  made.group_ids = options.groups.ids;
  made.group_count = options.groups.count;
  made.group_maximum = options.groups.maximum;
  made.group_maxima = options.groups.maxima;
  made.certificate_compute = options.certificate.compute ? 7 : 0;
  made.certificate_passes = options.certificate.passes;
  made.stochastic_epsilon = options.stochastic.epsilon;
  made.stochastic_seed = options.stochastic.seed;
  made.exchange_sweeps = options.exchange.sweeps;
  return made;
}

}  // namespace maxlogdet::test
