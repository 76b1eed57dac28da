// SPDX-License-Identifier: MIT
#pragma once

#include "simd/kernel.hpp"

#include <maxlogdet/block_store.hpp>

#include <algorithm>
#include <cstddef>

namespace maxlogdet {

/// The blocks of a store as kernels read them; those of invalid candidates are zeros.
struct Candidates {
  Candidates() = default;
  Candidates(const BlockStore& blocks, const simd::Kernel& functions) noexcept
      : kernel(&functions),
        planes{blocks.planes(), blocks.stride()},
        count(blocks.size()),
        valid(blocks.validity()),
        valid_count(blocks.stored()),
        rows(blocks.rows()),
        form(blocks.is_factored() ? simd::factored : simd::form_of_rows(std::max(rows, 1))),
        column_max(blocks.column_max()),
        largest_of_form(blocks.is_factored() ? blocks.factored_max() : blocks.column_max()) {}

  const simd::ExactFunctions& exact() const noexcept { return kernel->exact[rows > 0 ? rows - 1 : 0]; }

  /// Reads the rows of a candidate into float64.
  void read_rows(Index i, double (&to)[max_block_rows][state_dimension]) const noexcept {
    for (int row = 0; row < rows; ++row) {
      for (int column = 0; column < state_dimension; ++column)
        to[row][column] = static_cast<double>(plane(row, column)[simd::number(i)]);
    }
  }
  const float* plane(int row, int column) const noexcept {
    return planes.data + static_cast<std::size_t>(state_dimension * row + column) * planes.stride;
  }

  const simd::Kernel* kernel = nullptr;
  simd::Planes planes = {};
  std::size_t count = 0;
  const unsigned char* valid = nullptr;  ///< per candidate
  std::size_t valid_count = 0;
  int rows = 0;
  simd::Form form = simd::one_row;          ///< the form in which screening reads them
  const double* column_max = nullptr;       ///< the largest |entry| of each column
  const double* largest_of_form = nullptr;  ///< the same for the form: of a factored one of |A| [ I | |[X]x| ]
};

}  // namespace maxlogdet
