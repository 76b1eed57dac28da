// SPDX-License-Identifier: MIT
#pragma once

#include <stdexcept>

namespace maxlogdet::sim {

/// Input that cannot be used: one line that names the file, the line, and what was expected.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace maxlogdet::sim
