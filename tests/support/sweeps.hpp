// SPDX-License-Identifier: MIT
#pragma once

#include "tests/support/forced_isa.hpp"
#include "tests/support/support.hpp"
#include "tests/support/traced_random.hpp"

#include <string>

// The loops of most tests: over random problems, and over instruction sets.

namespace maxlogdet::test {

/// Calls body(random) with trials(count) variations of the test's seed, under a trace that names it, until one fails.
template <class Body>
void for_each_trial(std::size_t count, const Body& body) {
  for (std::uint64_t variation = 0; variation < trials(count); ++variation) {
    TracedRandom random(variation);
    body(random);
    if (::testing::Test::HasFailure()) return;
  }
}

/// As for_each_trial with blocks of every size from 10^first to 10^last: body(random, exponent).
template <class Body>
void for_each_exponent(int first, int last, const Body& body) {
  for (int exponent = first; exponent <= last; ++exponent) {
    Random random(static_cast<std::uint64_t>(exponent - first));
    SCOPED_TRACE(random.name() + ", 1e" + std::to_string(exponent));
    body(random, exponent);
    if (::testing::Test::HasFailure()) return;
  }
}

/// Calls body() on every instruction set of this machine, under a trace that names it.
template <class Body>
void for_every_isa(const Body& body) {
  for (const std::string& isa : sim::supported_isas()) {
    SCOPED_TRACE(isa);
    const ForcedIsa forced(isa.c_str());
    body();
  }
}

/// Expects function() to return the same on every instruction set, and returns it.
template <class Function>
auto same_on_every_isa(const Function& function) {
  const ForcedIsa forced(sim::supported_isas().front().c_str());
  const auto expected = function();
  for_every_isa([&] { EXPECT_EQ(function(), expected); });
  return expected;
}

/// Any instruction set of this machine.
inline ForcedIsa any_isa(Random& random) {
  const std::vector<std::string> isas = sim::supported_isas();
  return ForcedIsa(isas[random.index(isas.size())].c_str());
}

}  // namespace maxlogdet::test
