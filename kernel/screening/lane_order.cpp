// SPDX-License-Identifier: MIT
#include "kernel/screening/lane_order.hpp"

#include <algorithm>

namespace maxlogdet {

// A counting sort by the upper bits, with separate counts for each chunk of lanes.
std::size_t order_lanes(const float* values, const float* remaining, std::size_t lanes, float top,
                        threading::Team& team, std::uint32_t* counts, std::uint32_t* bucket, Lane* order) noexcept {
  constexpr std::int32_t buckets = lane_order_buckets;
  // Per chunk and bucket; the last bucket holds the lanes that do not remain.
  auto* const first = reinterpret_cast<std::uint32_t(*)[buckets + 1]>(counts);
  constexpr std::size_t min_lanes = 2048;  // per chunk
  const auto for_chunks = [&](auto body) { return team.in_chunks(lanes, min_lanes, simd::tile_size, body); };
  const std::uint32_t chunks = for_chunks([&](std::size_t begin, std::size_t size, std::uint32_t chunk) {
    for (std::size_t lane = begin; lane < begin + size; ++lane) {
      const std::int32_t below = (bits_of(top) - std::max(0, bits_of(values[lane]))) >> lane_order_shift;
      bucket[lane] = static_cast<std::uint32_t>(remaining[lane] > 0 ? std::min(below, buckets - 1) : buckets);
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
  const std::size_t all_remaining = first[0][buckets];
  for_chunks([&](std::size_t begin, std::size_t size, std::uint32_t chunk) {
    for (std::size_t lane = begin; lane < begin + size; ++lane) {
      order[first[chunk][bucket[lane]]++] = static_cast<Lane>(lane);
    }
  });
  return all_remaining;
}

}  // namespace maxlogdet
