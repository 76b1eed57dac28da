// SPDX-License-Identifier: MIT
#pragma once

#include "tests/support/oracle.hpp"
#include "tests/support/request.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace maxlogdet::test {

/// What an active selection has to propose; all gains are recomputed in long double for every proposal.
class ActiveModel {
 public:
  explicit ActiveModel(const Problem& problem);

  std::size_t size() const { return is_open_.size(); }
  std::size_t left() const { return left_; }
  bool is_open(std::size_t i) const { return is_open_[i] && has_room(i, places_); }
  std::size_t open_count() const;
  double log_det() const { return static_cast<double>(oracle_.log_det()); }

  /// Expects these to be the best of what may be accepted together.
  void expect_best(const std::vector<std::uint32_t>& proposed, std::size_t wanted) const;

  void take(std::uint32_t i);
  void take(std::uint32_t i, const Block& measured);
  void reject(std::uint32_t i) { is_open_[i] = false; }

 private:
  bool has_room(std::size_t i, const std::vector<std::uint32_t>& places) const {
    return places.empty() || places[groups_[i]] > 0;
  }
  void close(std::uint32_t i);
  void find_copies(const BlockStore& blocks);
  void expect_first_of_its_copies(const std::vector<std::uint32_t>& proposed, std::size_t j,
                                  const std::vector<std::uint32_t>& places) const;
  std::vector<long double> gains_of_open() const;
  std::vector<std::uint32_t> best(const std::vector<long double>& gains, std::size_t wanted) const;

  GreedyOracle<long double> oracle_;
  std::vector<std::uint32_t> groups_, places_;
  std::size_t left_;
  std::vector<bool> is_open_;
  std::vector<std::size_t> first_copy_;
};

}  // namespace maxlogdet::test
