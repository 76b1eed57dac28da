// SPDX-License-Identifier: MIT
#pragma once

#include "bench/does_the_paper_hold/simulation.hpp"
#include "bench/does_the_paper_hold/tracking_arguments.hpp"
#include "bench/does_the_paper_hold/tracking_report.hpp"

#include <string>

namespace maxlogdet::sim {

/// Tracks along every sequence, in every run.
TrackingRuns simulate_tracking(const Simulation& simulation, const TrackingArguments& arguments);

/// Returns what the runs were computed with.
nlohmann::ordered_json settings_of(const TrackingArguments& arguments);

/// Returns what whitens residuals, for the headings of tables.
std::string described_weights(const TrackingArguments& arguments);

}  // namespace maxlogdet::sim
