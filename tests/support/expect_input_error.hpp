// SPDX-License-Identifier: MIT
#pragma once

#include "sim/input_error.hpp"

#include <gtest/gtest.h>

#include <string>

namespace maxlogdet::test {

/// Runs body(), which must throw an InputError: one short line that begins with the place and says what was expected.
template <class Body>
void expect_input_error(const Body& body, const std::string& place, const std::string& expected) {
  try {
    body();
    ADD_FAILURE() << "no error; expected one about " << expected << " at " << place;
  } catch (const sim::InputError& error) {
    const std::string message = error.what();
    EXPECT_EQ(message.rfind(place, 0), 0U) << message << "\ndoes not begin with " << place;
    EXPECT_NE(message.find("expected"), std::string::npos) << message;
    EXPECT_NE(message.find(expected), std::string::npos) << message << "\ndoes not tell: " << expected;
    EXPECT_EQ(message.find('\n'), std::string::npos) << "one line";
    EXPECT_LT(message.size(), place.size() + 180) << message;
  }
}

}  // namespace maxlogdet::test
