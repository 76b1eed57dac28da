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

/// Active matching (Zhao & Vela, Good Feature Matching, 2020): candidates are map points that are not matched yet,
/// next() proposes those of maximum gain, and the tracker tries to match them and answers. Trackers use
/// GoodFeatures::match; here they answer in batches, or with blocks of their own.
///
///   active.start(candidates, options);
///   for (std::uint32_t i; (i = active.next()) != ActiveSelection::none;) match(i) ? active.accept() : active.reject();
///
/// One at a time, this is lazy_greedy on the candidates that are not rejected, index for index. Only the constructor
/// allocates, and only the calling thread is used. A move takes over memory and selection.
class ActiveSelection {
 public:
  /// What next() returns when there is nothing to propose.
  static constexpr std::uint32_t none = 0xFFFFFFFFU;

  /// Reserves room for stores of up to `capacity` candidates, at most 2^32 - 1. Throws std::bad_alloc, also above that.
  explicit ActiveSelection(std::size_t capacity);

  /// The maximum number of candidates, and the maximum budget, of start(); 0 after a move.
  std::size_t capacity() const noexcept;

  /// Starts a new selection, and its time limit, which includes the matching. Candidates and arrays of the options must
  /// not change before the last call of any other function. For options and errors see the guide; after an error
  /// nothing is proposed.
  Error start(const BlockStore& candidates, const Options& options) noexcept;

  /// Returns the candidate of maximum gain that is neither accepted nor rejected, or the first unanswered proposal.
  /// Returns `none` when the budget is reached, nothing is left, the time limit has passed with all answered, or the
  /// targets are met; proposals of a batch may then still be answered.
  std::uint32_t next() noexcept;

  /// Writes the `count` candidates of maximum current gain that may all be accepted, best first, and returns how many;
  /// fewer if the budget, groups or the candidates allow no more. While proposals are unanswered, returns these again.
  /// Returns 0 where next() is `none`, and for a `count` of 0 or a null pointer, which change nothing.
  std::size_t next(std::uint32_t* indices, std::size_t count) noexcept;

  /// Adds the first unanswered proposal to the selection, with its block as proposed. Returns none or nothing_proposed.
  Error accept() noexcept;
  /// Adds it with the block as measured, rows x 6 row-major, rows in {1, 2, 3} (with a stereo row, for example).
  /// Returns none, nothing_proposed, or invalid_block (null, rows not in {1, 2, 3}, not finite), after which it is
  /// still proposed.
  Error accept(const double* block, int rows) noexcept;
  /// Rejects it: it is not proposed again. Returns none or nothing_proposed.
  Error reject() noexcept;

  /// The same for any unanswered proposal, in any order; nothing_proposed if this candidate is not one.
  Error accept(std::uint32_t index) noexcept;
  /// The same with the block as measured.
  Error accept(std::uint32_t index, const double* block, int rows) noexcept;
  /// Rejects any unanswered proposal.
  Error reject(std::uint32_t index) noexcept;
  /// A bool is not an index.
  template <class Bool, class = typename std::enable_if<std::is_same<Bool, bool>::value>::type>
  Error accept(Bool) = delete;
  /// A bool is not an index.
  template <class Bool, class = typename std::enable_if<std::is_same<Bool, bool>::value>::type>
  Error reject(Bool) = delete;

  /// Answers all unanswered proposals in their order: `matched` has `count` bytes, where nonzero accepts, and `count`
  /// is the number of unanswered proposals. Returns nothing_proposed, without effect, if there are none or not as many,
  /// or for a null pointer; else none.
  Error answer(const unsigned char* matched, std::size_t count) noexcept;

  /// Returns what has been accepted, in that order; valid until the next call of any other function. The status is
  /// nothing_proposed before start(), `ok` also while there is more to propose, and target_reached once the targets are
  /// met; an expired time limit is noticed by next().
  Selection selection() const& noexcept;
  /// The selection would point into a destroyed object.
  Selection selection() const&& = delete;

 private:
  struct State;
  struct Destroy {
    void operator()(State* state) const noexcept;
  };
  std::unique_ptr<State, Destroy> state_;
};

}  // namespace maxlogdet
