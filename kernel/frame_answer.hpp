// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/base/limits.hpp"

#include <maxlogdet/selection.hpp>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace maxlogdet {

/// Which matches of a frame are selected, in what order, and how that ended.
class FrameAnswer {
 public:
  explicit FrameAnswer(std::size_t capacity);

  /// Starts an answer without matches to a question with that prior, 6 x 6, or nullptr.
  void start(const double* prior) noexcept;
  void take(std::size_t i, double gain = not_a_number) noexcept;
  /// Takes what is selected among candidates. What is known of it becomes known of the answer.
  void take(const Selection& selection) noexcept;
  void end(Status status) noexcept { summary_.status = status; }
  void fail(Error why) noexcept;

  std::size_t size() const noexcept { return summary_.size; }
  bool contains(std::size_t i) const noexcept { return is_selected_[i] != 0; }
  /// A view.
  Selection selection() const noexcept;
  const double* prior() const noexcept { return has_prior_ ? prior_ : nullptr; }

 private:
  Selection summary_;  // without its arrays
  std::vector<std::uint32_t> indices_;
  std::vector<double> gains_;
  std::vector<unsigned char> is_selected_;
  bool has_prior_ = false;
  double prior_[state_dimension * state_dimension];
};

}  // namespace maxlogdet
