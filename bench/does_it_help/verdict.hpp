// SPDX-License-Identifier: MIT
#pragma once

#include "bench/does_it_help/evaluation.hpp"

#include <string>

namespace maxlogdet::sim {

/// What an evaluation says to a user.
struct Verdict {
  std::string text;         ///< in one or two sentences
  std::string recommended;  ///< a selector's name
  bool shares_errors = false;
};

/// Errors count as shared from this correlation of neighbours on, if its interval lies above half of it. Of the
/// recordings at hand ORB-SLAM2's have .01 to .04 and gain most by md, those of a patch-aligning
/// odometry .08 to .4, and gain most by md_spread (docs/odometry.md).
constexpr double shared_from = 0.06;

/// Decides by the budget next to 100, at which a selection pays if more random matches than that are needed for the
/// same pose, beyond the interval.
Verdict verdict_of(const Evaluation& evaluation);

}  // namespace maxlogdet::sim
