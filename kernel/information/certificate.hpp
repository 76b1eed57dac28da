// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/base/deadline.hpp"
#include "kernel/information/problem.hpp"
#include "kernel/information/top_traces.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace maxlogdet {

/// Memory of upper_bound among up to `capacity` candidates.
struct CertificateMemory {
  explicit CertificateMemory(std::size_t capacity) : traces(capacity), required(capacity) {}
  TraceMemory traces;
  std::vector<double> required;  ///< traces of the required candidates
};

/// A selection to start from, and how many candidates any selection may have.
struct Incumbent {
  const std::uint32_t* selected;
  std::size_t count;
  const double* inverse;  ///< W of its information
  std::size_t budget;
};

/// An upper bound of log det(M0 + sum of H^T H), nats, over all selections of at most `incumbent.budget` candidates
/// that hold all required ones and no others than these and the free ones; groups are left out, which can only raise
/// it. Proved, rounding included (docs/numerics.md); +infinity where nothing can be proved. At most `passes` passes of
/// Frank-Wolfe tighten it, as long as the deadline has not passed.
double upper_bound(const Problem& problem, const Incumbent& incumbent, std::size_t passes, const Deadline& deadline,
                   CertificateMemory& memory) noexcept;

}  // namespace maxlogdet
