// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/jacobian.hpp>
#include <maxlogdet/selection.hpp>

#include <stdexcept>

namespace maxlogdet::python {

/// A status that is not an answer; Python sees it as SelectionError, with the status' name as its attribute.
class StatusError : public std::runtime_error {
 public:
  explicit StatusError(Status status);
  explicit StatusError(BlockStatus status);
  const char* status() const noexcept { return status_; }

 private:
  StatusError(const char* status, const char* explanation);
  const char* status_;
};

}  // namespace maxlogdet::python
