// SPDX-License-Identifier: MIT
#pragma once

#include "bench/does_the_paper_hold/pnp_scene.hpp"
#include "bench/world/frame.hpp"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace maxlogdet::sim {

/// The outcome of one selection in one run.
struct PnpOutcome {
  double translation_m = 0;  ///< of the camera centre
  double rotation_deg = 0;
  double aligned_translation_m = 0;  ///< the same against the pose by the map's best rigid alignment
  double aligned_rotation_deg = 0;
  double bias_amplification = 0;      ///< sigma_max(H_x^+ H_p)
  double expected_translation_m = 0;  ///< root mean square by eqs. 5 to 7, for ordinary least squares at the true pose
  double expected_rotation_deg = 0;
};

/// The weighting of selectors without blocks.
constexpr char no_weighting[] = "-";

/// One row of the comparison.
struct PnpCase {
  double noise_px;
  std::size_t size;
  std::string weighting;
  std::string selector;  ///< a greedy metric, random, all, all_weighted
};

/// Returns all cases, in the order of the outcomes of a run. `all` and `all_weighted` have the size of all points.
std::vector<PnpCase> pnp_cases(const PnpOptions& options);

/// Computes a run: deterministic in options and run.
std::vector<PnpOutcome> run_pnp(const PnpOptions& options, std::uint64_t run);

/// Returns the frame of a run: map points, measurements with the first noise, and the guess as prior.
Frame pnp_frame(const PnpOptions& options, std::uint64_t run);

}  // namespace maxlogdet::sim
