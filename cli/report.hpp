// SPDX-License-Identifier: MIT
#pragma once

#include "cli/evaluation.hpp"

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace maxlogdet::sim {

/// What an evaluation says to a user.
struct Verdict {
  std::string text;                 ///< in one or two sentences
  std::vector<std::string> advice;  ///< sentences; none if the frames cannot tell
  std::string recommended;          ///< "md" or "md_spread"; without a selection "aligned", pose(), or "all" inliers
  bool shares_errors = false;
  bool has_noise = true;  ///< without, no number means anything
};

/// Errors count as shared from this correlation of neighbours on, if its interval lies above half of it. Of the
/// recordings at hand ORB-SLAM2's have .01 to .04 and gain most by md, those of a patch-aligning
/// odometry .08 to .4, and gain most by md_spread (docs/evaluate.md).
constexpr double shared_from = 0.06;

/// Decides by the budget next to 100, at which a selection pays if its deviations are smaller than those of as many
/// random matches behind the same gate, beyond the interval.
Verdict verdict_of(const Evaluation& evaluation);

/// One object (docs/evaluate.md); null for what is unknown.
nlohmann::ordered_json to_json(const Evaluation& evaluation);

/// The verdict, the advice, what the frames are, and the tables, as a terminal shows them.
std::string to_text(const Evaluation& evaluation);

}  // namespace maxlogdet::sim
