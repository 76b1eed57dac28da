// SPDX-License-Identifier: MIT
#pragma once

#include "tests/fuzz/bytes.hpp"
#include "tests/support/support.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace maxlogdet::fuzz {

constexpr std::size_t max_candidates = 600;

/// Appends the candidates that the bytes encode, up to max_candidates: any values, some that a store refuses, and cases
/// that are hard for rounding, which are copies, multiples, and copies with one bit changed.
void append_candidates(Bytes& bytes, BlockStore& store);

/// Options for these candidates, and the arrays that they point to.
class Request {
 public:
  Request(Bytes& bytes, const BlockStore& candidates);
  Request(const Request&) = delete;  // the options point into it
  Request& operator=(const Request&) = delete;

  Options options;
  std::size_t capacity = 0;  ///< of the selector to be asked; now and then too small

 private:
  void decode_prior(Bytes& bytes);
  void decode_constraints(Bytes& bytes, const BlockStore& candidates);
  void decode_targets(Bytes& bytes);

  double prior_[state_dimension * state_dimension];
  std::vector<unsigned char> required_;
  std::vector<std::uint32_t> groups_;
};

}  // namespace maxlogdet::fuzz
