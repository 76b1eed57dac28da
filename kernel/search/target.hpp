// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/information/factor.hpp"

#include <maxlogdet/block_store.hpp>
#include <maxlogdet/options.hpp>
#include <maxlogdet/selection.hpp>

namespace maxlogdet {

/// How much information is enough: the targets of Options. Decisions take products and sums in one order only, so that
/// a selection ends at the same candidate on every machine.
class Target {
 public:
  Target() = default;
  explicit Target(const Options& options) noexcept;

  /// Returns the first error of the targets, or none.
  static Error check(const Options& options) noexcept;

  /// Whether any target is given.
  static bool is_asked(const Options& options) noexcept {
    return options.target.efficiency != 0 || options.target.translation_sigma != 0 ||
           options.target.rotation_sigma != 0;
  }
  bool is_asked() const noexcept { return is_asked_; }

  /// Whether compare_with() must be called before the functions below.
  bool needs_all() const noexcept { return share_ > 0; }

  /// Sets M_all, the information of all candidates, which Options::target.efficiency compares with.
  void compare_with(const InformationFactor& all) noexcept;

  /// Whether the information meets every target given. NaN meets none.
  bool is_met(const InformationFactor& factor) const noexcept;

  /// Fills in the quantities of the targets given.
  void report(const InformationFactor& factor, Selection& selection) const noexcept;

 private:
  bool is_asked_ = false;
  double share_ = 0;  // Options::target.efficiency
  bool has_translation_ = false, has_rotation_ = false;
  double per_sigma_[simd::padded_dimension] = {};  // 1 / target of the deviation of each direction; 0: none
  double diagonal_of_all_[state_dimension] = {};   // of the Cholesky factor L of M_all
};

}  // namespace maxlogdet
