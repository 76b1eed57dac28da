// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/base/aligned_array.hpp"
#include "simd/kernel.hpp"

#include <maxlogdet/block_store.hpp>
#include <maxlogdet/options.hpp>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace maxlogdet {

/// What a search looks at: the candidates that a store holds, one after the other, without those that are invalid and
/// without many that are excluded. Within `kernel/` a candidate is its place here; `indices` are the caller's, in
/// ascending order, so that the lower place is the lower index.
struct Candidates {
  simd::Planes planes;
  std::size_t count;
  int row_count;
  simd::Form form;                ///< what screening reads of them
  const double* largest;          ///< as BlockStore::column_max, of these candidates at least
  const double* largest_of_form;  ///< as simd::ColumnMax has it for the form; likewise
  const std::uint32_t* indices;   ///< of each candidate

  std::size_t size() const noexcept { return count; }
  int rows() const noexcept { return row_count; }
  const double* column_max() const noexcept { return largest; }
  const float* plane(int row, int column) const noexcept {
    return planes.data + static_cast<std::size_t>(simd::dimension * row + column) * planes.stride;
  }
};

/// All that a store holds.
Candidates all_of(const BlockStore& blocks) noexcept;

/// No row whose entries are at most these is longer.
double max_row_norm(const double* column_max) noexcept;

/// Room for a copy of up to `capacity` candidates.
struct CandidatesMemory {
  explicit CandidatesMemory(std::size_t capacity);

  std::size_t stride;
  AlignedArray<float> planes;
  std::vector<std::uint32_t> places;  ///< scratch: in the store
  std::vector<std::uint32_t> indices;
  double column_max[simd::dimension] = {};    ///< of those copied: no error bound is of what is excluded
  double factored_max[simd::dimension] = {};  ///< likewise
};

/// The same without those that `options.excluded` names, copied together if they are so many that the copy costs less
/// than looking at them; else all of them.
Candidates without_excluded(const BlockStore& blocks, const Options& options, const simd::Kernel& kernel,
                            CandidatesMemory& memory) noexcept;

}  // namespace maxlogdet
