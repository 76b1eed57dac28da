// SPDX-License-Identifier: MIT
#pragma once

#include "tests/support/support.hpp"

#include <gtest/gtest.h>

namespace maxlogdet::test {

/// Random numbers of this test, whose seed every failure prints while they exist.
class TracedRandom : public Random {
 public:
  using Random::Random;

 private:
  ::testing::ScopedTrace trace_{__FILE__, __LINE__, name()};
};

}  // namespace maxlogdet::test
