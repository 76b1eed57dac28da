// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/feature_match.hpp>
#include <maxlogdet/options.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace maxlogdet {

/// Cells of the image that hold equally many matches each, as groups of a selection that takes one match of a cell at
/// most (GoodFeatures::spread). They are those of a k-d tree (Bentley 1975): the matches of a cell are divided along
/// the longer side of their bounding box, in proportion to the cells that either part becomes, until there are as many
/// cells as asked for. Where matches are dense, cells are small. No cell has matches of two cameras.
class ImageCells {
 public:
  /// Throws std::bad_alloc.
  explicit ImageCells(std::size_t capacity) {
    groups_.reserve(capacity);
    members_.reserve(capacity);
  }

  /// Divides `size` matches, at most the capacity, into at most `cells` cells, at least 1, and sets Options::groups to
  /// at most one of each. is_spread[i] == 0: match i is a group of its own. Groups are valid until the next call.
  void limit(const FeatureMatch* matches, std::size_t size, const unsigned char* is_spread, std::size_t cells,
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
    divide_by_camera(std::min(cells, size));
    options.groups.ids = groups_.data();
    options.groups.count = count_;
    options.groups.maximum = 1;
  }

 private:
  using Iterator = std::vector<std::uint32_t>::iterator;

  // Cameras in turn, each with cells in proportion to its matches, at least one.
  void divide_by_camera(std::size_t cells) noexcept {
    const auto camera = [this](std::uint32_t i) { return matches_[i].camera_id; };
    const auto end = members_.end();
    std::sort(members_.begin(), end, [&](std::uint32_t a, std::uint32_t b) { return camera(a) < camera(b); });
    for (Iterator begin = members_.begin(), middle; begin != end; begin = middle) {
      middle = std::find_if(begin, end, [&](std::uint32_t i) { return camera(i) != camera(*begin); });
      const auto own = static_cast<std::size_t>(middle - begin), all = static_cast<std::size_t>(end - begin);
      const std::size_t share = std::max<std::size_t>((2 * cells * own + all) / (2 * all), 1);
      divide(begin, middle, share);
      cells -= std::min(cells, share);
    }
  }

  // Ties go to the lower index, so that the parts do not depend on the order of the members.
  void divide(Iterator begin, Iterator end, std::size_t cells) noexcept {
    const auto size = static_cast<std::size_t>(end - begin);
    cells = std::min(cells, size);
    if (cells <= 1) {
      for (auto i = begin; i != end; ++i) groups_[*i] = count_;
      if (begin != end) ++count_;
      return;
    }
    const std::size_t axis = extent(begin, end, 1) > extent(begin, end, 0) ? 1 : 0;
    const std::size_t lower_cells = cells / 2;
    const auto middle = begin + static_cast<std::ptrdiff_t>((2 * size * lower_cells + cells) / (2 * cells));
    std::nth_element(begin, middle, end, [this, axis](std::uint32_t a, std::uint32_t b) {
      const double at_a = matches_[a].measured[axis], at_b = matches_[b].measured[axis];
      return at_a < at_b || (at_a == at_b && a < b);
    });
    divide(begin, middle, lower_cells);
    divide(middle, end, cells - lower_cells);
  }

  double extent(Iterator begin, Iterator end, std::size_t axis) const noexcept {
    const auto at = [this, axis](std::uint32_t i) { return matches_[i].measured[axis]; };
    const auto sides = std::minmax_element(begin, end, [&](std::uint32_t a, std::uint32_t b) { return at(a) < at(b); });
    return at(*sides.second) - at(*sides.first);
  }

  std::vector<std::uint32_t> groups_;
  std::vector<std::uint32_t> members_;  // matches to spread; those of a cell are side by side
  std::uint32_t count_ = 0;
  const FeatureMatch* matches_ = nullptr;
};

}  // namespace maxlogdet
