// SPDX-License-Identifier: MIT
#pragma once

#include "bench/does_the_paper_hold/tracking_experiment.hpp"
#include "bench/world/feature_selector.hpp"

namespace maxlogdet::test {

/// A selector with a small budget.
inline sim::SelectorSettings settings_of(sim::SelectorKind kind) {
  sim::SelectorSettings settings;
  settings.kind = kind;
  settings.budget = 40;
  settings.pool = 80;
  return settings;
}

inline sim::TrackingOutcome outcome_of(double rpe, double roe, double ate) {
  sim::TrackingOutcome outcome;
  outcome.errors.rpe_m_per_s = rpe;
  outcome.errors.roe_deg_per_s = roe;
  outcome.errors.ate_m = ate;
  return outcome;
}

}  // namespace maxlogdet::test
