// SPDX-License-Identifier: MIT
#include "kernel/screening/lane_order.hpp"

#include <algorithm>

namespace maxlogdet {
namespace {

constexpr std::int32_t buckets = lane_order_buckets;
using Counts = std::uint32_t[buckets + 1];  // per bucket; the last one holds the lanes that do not remain

}  // namespace

LaneOrderMemory::LaneOrderMemory(std::size_t capacity)
    : counts(threading::Team::max_chunks * (buckets + 1)),
      bucket(padded(capacity)),
      candidate(padded(capacity)),
      bucket_of_tile(padded(capacity) / simd::tile_size) {}

// A counting sort by the upper bits, with separate counts for each chunk of lanes.
std::size_t order_lanes(const LanesToOrder& lanes, threading::Team& team, LaneOrderMemory& memory) noexcept {
  auto* const first = reinterpret_cast<Counts*>(static_cast<std::uint32_t*>(memory.counts));  // per chunk
  std::uint32_t* const bucket = memory.bucket.data();
  Candidate* const ordered = memory.candidate.data();
  std::uint32_t* const bucket_of_tile = memory.bucket_of_tile.data();
  constexpr std::size_t min_lanes = 2048;  // per chunk
  const auto for_chunks = [&](auto body) { return team.in_chunks(lanes.count, min_lanes, simd::tile_size, body); };
  // Runs on helpers: writes the buckets of its own lanes, and its own counts.
  const std::uint32_t chunks = for_chunks([&](std::size_t begin, std::size_t size, std::uint32_t chunk) {
    for (std::size_t lane = begin; lane < begin + size; ++lane) {
      const std::int32_t below = (bits_of(lanes.top) - std::max(0, bits_of(lanes.values[lane]))) >> lane_order_shift;
      bucket[lane] = static_cast<std::uint32_t>(lanes.remaining[lane] > 0 ? std::min(below, buckets - 1) : buckets);
    }
    std::fill_n(first[chunk], buckets + 1, 0U);
    for (std::size_t lane = begin; lane < begin + size; ++lane) ++first[chunk][bucket[lane]];
  });
  std::uint32_t count = 0;  // prefix sum: lanes before each bucket of a chunk
  for (std::size_t b = 0; b <= buckets; ++b) {
    for (std::uint32_t chunk = 0; chunk < chunks; ++chunk) {
      const std::uint32_t in_bucket = first[chunk][b];
      first[chunk][b] = count;
      count += in_bucket;
    }
  }
  const std::size_t remaining = first[0][buckets];
  // Runs on helpers: writes the positions that its own counts lead to.
  for_chunks([&](std::size_t begin, std::size_t size, std::uint32_t chunk) {
    for (std::size_t lane = begin; lane < begin + size; ++lane) {
      const std::uint32_t position = first[chunk][bucket[lane]]++;
      ordered[position] = lanes.candidate[lane];
      if (position % simd::tile_size == 0) bucket_of_tile[position / simd::tile_size] = bucket[lane];
    }
  });
  return remaining;
}

}  // namespace maxlogdet
