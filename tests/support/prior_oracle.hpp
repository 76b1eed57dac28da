// SPDX-License-Identifier: MIT
#pragma once

#include "tests/support/support.hpp"

#include <maxlogdet/block_store.hpp>

namespace maxlogdet::test {

/// What is right of a question that rounding may decide.
enum class Verdict { good, bad, unclear };

/// The prior that a selection starts from, in long double, as docs/numerics.md has it ("Priors").
struct ExpectedPrior {
  Verdict verdict;      ///< whether it is accepted
  bool is_known;        ///< whether `information` is the one, and rounding decides nothing
  Matrix6 information;  ///< M0
};

/// `given`: as Options::prior.
ExpectedPrior expected_prior(const BlockStore& blocks, const double* given);

}  // namespace maxlogdet::test
