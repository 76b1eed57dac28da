// SPDX-License-Identifier: MIT
#include "kernel/blocks/candidates.hpp"

#include "kernel/blocks/block_planes.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace maxlogdet {
namespace {

// Excluded candidates are left out by a copy from this share on: it takes about as long as evaluating the same
// candidates once, and a search evaluates each several times.
constexpr std::size_t candidates_per_excluded = 8;

// Restricts `candidates` to those in the first `count` of memory.places, in a contiguous copy.
void copy_listed(std::size_t count, const simd::Kernel& kernel, Candidates& candidates,
                 CandidatesMemory& memory) noexcept {
  std::fill_n(memory.column_max, simd::dimension, 0.0);
  const std::size_t entries = std::size_t{simd::dimension} * static_cast<std::size_t>(candidates.rows);
  for (std::size_t plane = 0; plane < simd::planes_of_store; ++plane) {
    const bool is_point = plane >= simd::point_plane && candidates.form == simd::factored;
    if (plane >= entries && !is_point) continue;
    const float* const from = candidates.planes.data + plane * candidates.planes.stride;
    float* const to = memory.planes + plane * memory.stride;
    for (std::size_t i = 0; i < count; ++i) to[i] = from[memory.places[i]];
    double& largest = memory.column_max[plane % simd::dimension];
    if (!is_point) largest = std::max(largest, static_cast<double>(kernel.arrays.largest_magnitude(to, count)));
  }
  for (std::size_t i = 0; i < count; ++i) memory.indices[i] = candidates.indices[memory.places[i]];
  candidates.planes = {memory.planes, memory.stride};
  candidates.count = count;
  candidates.column_max = memory.column_max;
  candidates.largest_of_form = memory.column_max;
  candidates.indices = memory.indices.data();
}

}  // namespace

CandidatesMemory::CandidatesMemory(std::size_t capacity)
    : stride((capacity / simd::tile_size + 1) * simd::tile_size),
      planes(stride * simd::planes_of_store),
      places(capacity),
      indices(capacity) {}

Candidates all_of(const BlockStore& blocks) noexcept {
  const BlockPlanes& planes = planes_of(blocks);
  const simd::Form by_rows = simd::form_of_rows(std::max(planes.rows(), 1));
  return {{planes.plane(0, 0), planes.stride()},
          planes.stored(),
          planes.rows(),
          planes.is_factored() ? simd::factored : by_rows,
          planes.column_max(),
          planes.is_factored() ? planes.factored_max() : planes.column_max(),
          planes.indices()};
}

Candidates without_excluded(const BlockStore& blocks, const Options& options, const simd::Kernel& kernel,
                            CandidatesMemory& memory) noexcept {
  Candidates candidates = all_of(blocks);
  if (options.excluded == nullptr) return candidates;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < candidates.count; ++i) {
    memory.places[kept] = static_cast<std::uint32_t>(i);
    kept += options.excluded[candidates.indices[i]] == 0 ? 1 : 0;
  }
  if (candidates.count - kept < candidates.count / candidates_per_excluded + 1) return candidates;

  copy_listed(kept, kernel, candidates, memory);
  if (candidates.form == simd::factored) {
    kernel.blocks.factored_max(candidates.planes, kept, memory.factored_max);
    candidates.largest_of_form = memory.factored_max;
  }
  return candidates;
}

double max_row_norm(const double* column_max) noexcept {
  double squares = 0;
  for (int column = 0; column < simd::dimension; ++column) squares += column_max[column] * column_max[column];
  return std::sqrt(squares);
}

}  // namespace maxlogdet
