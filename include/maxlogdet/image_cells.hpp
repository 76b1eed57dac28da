// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/options.hpp>

#include <cstddef>
#include <cstdint>
#include <memory>

namespace maxlogdet {

/// Cells of the image that hold equally many matches each, as groups of a selection that takes one match of a cell at
/// most. Where neighbouring matches share errors, the most informative ones are often neighbours, and share the largest
/// errors; spread over about 1.5 times as many cells as matches are selected they do not (docs/odometry.md). Where
/// errors are independent this costs some tenth of the accuracy: `maxlogdet evaluate` tells which it is.
///
/// The cells are those of a k-d tree (Bentley 1975): the matches of a cell are divided along the longer side of their
/// bounding box, in proportion to the cells that either part becomes, until there are as many cells as asked for. Where
/// matches are dense, cells are small. GoodFeatures makes them itself (GoodFeatures::spread). What was moved from may
/// only be assigned to or destroyed.
class ImageCells {
 public:
  /// Reserves memory for `capacity` matches, at most 2^32 - 1. Throws std::bad_alloc, also above that.
  explicit ImageCells(std::size_t capacity);

  /// Divides n matches, with (u, v) at uv[stride * i], into at most `cells` cells, at least 1; returns false, without
  /// effect, if n is above the capacity. `is_spread`: n; a match with 0, or whose (u, v) is not finite, is a group of
  /// its own. `camera_ids`: n; no cell has matches of two cameras. Null pointers: all are spread; one camera.
  bool assign(const double* uv, std::size_t stride, std::size_t n, std::size_t cells,
              const unsigned char* is_spread = nullptr, const std::uint8_t* camera_ids = nullptr) noexcept;

  /// The group of each match; valid until the next assign().
  const std::uint32_t* groups() const noexcept;
  /// The number of groups: cells, and matches that are groups of their own.
  std::size_t count() const noexcept;

  /// Sets Options::groups to at most one match of a group.
  void limit(Options& options) const noexcept;

 private:
  struct State;
  struct Destroy {
    void operator()(State* state) const noexcept;
  };
  std::unique_ptr<State, Destroy> state_;
};

}  // namespace maxlogdet
