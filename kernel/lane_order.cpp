// SPDX-License-Identifier: MIT
#include "kernel/lane_order.hpp"

#include <algorithm>

namespace maxlogdet {

std::uint32_t order_lanes(const float* values, const float* remaining, std::size_t lanes, float top,
                          std::uint32_t* bucket, std::uint32_t* order) noexcept {
  constexpr std::int32_t buckets = 512;
  for (std::size_t lane = 0; lane < lanes; ++lane) {
    const std::int32_t below = (bits_of(top) - std::max(0, bits_of(values[lane]))) >> lane_order_shift;
    bucket[lane] = static_cast<std::uint32_t>(remaining[lane] > 0 ? std::min(below, buckets - 1) : buckets);
  }
  std::uint32_t first[buckets + 1] = {};  // place of each bucket; the last is of those that do not remain
  for (std::size_t lane = 0; lane < lanes; ++lane) ++first[bucket[lane]];
  std::uint32_t count = 0;
  for (std::uint32_t& entry : first) {
    const std::uint32_t in_bucket = entry;
    entry = count;
    count += in_bucket;
  }
  count = first[buckets];
  for (std::size_t lane = 0; lane < lanes; ++lane) order[first[bucket[lane]]++] = static_cast<std::uint32_t>(lane);
  return count;
}

}  // namespace maxlogdet
