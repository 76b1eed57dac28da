// SPDX-License-Identifier: MIT
#include "kernel/image_cells.hpp"

#include <algorithm>

namespace maxlogdet {

ImageCells::ImageCells(std::size_t capacity) {
  groups_.reserve(capacity);
  members_.reserve(capacity);
}

// The axis along which the members extend further.
std::size_t ImageCells::longer_side(Iterator begin, Iterator end) const noexcept {
  const auto extent = [&](std::size_t axis) {
    const auto less = [=](std::uint32_t a, std::uint32_t b) {
      return matches_[a].measured[axis] < matches_[b].measured[axis];
    };
    const auto sides = std::minmax_element(begin, end, less);
    return matches_[*sides.second].measured[axis] - matches_[*sides.first].measured[axis];
  };
  return extent(1) > extent(0) ? 1 : 0;
}

// Ties go to the lower index, so that the parts do not depend on the order of the members.
void ImageCells::divide(Iterator begin, Iterator end, std::size_t cells) noexcept {
  const auto size = static_cast<std::size_t>(end - begin);
  cells = std::min(cells, size);
  if (cells <= 1) {
    for (auto i = begin; i != end; ++i) groups_[*i] = count_;
    if (begin != end) ++count_;
    return;
  }
  const std::size_t axis = longer_side(begin, end);
  const std::size_t lower_cells = cells / 2;
  const auto middle = begin + static_cast<std::ptrdiff_t>((2 * size * lower_cells + cells) / (2 * cells));
  std::nth_element(begin, middle, end, [=](std::uint32_t a, std::uint32_t b) {
    const double at_a = matches_[a].measured[axis], at_b = matches_[b].measured[axis];
    return at_a < at_b || (at_a == at_b && a < b);
  });
  divide(begin, middle, lower_cells);
  divide(middle, end, cells - lower_cells);
}

// Cameras in turn, each with cells in proportion to its matches, at least one.
void ImageCells::divide_by_camera(Iterator begin, Iterator end, std::size_t cells) noexcept {
  while (begin != end) {
    const auto by_camera = [=](std::uint32_t a, std::uint32_t b) {
      return matches_[a].camera_id < matches_[b].camera_id;
    };
    const unsigned first = matches_[*std::min_element(begin, end, by_camera)].camera_id;
    const auto middle = std::partition(begin, end, [=](std::uint32_t i) { return matches_[i].camera_id == first; });
    const auto own = static_cast<std::size_t>(middle - begin), all = static_cast<std::size_t>(end - begin);
    const std::size_t share = std::max<std::size_t>((2 * cells * own + all) / (2 * all), 1);
    divide(begin, middle, share);
    cells -= std::min(cells, share);
    begin = middle;
  }
}

void ImageCells::limit(const FeatureMatch* matches, std::size_t size, const unsigned char* is_spread, std::size_t cells,
                       Options& options) noexcept {
  matches_ = matches;
  groups_.assign(size, 0);
  members_.clear();
  count_ = 0;
  for (std::uint32_t i = 0; i < size; ++i) {
    if (is_spread[i] != 0) {
      members_.push_back(i);
    } else {
      groups_[i] = count_++;
    }
  }
  divide_by_camera(members_.begin(), members_.end(), std::min(cells, size));
  options.groups.ids = groups_.data();
  options.groups.count = count_;
  options.groups.maximum = 1;
}

}  // namespace maxlogdet
