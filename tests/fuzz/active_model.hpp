// SPDX-License-Identifier: MIT
#pragma once

#include "tests/fuzz/exact.hpp"
#include "tests/fuzz/rules.hpp"
#include "tests/support/support.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace maxlogdet::fuzz {

/// What has to hold of an active selection, from a start to the next one: lists of what was proposed, accepted and
/// rejected.
class ActiveModel {
 public:
  ActiveModel(const BlockStore& blocks, const Options& options);

  /// Whether it says that the targets are met, as it should.
  void observe(const Selection& selection);

  void check_next(const std::vector<std::uint32_t>& proposed, std::size_t wanted);

  /// To the proposal of an index, or with `none` the first.
  void answer(Error error, std::uint32_t index, bool is_accepted, const test::Block* measured);
  void answer_all(Error error, const std::vector<unsigned char>& matched);
  void refuse(Error error, std::uint32_t index);

  const std::vector<std::uint32_t>& pending() const { return pending_; }

  void check_selection(const Selection& selection);

  /// Whether lazy_greedy has to have selected the same, if no more is proposed.
  bool is_as_proposed() const { return is_as_proposed_ && !is_late_; }

 private:
  // Those that may be accepted besides what is proposed already.
  std::vector<std::uint32_t> open_candidates() const;
  // How many of at most `wanted` may be accepted, whichever they are.
  std::size_t max_together(std::size_t wanted) const;
  std::vector<std::uint32_t>::iterator place_of(std::uint32_t index);
  // After the proposals before it.
  void check_best(std::uint32_t proposed);
  void accept(std::uint32_t i, const test::Block* measured = nullptr);

  const BlockStore& blocks_;
  const Options& options_;
  Rules rules_;
  Exact exact_;
  ExactTarget target_;
  std::vector<std::uint32_t> accepted_;
  std::vector<std::uint32_t> rejected_;
  std::vector<std::uint32_t> pending_;
  std::size_t compared_ = 0;
  long double allowed_ = 0;
  bool is_tame_ = true;
  bool is_late_ = false;
  bool is_enough_ = false;  // the targets are met
  bool is_as_proposed_ = true;
};

}  // namespace maxlogdet::fuzz
