// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/frame.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

// Problems to select from.

namespace maxlogdet::bench {

enum class Blocks { two_rows, two_rows_measurement, three_rows, three_rows_measurement };

/// 2_rows: map_bias; 2_rows_measurement: measurement; 3_rows: map_bias, stereo; 3_rows_measurement: measurement,
/// stereo.
const char* to_string(Blocks blocks) noexcept;

/// Names of families: those of sim::scenes, `equal_gains` (n copies of one block), `nearly_equal_gains` (the same, one
/// entry of each changed by one float32 ulp), and `real_frames`.
std::vector<std::string> scene_families();
std::vector<std::string> synthetic_families();  ///< without `real_frames`
constexpr const char* real_frames = "real_frames";
constexpr std::uint64_t scene_seed = 1;

/// The folder of recorded frames, $MAXLOGDET_DATA/orb_slam2_frames, by default ../shared/data/orb_slam2_frames; empty
/// if it does not exist.
std::string real_frames_folder();

constexpr std::size_t max_block_entries = std::size_t{max_block_rows} * state_dimension;

/// Makes a store of n candidates. The family may not be `real_frames`.
BlockStore synthetic_store(const std::string& family, std::size_t n, Blocks blocks, std::uint64_t seed);

/// The stores of a family, made once and kept: one of n candidates, or all recorded frames, whatever n is.
const std::vector<BlockStore>& stores_of(const std::string& family, std::size_t n, Blocks blocks);

}  // namespace maxlogdet::bench
