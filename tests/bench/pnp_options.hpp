// SPDX-License-Identifier: MIT
#pragma once

#include "bench/does_the_paper_hold/pnp_experiment.hpp"

namespace maxlogdet::test {

inline sim::PnpOptions small_options() {
  sim::PnpOptions options;
  options.points = 40;
  options.noises = {1, 2};
  options.sizes = {20, 40};
  return options;
}

}  // namespace maxlogdet::test
