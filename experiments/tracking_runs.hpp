// SPDX-License-Identifier: MIT
#pragma once

#include "experiments/simulation.hpp"
#include "experiments/tracking_arguments.hpp"
#include "experiments/tracking_report.hpp"

#include <string>

namespace maxlogdet::sim {

/// Tracks along every sequence, run by run, so that a run that is broken off leaves complete ones behind.
TrackingRuns simulate_tracking(Simulation& simulation, const std::string& experiment,
                               const TrackingArguments& arguments);

/// What residuals are whitened by: tables that look alike differ in it.
std::string described_weights(const TrackingArguments& arguments);

}  // namespace maxlogdet::sim
