// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/status.hpp>

#include <cstddef>

namespace maxlogdet {

/// How a robust alignment ended (docs/alignment.md). With any other status than `aligned` no match is rejected.
enum class AlignmentStatus {
  none,           ///< there was no alignment since the last start(), or the frame has an error
  aligned,        ///< there are inliers, a pose and its information
  few_matches,    ///< fewer than ten matches are measured and have an image at the predicted pose
  no_consensus,   ///< fewer than half of them fit one pose, or it is at quite another distance from the points
  singular,       ///< the matches do not determine all six dimensions of the pose
  not_converged,  ///< the iterations diverged, or did not come to a pose that fits better than the predicted one
};

/// What an alignment found.
struct Alignment {
  AlignmentStatus status = AlignmentStatus::none;  ///< how it ended
  Error error = Error::none;                       ///< what is wrong with the frame; select() then says the same
  Warning warning = Warning::none;                 ///< a cue that does not fit, and was left out
  std::size_t measured = 0;                        ///< matches that were aligned: usable, with a measurement
  std::size_t inliers = 0;                         ///< how many of these fit
  double scale = 0;    ///< robust standard deviation of the whitened residuals: 1 if the sigmas are right
  int iterations = 0;  ///< steps of the pose

  /// Returns whether there are inliers, a pose and its information.
  bool is_aligned() const noexcept { return status == AlignmentStatus::aligned; }
  /// The name of the error; if there is none, of the warning; if there is none, of the status: for a log.
  const char* reason() const noexcept;
};

/// Name of the enumerator; "unknown" for any other value.
const char* to_string(AlignmentStatus status) noexcept;

inline const char* Alignment::reason() const noexcept {
  if (error != Error::none) return to_string(error);
  return warning != Warning::none ? to_string(warning) : to_string(status);
}

}  // namespace maxlogdet
