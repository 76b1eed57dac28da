// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/blocks/candidates.hpp"
#include "kernel/information/evaluator.hpp"

#include <cstddef>
#include <cstdint>

namespace maxlogdet {

/// What is asked of a selection, less its groups.
struct Problem {
  const Candidates& candidates;
  const Evaluator& evaluator;
  const double* prior;            ///< as Options::prior
  const unsigned char* is_free;   ///< per candidate: nonzero if it may be selected and is not required
  std::size_t free_count;         ///< how many are
  const std::uint32_t* required;  ///< the candidates that are selected in any case
  std::size_t required_count;
};

}  // namespace maxlogdet
