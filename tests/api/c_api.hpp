// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/maxlogdet.h>
#include <maxlogdet/maxlogdet.hpp>

#include <memory>

namespace maxlogdet::test {

struct DestroyInC {
  void operator()(maxlogdet_block_store* blocks) const { maxlogdet_block_store_destroy(blocks); }
  void operator()(maxlogdet_selector* selector) const { maxlogdet_selector_destroy(selector); }
  void operator()(maxlogdet_active_selection* active) const { maxlogdet_active_selection_destroy(active); }
};
/// Owns what a function of the C API has made.
template <class Handle>
using Owned = std::unique_ptr<Handle, DestroyInC>;

/// The same as a C caller puts it: what is not 0 is true.
inline maxlogdet_options options_in_c(const Options& options) {
  maxlogdet_options made;
  maxlogdet_options_init(&made, sizeof made);
  made.budget = options.budget;
  made.strategy = static_cast<maxlogdet_strategy>(options.strategy);
  made.threads = options.threads;
  made.epsilon = options.epsilon;
  made.seed = options.seed;
  made.prior = options.prior;
  made.time_limit = options.time_limit;
  made.certify = options.certify ? 7 : 0;
  made.certificate_passes = options.certificate_passes;
  made.exchange_sweeps = options.exchange_sweeps;
  made.required = options.required;
  made.excluded = options.excluded;
  made.groups = options.groups;
  made.group_count = options.group_count;
  made.max_per_group = options.max_per_group;
  made.group_maxima = options.group_maxima;
  made.target_efficiency = options.target_efficiency;
  made.target_translation_sigma = options.target_translation_sigma;
  made.target_rotation_sigma = options.target_rotation_sigma;
  return made;
}

}  // namespace maxlogdet::test
