// SPDX-License-Identifier: MIT
#include "kernel/frame_answer.hpp"

#include "kernel/selector_checks.hpp"

#include <algorithm>

namespace maxlogdet {

FrameAnswer::FrameAnswer(std::size_t capacity)
    : summary_(empty_selection(Error::none)), indices_(capacity), gains_(capacity), is_selected_(capacity) {
  start(nullptr);
}

void FrameAnswer::start(const double* prior) noexcept {
  for (std::size_t j = 0; j < size(); ++j) is_selected_[indices_[j]] = 0;
  summary_ = empty_selection(Error::none);
  summary_.status = Status::all_selected;
  has_prior_ = prior != nullptr;
  if (has_prior_) std::copy_n(prior, state_dimension * state_dimension, prior_);
}

void FrameAnswer::take(std::size_t i, double gain) noexcept {
  indices_[summary_.size] = static_cast<std::uint32_t>(i);
  gains_[summary_.size++] = gain;
  is_selected_[i] = 1;
}

void FrameAnswer::take(const Selection& selection) noexcept {
  const std::size_t before = size();
  for (std::size_t j = 0; j < selection.size; ++j) take(selection.indices[j], selection.gains[j]);
  const std::size_t after = size();
  summary_ = selection;
  summary_.size = after;
  summary_.searched += before;
}

void FrameAnswer::fail(Error why) noexcept {
  summary_.status = Status::error;
  summary_.error = why;
}

Selection FrameAnswer::selection() const noexcept {
  Selection selection = summary_;
  selection.indices = indices_.data();
  selection.gains = gains_.data();
  return selection;
}

}  // namespace maxlogdet
