// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/blocks/candidates.hpp"
#include "kernel/information/information_factor.hpp"

#include <cstddef>

namespace maxlogdet {

/// The candidates and the prior of a selection, without its groups.
struct Problem {
  const Candidates& candidates;
  const double* prior;           ///< M0, 6 x 6 row-major, symmetric positive definite
  const unsigned char* is_free;  ///< per candidate: nonzero if it may be selected and is not required
  std::size_t free_count;        ///< number of free candidates
  const Candidate* required;     ///< the candidates that every selection includes
  std::size_t required_count;
};

/// Adds a candidate's rows to an information; returns the relative gain.
double add_rows(const Problem& problem, Candidate candidate, InformationFactor& to) noexcept;

/// sum, 6 x 6: H^T H over the candidates i with counted[i] != 0, in a tenth of the time of adding their rows; but this
/// squares the condition number. Returns its roundings for InformationFactor::reset.
double sum_up(const Problem& problem, const unsigned char* counted, double* sum) noexcept;

}  // namespace maxlogdet
