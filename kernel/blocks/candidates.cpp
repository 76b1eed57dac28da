// SPDX-License-Identifier: MIT
#include "kernel/blocks/candidates.hpp"

#include "kernel/blocks/block_planes.hpp"

#include <algorithm>

namespace maxlogdet {

Candidates all_of(const BlockStore& blocks, const simd::Kernel& kernel) noexcept {
  const BlockPlanes& planes = planes_of(blocks);
  const simd::Form by_rows = simd::form_of_rows(std::max(planes.rows(), 1));
  return {&kernel,
          {planes.plane(0, 0), planes.stride()},
          planes.stored(),
          planes.rows(),
          planes.is_factored() ? simd::factored : by_rows,
          planes.column_max(),
          planes.is_factored() ? planes.factored_max() : planes.column_max(),
          planes.indices()};
}

}  // namespace maxlogdet
