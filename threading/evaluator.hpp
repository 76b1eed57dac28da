// SPDX-License-Identifier: MIT
#pragma once

#include "simd/kernel.hpp"
#include "threading/team.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace maxlogdet {
namespace threading {

/// Runs the kernels over candidates: on the calling thread, or in chunks over a team where there is enough to do. What
/// it computes does not depend on that.
class Evaluator {
 public:
  /// `rows` (1, 2 or 3) is that of the tallest block: planes of further rows are not read.
  Evaluator(const simd::Kernel& kernel, const simd::Planes& planes, int rows, Team& team) noexcept
      : kernel_(kernel), planes_(planes), rows_(rows), team_(team) {}

  const simd::Kernel& kernel() const noexcept { return kernel_; }
  const simd::Planes& planes() const noexcept { return planes_; }
  int rows() const noexcept { return rows_; }

  /// growths[j], in float64, for candidate indices[j], j in [0, count).
  void decide(const double* inverse_factor, const std::uint32_t* indices, std::size_t count,
              double* growths) const noexcept {
    in_chunks(count, least_decisions, 1, [&](std::size_t first, std::size_t size, std::uint32_t) {
      kernel_.decide[rows_ - 1](planes_, inverse_factor, indices + first, size, growths + first);
    });
  }

  /// As simd::MakeRecords.
  void make_records(std::size_t count, float* records) const noexcept {
    in_chunks(count, least_lanes, simd::tile_size, [&](std::size_t first, std::size_t size, std::uint32_t) {
      const simd::Planes planes{planes_.data + first, planes_.stride};
      kernel_.make_records[rows_ - 1](planes, size, records + first * simd::record_size(rows_));
    });
  }

  /// As simd::Gather.
  void gather(const float* records, const std::uint32_t* indices, std::size_t count, float* tiles) const noexcept {
    const auto entries = static_cast<std::size_t>(simd::dimension * rows_);
    in_chunks(count, least_lanes, simd::tile_size, [&](std::size_t first, std::size_t size, std::uint32_t) {
      kernel_.gather[rows_ - 1](records, indices + first, size, tiles + first * entries);
    });
  }

  static constexpr std::size_t chunks_per_worker = 4;  ///< so that a late helper still finds some
  static constexpr std::size_t most_chunks = chunks_per_worker * Team::most_workers;
  static constexpr std::size_t least_tiles = 32;  ///< of a chunk: half a microsecond of work

  /// How many chunks of at least so much work to make; at least 1.
  std::uint32_t chunks_of(std::size_t work, std::size_t least) const noexcept {
    if (team_.workers() == 1) return 1;
    const std::size_t wanted = chunks_per_worker * static_cast<std::size_t>(team_.workers());
    return static_cast<std::uint32_t>(std::max<std::size_t>(1, std::min(wanted, work / least)));
  }

  /// Calls body(chunk) for every chunk in [0, count), perhaps on several threads at once.
  template <class Body>
  void for_chunks(std::uint32_t count, const Body& body) const noexcept {
    if (count == 1) {
      body(0U);
    } else {
      team_.for_chunks(count, body);
    }
  }

  /// Calls body(first, size, chunk) for chunks of [0, count) that begin at multiples of `unit`; returns how many.
  template <class Body>
  std::uint32_t in_chunks(std::size_t count, std::size_t least, std::size_t unit, const Body& body) const noexcept {
    const std::uint32_t wanted = chunks_of(count, least);
    if (wanted == 1) {
      body(std::size_t{0}, count, 0U);
      return 1;
    }
    const auto quotient = [](std::size_t a, std::size_t b) { return (a + b - 1) / b; };  // rounded up
    const std::size_t size = quotient(quotient(count, unit), wanted) * unit;
    const auto chunks = static_cast<std::uint32_t>(quotient(count, size));
    for_chunks(chunks, [&](std::uint32_t chunk) {
      const std::size_t first = size * chunk;
      body(first, std::min(size, count - first), chunk);
    });
    return chunks;
  }

 private:
  static constexpr std::size_t least_lanes = 512;      // of a chunk of copies
  static constexpr std::size_t least_decisions = 128;  // of a chunk in float64

  const simd::Kernel& kernel_;
  simd::Planes planes_;
  int rows_;
  Team& team_;
};

}  // namespace threading
}  // namespace maxlogdet
