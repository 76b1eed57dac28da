// SPDX-License-Identifier: MIT
#pragma once

#include "tests/fuzz/require.hpp"
#include "tests/support/numbers.hpp"

#include <maxlogdet/selection.hpp>

#include <cstdint>
#include <vector>

namespace maxlogdet::fuzz {

using test::same_value;

/// A selection that outlives its selector's next one, without what may differ between machines.
struct Answer {
  Answer() = default;
  explicit Answer(const Selection& selection)
      : status(selection.status),
        error(selection.error),
        indices(selection.begin(), selection.end()),
        searched(selection.searched),
        gains(selection.gains, selection.gains + selection.size),
        log_det(selection.log_det),
        upper_bound(selection.upper_bound),
        efficiency(selection.efficiency),
        translation_sigma(selection.translation_sigma),
        rotation_sigma(selection.rotation_sigma) {}

  Status status = Status::ok;
  Error error = Error::none;
  std::vector<std::uint32_t> indices;
  std::size_t searched = 0;
  std::vector<double> gains;
  double log_det = 0;
  double upper_bound = 0;
  double efficiency = 0, translation_sigma = 0, rotation_sigma = 0;
};

/// Fails unless both are the same to the last bit.
inline void require_same(const Answer& a, const Answer& b, const char* property, const char* details = "") {
  require(a.status == b.status, property, details, to_string(a.status), to_string(b.status));
  require(a.error == b.error, property, details, to_string(a.error), to_string(b.error));
  require(a.indices.size() == b.indices.size(), property, details, "sizes", a.indices.size(), b.indices.size());
  for (std::size_t j = 0; j < a.indices.size(); ++j) {
    require(a.indices[j] == b.indices[j], property, details, "index", a.indices[j], b.indices[j], "in place", j);
    require(same_value(a.gains[j], b.gains[j]), property, details, "gain", a.gains[j], b.gains[j], "in place", j);
  }
  require(same_value(a.log_det, b.log_det), property, details, "log det", a.log_det, b.log_det);
  require(same_value(a.upper_bound, b.upper_bound), property, details, "bound", a.upper_bound, b.upper_bound);
  require(same_value(a.efficiency, b.efficiency) && same_value(a.translation_sigma, b.translation_sigma) &&
              same_value(a.rotation_sigma, b.rotation_sigma),
          property, details, "what was reached");
}

}  // namespace maxlogdet::fuzz
