// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/jacobian.hpp>
#include <maxlogdet/selection.hpp>

#include <stdexcept>
#include <string>

namespace maxlogdet::python {

/// A status without an answer; in Python it is a SelectionError whose attribute is the name of the status.
class StatusError : public std::runtime_error {
 public:
  explicit StatusError(Status status);
  explicit StatusError(BlockStatus status);
  StatusError(BlockStatus status, const std::string& explanation);
  const char* status() const noexcept { return status_; }

 private:
  StatusError(const char* status, const std::string& explanation);
  const char* status_;
};

}  // namespace maxlogdet::python
