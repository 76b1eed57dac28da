// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/blocks/candidates.hpp"

#include <maxlogdet/block_store.hpp>

#include <cstddef>

namespace maxlogdet {

/// An information matrix: symmetric, with both triangles filled.
struct Information {
  double entry[state_dimension][state_dimension];
};

/// M0: the symmetric part of Options::prior, or 1e-5 I if that is null.
Information prior_information(const double* prior) noexcept;

/// M + sum of H^T H over the listed candidates, in their order.
Information plus_blocks(const Candidates& candidates, const Candidate* list, std::size_t count,
                        Information information) noexcept;

/// M <- M + scale H^T H.
void add_block(const Candidates& candidates, Candidate candidate, double scale, Information& information) noexcept;

Information difference(const Information& a, const Information& b) noexcept;

/// sum <- sum + scale a.
void add_scaled(double scale, const Information& a, Information& sum) noexcept;

}  // namespace maxlogdet
