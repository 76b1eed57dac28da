// SPDX-License-Identifier: MIT
#pragma once

#include <stdexcept>
#include <string>

namespace maxlogdet::sim {

/// Unusable input: one line that names the file, the line, and what was expected.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Throws an InputError with this message unless a condition holds.
inline void require_input(bool holds, const std::string& message) {
  if (!holds) throw InputError(message);
}

}  // namespace maxlogdet::sim
