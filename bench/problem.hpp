// SPDX-License-Identifier: MIT
#pragma once

#include "sim/frame.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

// What is selected from, and the exact answer to it; made once and kept.

namespace maxlogdet::bench {

enum class Blocks { one_row, two_rows, two_rows_measurement, three_rows, three_rows_measurement };

/// 1_row: the first row of each 2-row block, as a photometric residual has; 2_rows: map_bias; 2_rows_measurement:
/// measurement; 3_rows: map_bias, stereo; 3_rows_measurement: measurement, stereo.
const char* to_string(Blocks blocks) noexcept;

/// Families by name: those of sim::scenes, `equal_gains` (one block, n times), `nearly_equal_gains` (the same,
/// one entry moved by one float32 step each), and `real_frames`.
std::vector<std::string> scene_families();
std::vector<std::string> synthetic_families();  ///< all but `real_frames`
constexpr const char* real_frames = "real_frames";
constexpr std::uint64_t scene_seed = 1;

/// Where recorded frames are: $MAXLOGDET_DATA/orb_slam2_frames, by default ../shared/data/orb_slam2_frames. Empty if
/// they are not there.
std::string real_frames_folder();

/// A store of n candidates, made anew; of any family but `real_frames`, and not of `one_row`.
BlockStore synthetic_store(const std::string& family, std::size_t n, Blocks blocks, std::uint64_t seed);

/// The stores of a family: one of n candidates, or all recorded frames whatever n.
const std::vector<BlockStore>& stores_of(const std::string& family, std::size_t n, Blocks blocks);

/// Exact greedy's answer on each store.
struct ExactAnswer {
  std::vector<std::uint32_t> indices;
  double log_det = 0;
};
const std::vector<ExactAnswer>& exact_answers(const std::string& family, std::size_t n, Blocks blocks, std::size_t k);

}  // namespace maxlogdet::bench
