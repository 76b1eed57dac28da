// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/base/deadline.hpp"
#include "kernel/information/problem.hpp"
#include "kernel/information/top_traces.hpp"

#include <cstddef>

namespace maxlogdet {

/// The selection to start from, and the maximum number of candidates of any selection.
struct Incumbent {
  const Candidate* selected;
  std::size_t count;
  const double* inverse;  ///< W of its information
  std::size_t budget;
};

/// An upper bound of log det(M0 + sum of H^T H), nats, over all selections of at most `incumbent.budget` candidates
/// that hold all required ones and otherwise only free ones; groups are ignored, which can only raise it. Proved,
/// including rounding (docs/numerics.md); +infinity where nothing can be proved. At most `passes` Frank-Wolfe passes
/// tighten it, until the deadline.
double upper_bound(const Problem& problem, const Incumbent& incumbent, std::size_t passes, const Deadline& deadline,
                   TraceMemory& memory) noexcept;

}  // namespace maxlogdet
