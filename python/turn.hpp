// SPDX-License-Identifier: MIT
#pragma once

#include <stdexcept>

namespace maxlogdet::python {

/// Keeps an object from being used meanwhile: by another Python thread, which may run while this one selects, or by a
/// function that this one calls. The flag changes with the GIL held.
class Turn {
 public:
  /// Throws RuntimeError with the message if somebody else has the turn.
  Turn(bool& is_busy, const char* message) : is_busy_(is_busy) {
    if (is_busy) throw std::runtime_error(message);
    is_busy = true;
  }
  Turn(const Turn&) = delete;
  Turn& operator=(const Turn&) = delete;
  ~Turn() { is_busy_ = false; }

 private:
  bool& is_busy_;
};

}  // namespace maxlogdet::python
