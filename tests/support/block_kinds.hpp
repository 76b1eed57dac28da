// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/maxlogdet.hpp>

namespace maxlogdet::test {

/// The kinds of blocks that tests over real and synthetic frames go through.
struct BlockKind {
  const char* name;
  Weighting weighting;
  DepthCue depth_cue;
};
constexpr BlockKind block_kinds[] = {
    {"map_bias", Weighting::map_bias, DepthCue::none},
    {"map_bias_stereo", Weighting::map_bias, DepthCue::stereo},
    {"map_bias_world", Weighting::map_bias_world, DepthCue::none},
    {"measurement", Weighting::measurement, DepthCue::none},
    {"measurement_stereo", Weighting::measurement, DepthCue::stereo},
    {"measurement_and_map_stereo", Weighting::measurement_and_map, DepthCue::stereo},
};

}  // namespace maxlogdet::test
