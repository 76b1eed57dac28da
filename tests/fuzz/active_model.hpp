// SPDX-License-Identifier: MIT
#pragma once

#include "tests/fuzz/exact.hpp"
#include "tests/fuzz/rules.hpp"
#include "tests/support/support.hpp"

#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

namespace maxlogdet::fuzz {

/// What has to hold of an active selection, from a start to the next one: lists of what was proposed and accepted, and
/// all that may still be proposed.
class ActiveModel {
 public:
  /// `error`, nats: of every gain, where all of them are to be compared. Infinite: compares some, where float64 has
  /// digits, by the error that docs/numerics.md allows.
  ActiveModel(const BlockStore& blocks, const Options& options, long double error = test::infinity);

  /// Whether it says that the targets are met, as it should.
  void observe(const Selection& selection);

  void check_next(const std::vector<std::uint32_t>& proposed, std::size_t wanted);

  /// To the proposal of an index, or with `none` the first.
  void answer(Error error, std::uint32_t index, bool is_accepted, const test::Block* measured);
  void answer_all(Error error, const std::vector<unsigned char>& matched);
  void refuse(Error error, std::uint32_t index);

  const std::vector<std::uint32_t>& pending() const { return pending_; }
  std::size_t accepted_count() const { return accepted_.size(); }
  /// How many may still be accepted, proposed already or not.
  std::size_t open_count() const;

  void check_selection(const Selection& selection);

  /// Whether lazy_greedy has to have selected the same, if no more is proposed.
  bool is_as_proposed() const { return is_as_proposed_ && !is_late_; }

 private:
  bool compares_all() const { return error_ < test::infinity; }
  // Of what may be accepted besides what is proposed already.
  bool is_open(std::uint32_t i) const;
  std::vector<std::uint32_t> open_candidates() const;
  // How many of at most `wanted` may be accepted, whichever they are.
  std::size_t max_together(std::size_t wanted) const;
  std::vector<std::uint32_t>::iterator place_of(std::uint32_t index);
  // After the proposals before it.
  void check_best(std::uint32_t proposed);
  void take_room(std::uint32_t i);
  void accept(std::uint32_t i, const test::Block* measured = nullptr);
  long double gain(std::uint32_t i);
  long double gain_error(long double gain) const { return compares_all() ? error_ / 2 : exact_.gain_error(gain); }

  const BlockStore& blocks_;
  const Options& options_;
  long double error_;
  Rules rules_;
  Exact exact_;
  ExactTarget target_;
  std::vector<test::Block> entries_;
  std::vector<std::uint32_t> accepted_;
  std::vector<std::uint32_t> pending_;
  std::vector<bool> is_left_;                      // may be proposed, and was not yet
  std::map<std::uint32_t, std::size_t> in_group_;  // accepted and proposed
  std::vector<long double> gains_;                 // since the last acceptance, NaN: not computed
  std::size_t compared_ = 0;
  long double allowed_ = 0;
  bool is_tame_ = true;
  bool is_late_ = false;
  bool is_enough_ = false;  // the targets are met
  bool is_as_proposed_ = true;
};

}  // namespace maxlogdet::fuzz
