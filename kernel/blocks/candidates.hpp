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

/// The candidates of a search: the valid ones of a store, contiguous, without the excluded ones where these are many.
/// `indices` are the caller's, in ascending order, so that the lower candidate has the lower index.
struct Candidates {
  simd::Planes planes;
  std::size_t count;
  int rows;
  simd::Form form;                ///< the form in which screening reads them
  const double* column_max;       ///< as BlockPlanes::column_max, over at least these candidates
  const double* largest_of_form;  ///< as simd::LayoutFunctions::column_max for the form, over the same candidates
  const std::uint32_t* indices;   ///< the caller's index of each candidate

  std::uint32_t index_of(Candidate candidate) const noexcept { return indices[simd::number(candidate)]; }
  const float* plane(int row, int column) const noexcept {
    return planes.data + static_cast<std::size_t>(simd::dimension * row + column) * planes.stride;
  }
};

/// All valid candidates of a store.
Candidates all_of(const BlockStore& blocks) noexcept;

/// An upper bound of the norm of any row, given the maximum |entry| of each column.
double max_row_norm(const double* column_max) noexcept;

/// Memory for a copy of up to `capacity` candidates.
struct CandidatesMemory {
  explicit CandidatesMemory(std::size_t capacity);

  std::size_t stride;
  AlignedArray<float> planes;
  std::vector<std::uint32_t> places;  ///< scratch: places in the store
  std::vector<std::uint32_t> indices;
  double column_max[simd::dimension] = {};    ///< of the copy: excluded candidates do not loosen bounds
  double factored_max[simd::dimension] = {};  ///< the same for the factored form
};

/// The same without those that `options.excluded` names, as a copy; all of them if so few are excluded that a copy does
/// not pay.
Candidates without_excluded(const BlockStore& blocks, const Options& options, const simd::Kernel& kernel,
                            CandidatesMemory& memory) noexcept;

}  // namespace maxlogdet
