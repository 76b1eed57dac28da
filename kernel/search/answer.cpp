// SPDX-License-Identifier: MIT
#include "kernel/search/answer.hpp"

#include <cmath>

namespace maxlogdet {

void Answer::add(const simd::Kernel& kernel, Candidate candidate, const double (*rows)[state_dimension],
                 int count) noexcept {
  memory_.candidates[size_] = candidate;
  memory_.gains[size_] = std::log1p(factor_.add_block(kernel, rows, count));
  ++size_;
}

}  // namespace maxlogdet
