// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/blocks/candidates.hpp"
#include "kernel/information/evaluator.hpp"

#include <cstddef>
#include <cstdint>

namespace maxlogdet {

/// The candidates and the prior of a selection, without its groups.
struct Problem {
  const Candidates& candidates;
  const Evaluator& evaluator;
  const double* prior;            ///< as Options::prior
  const unsigned char* is_free;   ///< per candidate: nonzero if it may be selected and is not required
  std::size_t free_count;         ///< number of free candidates
  const std::uint32_t* required;  ///< the candidates that every selection includes
  std::size_t required_count;
};

}  // namespace maxlogdet
