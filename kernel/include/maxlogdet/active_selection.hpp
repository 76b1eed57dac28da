// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/block_store.hpp>
#include <maxlogdet/options.hpp>
#include <maxlogdet/selection.hpp>

#include <cstddef>
#include <cstdint>
#include <memory>

namespace maxlogdet {

/// Selection hand in hand with matching (Zhao & Vela, Good Feature Matching, 2020): candidates are map points not
/// matched yet, next() proposes the one that adds most to what has been accepted, the tracker tries to match it, and
/// answers. If everything is accepted as proposed the answer is that of lazy_greedy, index for index. Only what is
/// proposed need be matched.
///
///   active.start(candidates, options);
///   for (std::uint32_t i; (i = active.next()) != ActiveSelection::none;) match(i) ? active.accept() : active.reject();
///
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
  /// Of the options it takes budget, prior, time_limit and
  /// the constraints (groups count what is accepted; what is required is accepted from the start); strategy is greedy,
  /// lazy_greedy or automatic, which are the same here. There is no certificate and no exchange. The statuses are those
  /// of Selector::select; after an error there is nothing to propose.
  Status start(const BlockStore& candidates, const Options& options) noexcept;

  /// The best of what has been neither accepted nor rejected; the same again until it is answered. `none` when the
  /// budget is reached, nothing is left, or the time limit has passed.
  std::uint32_t next() noexcept;

  /// The proposal is matched: it enters the selection as proposed. ok or nothing_proposed.
  Status accept() noexcept;
  /// It enters with the block as measured, rows x 6 row-major, rows in {1, 2, 3} (a stereo row added, say).
  /// nothing_proposed, or invalid_block (null, other rows, not finite), else ok; after invalid_block it is still
  /// proposed.
  Status accept(const double* block, int rows) noexcept;

  /// The proposal is not matched, and not proposed again. ok or nothing_proposed.
  Status reject() noexcept;

  /// What has been accepted, in that order; valid until the next call of anything but this. Status nothing_proposed
  /// before start(), `ok` also while there is more to propose.
  Selection selection() const noexcept;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace maxlogdet
