// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/feature_match.hpp>
#include <maxlogdet/options.hpp>

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
  explicit ImageCells(std::size_t capacity);

  /// Divides `size` matches, at most the capacity, into at most `cells` cells, at least 1, and sets Options::groups to
  /// at most one of each. is_spread[i] == 0: match i is a group of its own. Groups are valid until the next call.
  void limit(const FeatureMatch* matches, std::size_t size, const unsigned char* is_spread, std::size_t cells,
             Options& options) noexcept;

 private:
  using Iterator = std::vector<std::uint32_t>::iterator;

  std::size_t longer_side(Iterator begin, Iterator end) const noexcept;
  void divide(Iterator begin, Iterator end, std::size_t cells) noexcept;
  void divide_by_camera(Iterator begin, Iterator end, std::size_t cells) noexcept;

  std::vector<std::uint32_t> groups_;
  std::vector<std::uint32_t> members_;  // matches to spread; those of a cell are side by side
  std::uint32_t count_ = 0;
  const FeatureMatch* matches_ = nullptr;
};

}  // namespace maxlogdet
