// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/information/information_factor.hpp"

#include <cstddef>
#include <vector>

namespace maxlogdet {

/// Memory of an Answer of up to `capacity` candidates.
struct AnswerMemory {
  explicit AnswerMemory(std::size_t capacity) : candidates(capacity), gains(capacity) {}
  std::vector<Candidate> candidates;
  std::vector<double> gains;
};

/// What is selected, in order of selection, and the information of the prior and all of it.
class Answer {
 public:
  explicit Answer(AnswerMemory& memory) noexcept : memory_(memory) {}

  /// Starts from a prior, as InformationFactor::reset.
  bool reset(const double* prior) noexcept {
    size_ = 0;
    const bool is_valid = prior_.reset(prior);
    factor_ = prior_;
    return is_valid;
  }

  /// Removes all candidates.
  void clear() noexcept {
    size_ = 0;
    factor_ = prior_;
  }

  /// Adds a candidate, by `count` rows.
  void add(const simd::Kernel& kernel, Candidate candidate, const double (*rows)[state_dimension], int count) noexcept;

  std::size_t size() const noexcept { return size_; }
  Candidate operator[](std::size_t j) const noexcept { return memory_.candidates[j]; }
  const Candidate* candidates() const noexcept { return memory_.candidates.data(); }
  /// The increase in log det when each is added to those before it, nats.
  const double* gains() const noexcept { return memory_.gains.data(); }
  const InformationFactor& prior() const noexcept { return prior_; }
  const InformationFactor& factor() const noexcept { return factor_; }

 private:
  AnswerMemory& memory_;
  std::size_t size_ = 0;
  InformationFactor prior_;
  InformationFactor factor_;
};

}  // namespace maxlogdet
