// SPDX-License-Identifier: MIT
#pragma once

#include "tests/support/oracle.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

// Helpers of the tests of the limits in docs/numerics.md.

namespace maxlogdet::test {

/// What an answer is worth to an oracle that follows it from the prior.
struct Judged {
  long double given_away = 0;  ///< the maximum over the rounds of the largest gain less that of what was taken, nats
  long double log_det = 0;
};
Judged judge(const BlockStore& blocks, const std::vector<std::uint32_t>& indices,
             const Matrix6& prior = default_information());

double longest_row(const BlockStore& blocks);

/// Expects `size` distinct valid indices, and a finite log det.
void expect_well_formed(const BlockStore& blocks, const Selection& selection, std::size_t size);

}  // namespace maxlogdet::test
