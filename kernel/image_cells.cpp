// SPDX-License-Identifier: MIT
#include <maxlogdet/image_cells.hpp>

#include "kernel/base/limits.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace maxlogdet {

struct ImageCells::State {
  using Iterator = std::vector<std::uint32_t>::iterator;

  explicit State(std::size_t capacity) : max_matches(checked_capacity(capacity)) {
    groups.reserve(capacity);
    members.reserve(capacity);
  }

  double at(std::uint32_t i, std::size_t axis) const noexcept { return uv[stride * i + axis]; }
  unsigned camera(std::uint32_t i) const noexcept { return camera_ids == nullptr ? 0 : camera_ids[i]; }

  std::size_t longer_side(Iterator begin, Iterator end) const noexcept;
  void divide(Iterator begin, Iterator end, std::size_t cells) noexcept;
  void divide_by_camera(Iterator begin, Iterator end, std::size_t cells) noexcept;

  std::size_t max_matches;
  std::vector<std::uint32_t> groups;
  std::vector<std::uint32_t> members;  // matches to spread; those of a cell are side by side
  std::uint32_t count = 0;
  const double* uv = nullptr;  // these three: the arguments of assign()
  std::size_t stride = 0;
  const std::uint8_t* camera_ids = nullptr;
};

// The axis along which the members extend further.
std::size_t ImageCells::State::longer_side(Iterator begin, Iterator end) const noexcept {
  const auto extent = [&](std::size_t axis) {
    const auto less = [=](std::uint32_t a, std::uint32_t b) { return at(a, axis) < at(b, axis); };
    const auto sides = std::minmax_element(begin, end, less);
    return at(*sides.second, axis) - at(*sides.first, axis);
  };
  return extent(1) > extent(0) ? 1 : 0;
}

// Ties go to the lower index, so that the parts do not depend on the order of the members.
void ImageCells::State::divide(Iterator begin, Iterator end, std::size_t cells) noexcept {
  const auto size = static_cast<std::size_t>(end - begin);
  cells = std::min(cells, size);
  if (cells <= 1) {
    for (auto i = begin; i != end; ++i) groups[*i] = count;
    if (begin != end) ++count;
    return;
  }
  const std::size_t axis = longer_side(begin, end);
  const std::size_t lower_cells = cells / 2;
  const auto middle = begin + static_cast<std::ptrdiff_t>((2 * size * lower_cells + cells) / (2 * cells));
  std::nth_element(begin, middle, end, [=](std::uint32_t a, std::uint32_t b) {
    return at(a, axis) < at(b, axis) || (at(a, axis) == at(b, axis) && a < b);
  });
  divide(begin, middle, lower_cells);
  divide(middle, end, cells - lower_cells);
}

// Cameras in turn, each with cells in proportion to its matches, at least one.
void ImageCells::State::divide_by_camera(Iterator begin, Iterator end, std::size_t cells) noexcept {
  while (begin != end) {
    const auto by_camera = [=](std::uint32_t a, std::uint32_t b) { return camera(a) < camera(b); };
    const unsigned first = camera(*std::min_element(begin, end, by_camera));
    const auto middle = std::partition(begin, end, [=](std::uint32_t i) { return camera(i) == first; });
    const auto own = static_cast<std::size_t>(middle - begin), all = static_cast<std::size_t>(end - begin);
    const std::size_t share = std::max<std::size_t>((2 * cells * own + all) / (2 * all), 1);
    divide(begin, middle, share);
    cells -= std::min(cells, share);
    begin = middle;
  }
}

ImageCells::ImageCells(std::size_t capacity) : state_(new State(capacity)) {}
void ImageCells::Destroy::operator()(State* state) const noexcept { delete state; }

bool ImageCells::assign(const double* uv, std::size_t stride, std::size_t n, std::size_t cells,
                        const unsigned char* is_spread, const std::uint8_t* camera_ids) noexcept {
  State& s = *state_;
  if (n > s.max_matches) return false;
  s.uv = uv;
  s.stride = stride;
  s.camera_ids = camera_ids;
  s.groups.assign(n, 0);
  s.members.clear();
  s.count = 0;
  for (std::uint32_t i = 0; i < n; ++i) {
    const bool has_place = std::isfinite(s.at(i, 0)) && std::isfinite(s.at(i, 1));
    if (has_place && (is_spread == nullptr || is_spread[i] != 0)) {
      s.members.push_back(i);
    } else {
      s.groups[i] = s.count++;
    }
  }
  s.divide_by_camera(s.members.begin(), s.members.end(), std::min(cells, n));
  return true;
}

const std::uint32_t* ImageCells::groups() const noexcept { return state_->groups.data(); }
std::size_t ImageCells::count() const noexcept { return state_->count; }

void ImageCells::limit(Options& options) const noexcept {
  options.groups.ids = groups();
  options.groups.count = count();
  options.groups.maximum = 1;
}

}  // namespace maxlogdet
