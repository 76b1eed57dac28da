// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/base/aligned_array.hpp"
#include "kernel/blocks/candidates.hpp"
#include "kernel/information/information_factor.hpp"

#include <cstddef>

namespace maxlogdet {

/// M0, 6 x 6 row-major.
struct Prior {
  double entries[state_dimension * state_dimension];

  /// Takes the symmetric part of a matrix, 6 x 6 row-major. Returns whether it is finite, and symmetric but for the
  /// rounding of float32.
  bool read(const double* given) noexcept;
  /// But for that rounding.
  bool is_semidefinite() const noexcept;
};

/// Memory to find a default prior among up to `capacity` candidates.
class PriorMemory {
 public:
  explicit PriorMemory(std::size_t capacity) : sizes_(padded(capacity)) {}

  /// Sets M0, and `factor` to it. `given`: as Options::prior; nullptr: the default prior, which is also added to what
  /// leaves a direction without information. Returns false if what is given is no information.
  bool start(const double* given, const Candidates& candidates, Prior& prior, InformationFactor& factor) noexcept;

 private:
  static std::size_t padded(std::size_t count) noexcept { return (count + 15) / 16 * 16; }
  double typical_size(const Candidates& candidates, int first_column) noexcept;
  void add_default(const Candidates& candidates, Prior& prior) noexcept;

  AlignedArray<float> sizes_;  // of each candidate's rows in some columns
};

}  // namespace maxlogdet
