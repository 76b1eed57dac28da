// SPDX-License-Identifier: MIT
#pragma once

#include "bench/does_the_paper_hold/simulation.hpp"
#include "bench/does_the_paper_hold/tracking_arguments.hpp"
#include "bench/does_the_paper_hold/tracking_report.hpp"

#include <string>

namespace maxlogdet::sim {

/// Tracks along every sequence, run by run, so that an interrupted experiment has complete runs.
TrackingRuns simulate_tracking(Simulation& simulation, const std::string& experiment,
                               const TrackingArguments& arguments);

/// Returns what whitens residuals, for the headings of tables.
std::string described_weights(const TrackingArguments& arguments);

}  // namespace maxlogdet::sim
