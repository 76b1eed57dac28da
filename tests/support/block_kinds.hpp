// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/maxlogdet.hpp>

namespace maxlogdet::test {

/// The kinds of blocks that tests over real and synthetic frames go through.
struct BlockKind {
  const char* name;
  Weighting weighting;
  ThirdMeasurement third;
};
constexpr BlockKind block_kinds[] = {
    {"map_bias", Weighting::map_bias, ThirdMeasurement::none},
    {"map_bias_stereo", Weighting::map_bias, ThirdMeasurement::stereo},
    {"map_bias_world", Weighting::map_bias_world, ThirdMeasurement::none},
    {"measurement", Weighting::measurement, ThirdMeasurement::none},
    {"measurement_stereo", Weighting::measurement, ThirdMeasurement::stereo},
    {"measurement_and_map_stereo", Weighting::measurement_and_map, ThirdMeasurement::stereo},
};

}  // namespace maxlogdet::test
