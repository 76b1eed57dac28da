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

/// Appends candidates as the bytes tell, until these tell to end: any values, also some that a store refuses, and what
/// rounding has trouble with, copies, multiples, and copies off by a bit. `store` gets at most max_candidates.
void append_candidates(Bytes& bytes, BlockStore& store);

/// rows x 6 entries of some kind, row-major, room for three rows.
struct AnyBlock {
  double entries[max_block_rows * state_dimension] = {};
  int rows = 0;
};
AnyBlock any_block(Bytes& bytes);

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
  std::vector<unsigned char> excluded_;
  std::vector<std::uint32_t> groups_;
  std::vector<std::uint32_t> maxima_;
};

/// Whether any target is given, be it one that is none.
bool has_target(const Options& options);

/// The same without.
Options without_target(Options options);

/// What options say of candidates, read as plainly as possible.
class Rules {
 public:
  Rules(const BlockStore& candidates, const Options& options) : candidates_(candidates), options_(options) {}

  bool is_required(std::size_t i) const { return is_set(options_.required, i); }
  bool is_excluded(std::size_t i) const { return is_set(options_.excluded, i); }
  bool has_groups() const { return options_.groups != nullptr && candidates_.size() > 0; }
  std::size_t maximum(std::size_t group) const {
    return options_.group_maxima != nullptr ? options_.group_maxima[group] : options_.max_per_group;
  }

  /// How many of these are in a group.
  std::size_t count_in(std::size_t group, const std::vector<std::uint32_t>& chosen) const;

  /// Whether one more could be added to those chosen, the budget left aside.
  bool may_add(std::size_t i, const std::vector<std::uint32_t>& chosen) const;

  std::vector<std::uint32_t> required() const;

  /// Everything that is wrong with the request, for a selector of this capacity; of several errors any may be named. An
  /// empty list: it has to be answered. `prior_is_unclear` where rounding decides whether the prior is one.
  std::vector<Status> errors(std::size_t capacity, bool& prior_is_unclear) const;

 private:
  static bool is_set(const unsigned char* flags, std::size_t i) { return flags != nullptr && flags[i] != 0; }

  const BlockStore& candidates_;
  const Options& options_;
};

/// The prior of the options as the documentation has it: the mean of the matrix and its transpose.
test::Matrix6 prior_of(const Options& options);

/// Fails unless this status is one that Rules expects; true if it is an error.
bool is_expected_error(const Rules& rules, std::size_t capacity, Status status);

}  // namespace maxlogdet::fuzz
