// SPDX-License-Identifier: MIT
#pragma once

#include "bench/does_the_paper_hold/sequences.hpp"
#include "bench/does_the_paper_hold/simulation.hpp"
#include "bench/does_the_paper_hold/tracking_experiment.hpp"

#include <CLI/CLI.hpp>
#include <cstddef>
#include <string>

namespace maxlogdet::sim {

/// Options that `euroc` and `budget` share.
struct TrackingArguments {
  SimulationArguments common;
  SequenceOptions sequences;
  SelectorSettings selection;
  std::string weighting = "map_bias";
  std::string weights = "measurement";
  std::string strategy = "lazy_greedy";
  double map_sigma = 0.05;
  TrackingOptions options;

  void add_to(CLI::App& command);

  /// Sets `options` and `selection` by the other members, once the command line has been parsed.
  void complete();

  static constexpr std::size_t min_budget = 20;
  static constexpr std::size_t max_budget = 100'000;
};

}  // namespace maxlogdet::sim
