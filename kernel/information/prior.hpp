// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/blocks/candidates.hpp"
#include "kernel/information/factor.hpp"

namespace maxlogdet {

/// M0, 6 x 6 row-major.
struct Prior {
  double entries[state_dimension * state_dimension];

  /// Takes the symmetric part of a matrix, 6 x 6 row-major. Returns whether it is finite, and symmetric but for the
  /// rounding of float32.
  bool read(const double* given) noexcept;
  /// But for that rounding.
  bool is_semidefinite() const noexcept;

  /// Sets M0, and `factor` to it. `given`: as Options::prior; nullptr: the default prior, which is also added to what
  /// leaves a direction without information. Returns false if what is given is no information. `sizes`: scratch for
  /// padded(candidates.count), aligned.
  bool start(const double* given, const Candidates& candidates, float* sizes, InformationFactor& factor) noexcept;

 private:
  void add_default(const Candidates& candidates, float* sizes) noexcept;
};

}  // namespace maxlogdet
