// SPDX-License-Identifier: MIT
#pragma once

#include "tests/support/support.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace maxlogdet::test {

/// Options with the arrays that they point to, each of which may be empty: then it is not given.
struct Request {
  std::vector<unsigned char> required, excluded;
  std::vector<std::uint32_t> groups, maxima;
  std::vector<double> prior;
  Options plain;  ///< all but the arrays; with maxima, group_count is how many there are

  Options options() const;
  Options options(Strategy strategy) const;

  void set_prior(const Matrix6& information);
  /// The prior, or the default one.
  Matrix6 information() const;

  bool is_required(std::size_t i) const { return !required.empty() && required[i] != 0; }
  bool is_excluded(std::size_t i) const { return !excluded.empty() && excluded[i] != 0; }
};

/// Candidates, and a request for some of them.
struct Problem : Request {
  BlockStore blocks;

  /// The capacity that a selector needs for it.
  std::size_t capacity() const;
  /// Whether a strategy may choose it: valid, not excluded, not required.
  bool is_free(std::size_t i) const { return blocks.is_valid(i) && !is_excluded(i) && !is_required(i); }
};

}  // namespace maxlogdet::test
