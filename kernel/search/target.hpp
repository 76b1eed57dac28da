// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/information/information_factor.hpp"

#include <maxlogdet/block_store.hpp>
#include <maxlogdet/options.hpp>
#include <maxlogdet/selection.hpp>

namespace maxlogdet {

/// How much information is enough: the targets of Options. What it decides is made of products and sums in one order
/// alone, so that a selection ends at the same candidate on every machine.
class Target {
 public:
  explicit Target(const Options& options) noexcept;

  /// The first thing wrong with what is asked for; ok if nothing is.
  static Status check(const Options& options) noexcept;

  /// Whether any target is given.
  static bool is_asked(const Options& options) noexcept {
    return options.target_efficiency != 0 || options.target_translation_sigma != 0 ||
           options.target_rotation_sigma != 0;
  }
  bool is_asked() const noexcept { return is_asked_; }

  /// Whether compare_with() has to come before the functions below.
  bool needs_all() const noexcept { return share_ > 0; }

  /// The information of all candidates, of which target_efficiency is a share.
  void compare_with(const InformationFactor& all) noexcept;

  /// Whether the information meets every target given. What is not a number meets none.
  bool is_met(const InformationFactor& factor) const noexcept;

  /// Fills in how far the information is with what the targets are about.
  void report(const InformationFactor& factor, Selection& selection) const noexcept;

 private:
  bool is_asked_;
  double share_;  // target_efficiency
  bool has_translation_, has_rotation_;
  double per_sigma_[simd::padded_dimension] = {};  // 1 / target of the deviation of each direction; 0: none
  double diagonal_of_all_[state_dimension] = {};   // of the Cholesky factor L of the information of all
};

}  // namespace maxlogdet
