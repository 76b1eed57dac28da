// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/base/aligned_array.hpp"
#include "kernel/information/problem.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace maxlogdet {

/// Memory of find_top_traces for up to `capacity` candidates. Between its calls `exact` and `order` are free for
/// others' use.
struct TraceMemory {
  explicit TraceMemory(std::size_t capacity);
  AlignedArray<float> traces;         ///< per candidate, in whole tiles, float32
  std::vector<Candidate> contenders;  ///< candidates whose trace may be among the largest
  std::vector<double> exact;          ///< traces of listed candidates in float64
  AlignedArray<std::uint32_t> order;  ///< positions in the list, partially sorted
  std::vector<Candidate> top;         ///< the result
};

/// The free candidates of largest trace d_i = |H_i W^T|_F^2.
struct TopTraces {
  const Candidate* candidates;  ///< in ascending order; a view into the TraceMemory
  std::size_t count;
  double sum;       ///< of their d_i
  float threshold;  ///< close to the minimum of them: the next call's `guess`
};

/// The k free candidates of largest d_i, or all if there are fewer; d_i in float64, ties to the lowest index: the same
/// on every instruction set and number of threads. `w`: 6 x 8 row-major, lower triangular. `guess`: the threshold found
/// with a similar `w`, to save time.
TopTraces find_top_traces(const Problem& problem, const double* w, std::size_t k, float guess,
                          TraceMemory& memory) noexcept;

/// memory.order: the positions of the first `sorted` of `count` listed candidates by their traces at `w`, ties to the
/// lowest position. `before`: std::less or std::greater.
template <class Before>
void order_by_trace(const Problem& problem, const double* w, const Candidate* list, std::size_t count,
                    std::size_t sorted, const Before& before, TraceMemory& memory) noexcept {
  double* const traces = memory.exact.data();
  problem.evaluator.traces(w, list, count, traces);
  std::uint32_t* const order = memory.order;
  std::iota(order, order + count, 0U);
  std::partial_sort(order, order + sorted, order + count, [traces, &before](std::uint32_t a, std::uint32_t b) {
    return before(traces[a], traces[b]) || (traces[a] == traces[b] && a < b);
  });
}

/// The first `guess`: at an optimum the k largest d_i sum to at most 6.
inline float first_guess(std::size_t k) noexcept { return 3.0F / static_cast<float>(k + 1); }

/// An upper bound, for every candidate, of the error of |H W^T|_F from rounding W and forming H W^T, in units of the
/// unit roundoff and to first order (docs/numerics.md).
double trace_root_error(const Candidates& candidates, const double* w) noexcept;

}  // namespace maxlogdet
