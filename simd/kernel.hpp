// SPDX-License-Identifier: MIT
#pragma once

#include "simd/blocks.hpp"

#include <cstddef>
#include <cstdint>

// What an instruction set offers. Raw pointers in, raw pointers out: this header is all that a per-ISA translation
// unit shares with the rest, so that nothing compiled with wider instructions can be merged into baseline code.

namespace maxlogdet {
namespace simd {

constexpr int dimension = 6;  ///< of the state: translation, rotation

/// Candidates as a structure of arrays: entry (row, column) of candidate i is at
/// data[(dimension * row + column) * stride + i].
struct Planes {
  const float* data;
  std::size_t stride;
};

/// growths[i] for every candidate i in [begin, end).
using EvaluateRange = void (*)(const Planes& planes, const double* inverse_factor, std::size_t begin, std::size_t end,
                               double* growths);
/// growths[j] for candidate indices[j], j in [0, count).
using EvaluateListed = void (*)(const Planes& planes, const double* inverse_factor, const std::uint32_t* indices,
                                std::size_t count, double* growths);

/// The gain of a candidate H (r x 6) at information M = L L^T, as the relative growth of the determinant,
///     det(M + H^T H) / det(M) - 1 = det(I_r + Y Y^T) - 1,   Y = H L^-T,
/// not below 0, in float64, in one fixed order of operations: the same bits on every instruction set. Without the 1,
/// gains far below 2^-53 keep their digits.
/// `inverse_factor` is W = L^-1, 6 x 6 row-major, of which the lower triangle is read.
struct Kernel {
  const char* isa;
  EvaluateRange evaluate_range[3];    ///< [rows - 1]
  EvaluateListed evaluate_listed[3];  ///< [rows - 1]
  BuildBlocks build_blocks;           ///< see simd/blocks.hpp
};

/// Kernels built into this library, narrowest first, then nullptr.
const Kernel* const* built_in() noexcept;

/// Whether this machine (processor and operating system) can run it.
bool is_supported(const Kernel& kernel) noexcept;

/// The kernel that MAXLOGDET_ISA names, or the widest one supported when it is unset or empty;
/// nullptr when it names one that is not built in or that this machine lacks.
const Kernel* active() noexcept;

}  // namespace simd
}  // namespace maxlogdet
