// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/base/aligned_array.hpp"
#include "kernel/information/problem.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace maxlogdet {

/// Memory of find_top_traces among up to `capacity` candidates.
struct TraceMemory {
  explicit TraceMemory(std::size_t capacity);
  AlignedArray<float> traces;             ///< per candidate, whole tiles, float32
  std::vector<std::uint32_t> contenders;  ///< candidates that may be among the largest
  std::vector<double> exact;              ///< their traces in float64
  std::vector<std::uint32_t> places;      ///< of contenders, partly ordered
  std::vector<std::uint32_t> top;         ///< the result
};

/// The free candidates of largest trace d_i = |H_i W^T|_F^2.
struct TopTraces {
  const std::uint32_t* candidates;  ///< in ascending order; in the memory
  std::size_t count;
  double sum;       ///< of their d_i
  float threshold;  ///< about the smallest of them: where to look for it next time
};

/// The `wanted` free candidates of largest d_i, or all if there are fewer; d_i in float64, ties to the lowest index:
/// the same on every instruction set and number of threads. `w`: 6 x 8 row-major, lower triangular. `guess`: a
/// threshold that was found with a similar one; it saves time.
TopTraces find_top_traces(const Problem& problem, const double* w, std::size_t wanted, float guess,
                          TraceMemory& memory) noexcept;

/// A first guess: at an optimum the largest d_i sum to at most 6.
inline float first_guess(std::size_t wanted) noexcept { return 3.0F / static_cast<float>(wanted + 1); }

/// A bound of | |H W^T|_F - |H W^T|_F as computed | for every candidate, in units of the unit roundoff and to first
/// order, from rounding W and forming H W^T (docs/numerics.md).
double trace_root_error(const Candidates& candidates, const double* w) noexcept;

}  // namespace maxlogdet
