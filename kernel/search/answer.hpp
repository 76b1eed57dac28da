// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/information/information_factor.hpp"

#include <cmath>
#include <cstddef>
#include <vector>

namespace maxlogdet {

/// What is selected, in order of selection, and the information of the prior and all of it.
class Answer {
 public:
  explicit Answer(std::size_t capacity) : candidates_(capacity), gains_(capacity) {}

  /// Starts from a prior.
  void reset(const InformationFactor& prior) noexcept {
    factor_ = prior_ = prior;
    size_ = 0;
  }

  /// Adds a candidate, by `count` rows.
  void add(const simd::Kernel& kernel, Candidate candidate, const double (*rows)[state_dimension], int count) noexcept {
    candidates_[size_] = candidate;
    gains_[size_] = std::log1p(factor_.add_block(kernel, rows, count));
    ++size_;
  }

  std::size_t size() const noexcept { return size_; }
  Candidate operator[](std::size_t j) const noexcept { return candidates_[j]; }
  /// The increase in log det when each is added to those before it, nats.
  const double* gains() const noexcept { return gains_.data(); }
  const InformationFactor& prior() const noexcept { return prior_; }
  const InformationFactor& factor() const noexcept { return factor_; }

 private:
  std::vector<Candidate> candidates_;
  std::vector<double> gains_;
  std::size_t size_ = 0;
  InformationFactor prior_;
  InformationFactor factor_;
};

}  // namespace maxlogdet
