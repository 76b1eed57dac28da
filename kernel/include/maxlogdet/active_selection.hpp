// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/block_store.hpp>
#include <maxlogdet/options.hpp>
#include <maxlogdet/selection.hpp>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <type_traits>

namespace maxlogdet {

/// Selection hand in hand with matching (Zhao & Vela, Good Feature Matching, 2020): candidates are map points not
/// matched yet, next() proposes those that add most to what has been accepted, the tracker tries to match them, and
/// answers. Only what is proposed need be matched.
///
///   active.start(candidates, options);
///   for (std::uint32_t i; (i = active.next()) != ActiveSelection::none;) match(i) ? active.accept() : active.reject();
///
/// One at a time this is greedy on the candidates that are not rejected: if everything is accepted as proposed the
/// answer is that of lazy_greedy, index for index. Batches are proposed by their gains before any of them is accepted:
/// they save time, here and in matching, and give away a little log det (docs/performance.md).
///
/// What has been evaluated since the last acceptance is not evaluated again: a proposal after a rejection costs a look
/// at the maxima of what has been, a sixteenth of the candidates at most, and fewer than that once some are selected.
/// Owns its memory as a Selector does; nothing but the constructor allocates, and it uses the calling thread alone.
class ActiveSelection {
 public:
  /// What next() returns when there is nothing to propose.
  static constexpr std::uint32_t none = 0xFFFFFFFFU;

  /// Room for stores of up to `capacity` candidates (at most 2^32 - 1). Throws std::bad_alloc, also above that.
  explicit ActiveSelection(std::size_t capacity);
  ~ActiveSelection();
  /// Takes over memory and selection; the other has a capacity of 0 from then on.
  ActiveSelection(ActiveSelection&&) noexcept;
  /// Takes over memory and selection; the other has a capacity of 0 from then on.
  ActiveSelection& operator=(ActiveSelection&&) noexcept;

  /// Most candidates, and largest budget, that start() accepts; 0 once moved from.
  std::size_t capacity() const noexcept;

  /// Begins anew, and with it the time limit, which so includes the matching. The candidates and all arrays of the
  /// options (groups above all) are the caller's, and must stay as they are until the last call of any other function.
  /// Of the options it takes budget, prior, time_limit, the targets and the constraints (groups count what is accepted;
  /// what is required is accepted from the start); strategy is greedy, lazy_greedy or automatic, which are the same
  /// here. There is no certificate and no exchange;
  /// exchange_sweeps beside a target is an error, as it is of Selector::select. target_efficiency compares with all
  /// blocks as offered, those that are rejected later among them; what is measured may so come to more than 1. The
  /// statuses are those of Selector::select; after an error there is nothing to propose.
  Status start(const BlockStore& candidates, const Options& options) noexcept;

  /// The best of what has been neither accepted nor rejected; while proposals are unanswered, the first of these again,
  /// after the time limit too. `none` when the budget is reached, nothing is left, or the time limit has passed; and
  /// once the targets are met, also while proposals of a batch are unanswered, which may still be answered.
  std::uint32_t next() noexcept;

  /// The `count` best by their gains now, best first, ties to the lowest index, written to `indices`; returns how many.
  /// Fewer only where no more may all be accepted: what is left, what the budget still asks for, and of a group what
  /// its maximum leaves, in whose place the next best are proposed. While proposals are unanswered, these again, at
  /// most `count`. With `count` = 1 this is next(). 0 where next() is `none`, and for a `count` of 0 or a null pointer,
  /// which change nothing.
  std::size_t next(std::uint32_t* indices, std::size_t count) noexcept;

  /// The first unanswered proposal is matched: it enters the selection as proposed. ok or nothing_proposed.
  Status accept() noexcept;
  /// It enters with the block as measured, rows x 6 row-major, rows in {1, 2, 3} (a stereo row added, say).
  /// nothing_proposed, or invalid_block (null, other rows, not finite), else ok; after invalid_block it is still
  /// proposed.
  Status accept(const double* block, int rows) noexcept;
  /// It is not matched, and not proposed again. ok or nothing_proposed.
  Status reject() noexcept;

  /// accept() for any of the unanswered proposals, in any order; nothing_proposed if this candidate is none of them.
  Status accept(std::uint32_t index) noexcept;
  /// accept(block, rows) likewise.
  Status accept(std::uint32_t index, const double* block, int rows) noexcept;
  /// reject() likewise.
  Status reject(std::uint32_t index) noexcept;
  /// Whether it is matched is no index.
  template <class Bool, class = typename std::enable_if<std::is_same<Bool, bool>::value>::type>
  Status accept(Bool) = delete;
  /// Likewise.
  template <class Bool, class = typename std::enable_if<std::is_same<Bool, bool>::value>::type>
  Status reject(Bool) = delete;

  /// Answers all unanswered proposals together, in their order: `matched` has a byte for each, where nonzero accepts,
  /// and `count` is how many they are, what next() has returned if none is answered yet. nothing_proposed, without
  /// effect, if there are none, or not as many, or for a null pointer; else ok.
  Status answer(const unsigned char* matched, std::size_t count) noexcept;

  /// What has been accepted, in that order; valid until the next call of anything but this. Status nothing_proposed
  /// before start(), `ok` also while there is more to propose, target_reached as soon as the targets are met;
  /// that the time limit has passed is known when next() is asked.
  Selection selection() const& noexcept;
  /// What it points to would end with this.
  Selection selection() const&& = delete;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace maxlogdet
