// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/frame_answer.hpp"
#include "kernel/frame_matches.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace maxlogdet {

/// Write Omega, or W, of match i, by the camera that its block is made with; false where there is none.
bool write_information(const FrameMatches& matches, std::size_t i, const BlockOptions& options, double* omega) noexcept;
bool write_whitening(const FrameMatches& matches, std::size_t i, const BlockOptions& options, double* W) noexcept;

/// Compares the unselected matches of a frame with the optimised pose.
class FrameJudge {
 public:
  explicit FrameJudge(std::size_t capacity);

  /// Nothing is judged yet.
  void start() noexcept { judged_ = 0; }
  /// Returns the outliers at the pose. `is_weighted`: by write_information(), else by the measurement's noise alone.
  IndexRange judge(const FrameMatches& matches, const FrameAnswer& answer, const RigidTransform& pose,
                   const BlockOptions& options, bool is_weighted) noexcept;
  /// Squared error in standard deviations; NaN where there is no saying.
  double chi2(std::size_t i) const noexcept { return i < judged_ ? chi2_[i] : not_a_number; }
  bool is_outlier(const FrameMatches& matches, std::size_t i) const noexcept;

 private:
  std::size_t judged_ = 0;  // the first matches
  std::vector<double> chi2_;
  std::vector<std::uint32_t> outliers_;
};

}  // namespace maxlogdet
