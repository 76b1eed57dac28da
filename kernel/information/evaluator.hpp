// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/base/limits.hpp"
#include "simd/kernel.hpp"
#include "threading/team.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>

namespace maxlogdet {

/// Runs the kernels on candidates: on the calling thread, or in chunks on a team where there is enough work. The
/// results do not depend on the number of threads.
class Evaluator {
 public:
  /// `rows`: 1, 2 or 3, the maximum of the blocks; planes of further rows are not read.
  Evaluator(const simd::Kernel& kernel, const simd::Planes& planes, int rows, threading::Team& team) noexcept
      : kernel_(kernel), planes_(planes), rows_(rows), team_(team) {}

  const simd::Kernel& kernel() const noexcept { return kernel_; }
  const simd::Planes& planes() const noexcept { return planes_; }
  int rows() const noexcept { return rows_; }
  const simd::ExactFunctions& exact() const noexcept { return kernel_.exact[rows_ - 1]; }

  /// As simd::ExactFunctions::decide.
  void decide(const double* inverse_factor, const Candidate* listed, std::size_t count,
              double* relative_gains) const noexcept {
    // Runs on helpers: writes its own relative gains.
    team_.in_chunks(count, min_decisions, 1, [&](std::size_t first, std::size_t size, std::uint32_t) {
      exact().decide(planes_, inverse_factor, listed + first, size, relative_gains + first);
    });
  }

  /// As simd::ExactFunctions::losses; each tile is listed at most once.
  void losses(const simd::Tiles& tiles, const double* inverse_factor, const Tile* list, std::size_t count,
              double* losses, double* tile_loss) const noexcept {
    // Runs on helpers: writes the losses of its own tiles.
    team_.in_chunks(count, min_loss_tiles, 1, [&](std::size_t first, std::size_t size, std::uint32_t) {
      exact().losses(tiles, inverse_factor, list + first, size, losses, tile_loss);
    });
  }

  /// As simd::ExactFunctions::screen_traces.
  void screen_traces(const double* inverse_factor, const unsigned char* free, std::size_t count,
                     float* values) const noexcept {
    // Runs on helpers: writes its own values.
    team_.in_chunks(count, min_lanes, simd::tile_size, [&](std::size_t first, std::size_t size, std::uint32_t) {
      const simd::Planes planes{planes_.data + first, planes_.stride};
      exact().screen_traces(planes, inverse_factor, free + first, size, values + first);
    });
  }

  /// As simd::ExactFunctions::traces.
  void traces(const double* inverse_factor, const Candidate* listed, std::size_t count, double* values) const noexcept {
    // Runs on helpers: writes its own values.
    team_.in_chunks(count, min_decisions, 1, [&](std::size_t first, std::size_t size, std::uint32_t) {
      exact().traces(planes_, inverse_factor, listed + first, size, values + first);
    });
  }

  /// As simd::ArrayFunctions::count_at_least.
  std::size_t count_at_least(const float* values, std::size_t count, float threshold) const noexcept {
    std::size_t counts[threading::Team::max_chunks];
    // Runs on helpers: writes its own count.
    const std::uint32_t chunks = team_.in_chunks(
        count, min_counts, simd::tile_size, [&](std::size_t first, std::size_t size, std::uint32_t chunk) {
          counts[chunk] = kernel_.arrays.count_at_least(values + first, size, threshold);
        });
    return std::accumulate(counts, counts + chunks, std::size_t{0});
  }

  /// Lists the candidates with values[0 .. count) of at least `threshold`, in order; returns how many. `list` needs
  /// room for count + list_room.
  std::size_t list_at_least(const float* values, std::size_t count, float threshold, Candidate* list) const noexcept {
    std::size_t counts[threading::Team::max_chunks];
    Candidate* lists[threading::Team::max_chunks];
    // Runs on helpers: writes its own part of the list.
    const std::uint32_t chunks = team_.in_chunks(
        count, min_counts, simd::tile_size, [&](std::size_t first, std::size_t size, std::uint32_t chunk) {
          lists[chunk] = list + first + simd::tile_size * chunk;
          counts[chunk] = kernel_.arrays.list_candidates(values + first, size, threshold, float_infinity, lists[chunk]);
          for (std::size_t j = 0; j < counts[chunk]; ++j)
            lists[chunk][j] = static_cast<Candidate>(simd::number(lists[chunk][j]) + first);
        });
    std::size_t found = counts[0];
    for (std::uint32_t chunk = 1; chunk < chunks; ++chunk) {
      std::copy_n(lists[chunk], counts[chunk], list + found);
      found += counts[chunk];
    }
    return found;
  }
  static constexpr std::size_t list_room = simd::tile_size * (threading::Team::max_chunks + 1);

  /// As simd::LayoutFunctions::make_records.
  void make_records(simd::Form form, std::size_t count, float* records) const noexcept {
    // Runs on helpers: writes its own records.
    team_.in_chunks(count, min_lanes, simd::tile_size, [&](std::size_t first, std::size_t size, std::uint32_t) {
      const simd::Planes planes{planes_.data + first, planes_.stride};
      kernel_.layouts[form].make_records(planes, size, records + first * simd::record_size(form));
    });
  }

  /// As simd::LayoutFunctions::gather.
  void gather(simd::Form form, const float* records, const Candidate* listed, std::size_t count,
              float* tiles) const noexcept {
    // Runs on helpers: writes its own tiles.
    team_.in_chunks(count, min_lanes, simd::tile_size, [&](std::size_t first, std::size_t size, std::uint32_t) {
      kernel_.layouts[form].gather(records, listed + first, size, tiles + first * simd::entries_of(form));
    });
  }

  /// Copies candidates [0, count) in order to tiles, in the layout of gather(); reads up to the next multiple of 16
  /// candidates.
  void pack(simd::Form form, std::size_t count, float* tiles) const noexcept {
    // Runs on helpers: writes its own tiles.
    team_.in_chunks(count, min_lanes, simd::tile_size, [&](std::size_t first, std::size_t size, std::uint32_t) {
      const std::size_t entries = simd::entries_of(form);
      for (std::size_t lane = first; lane < first + size; lane += simd::tile_size) {
        for (std::size_t e = 0; e < entries; ++e) {
          const float* const plane = planes_.data + simd::plane_of(form, e) * planes_.stride + lane;
          std::copy_n(plane, simd::tile_size, tiles + lane * entries + e * simd::tile_size);
        }
      }
    });
  }

  threading::Team& team() const noexcept { return team_; }

 private:
  static constexpr std::size_t min_loss_tiles = 8;   // per chunk in float64
  static constexpr std::size_t min_lanes = 512;      // per chunk of copies
  static constexpr std::size_t min_decisions = 128;  // per chunk in float64
  static constexpr std::size_t min_counts = 4096;    // per chunk of values to count or list

  const simd::Kernel& kernel_;
  simd::Planes planes_;
  int rows_;
  threading::Team& team_;
};

}  // namespace maxlogdet
