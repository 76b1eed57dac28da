// SPDX-License-Identifier: MIT
#pragma once

#include "simd/kernel.hpp"

#include <maxlogdet/block_store.hpp>

#include <cstddef>
#include <cstdint>

namespace maxlogdet {

/// The candidates of a search: the valid ones of a store. `indices` are the caller's, in ascending order, so that the
/// lower candidate has the lower index.
struct Candidates {
  const simd::Kernel* kernel;
  simd::Planes planes;
  std::size_t count;
  int rows;
  simd::Form form;                ///< the form in which screening reads them
  const double* column_max;       ///< as BlockPlanes::column_max, over these candidates
  const double* largest_of_form;  ///< the same for the form: of a factored one of |A| [ I | |[X]x| ]
  const std::uint32_t* indices;   ///< the caller's index of each candidate

  const simd::ExactFunctions& exact() const noexcept { return kernel->exact[rows > 0 ? rows - 1 : 0]; }
  std::uint32_t index_of(Candidate candidate) const noexcept { return indices[simd::number(candidate)]; }
  const float* plane(int row, int column) const noexcept {
    return planes.data + static_cast<std::size_t>(simd::dimension * row + column) * planes.stride;
  }
};

/// All valid candidates of a store, for the functions of this kernel.
Candidates all_of(const BlockStore& blocks, const simd::Kernel& kernel) noexcept;

}  // namespace maxlogdet
