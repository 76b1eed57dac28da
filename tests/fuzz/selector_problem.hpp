// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/base/counter_random.hpp"
#include "tests/fuzz/fuzz.hpp"
#include "tests/support/support.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <limits>
#include <vector>

// Candidates and options from bytes. Whoever changes how they are read makes another corpus of the same inputs.

namespace maxlogdet::fuzz {

constexpr std::size_t max_candidates = 600;

/// rows x 6 entries, row-major, room for three rows.
struct AnyBlock {
  double entries[max_block_rows * state_dimension] = {};
  int rows = 0;
};

/// Entries of a kind: small integers times a power of ten, any float32, any float64, or numbers of all kinds.
inline AnyBlock any_block(Bytes& bytes) {
  AnyBlock block;
  block.rows = 1 + static_cast<int>(bytes.below(max_block_rows));
  const std::size_t kind = bytes.below(4);
  for (int e = 0; e < block.rows * state_dimension; ++e) {
    switch (kind) {
      case 0: block.entries[e] = bytes.raw<std::int8_t>(); break;
      case 1: block.entries[e] = static_cast<double>(bytes.raw<float>()); break;
      case 2: block.entries[e] = bytes.raw<double>(); break;
      default: block.entries[e] = bytes.number();
    }
  }
  const double scale = kind == 0 ? bytes.times_power_of_ten(1) : 1;
  for (double& entry : block.entries) entry *= scale;
  return block;
}

/// What is hard for rounding: the block that the store holds for an earlier candidate, a multiple, or one bit changed.
inline AnyBlock changed_copy(Bytes& bytes, const BlockStore& store) {
  AnyBlock block;
  block.rows = std::max(store.rows(), 1);
  store.block(bytes.below(store.size()), block.entries);
  double& entry = block.entries[bytes.below(static_cast<std::size_t>(state_dimension * block.rows))];
  switch (bytes.below(4)) {
    case 0: break;
    case 1: {
      const double factor = bytes.times_power_of_ten(bytes.raw<std::int8_t>());
      for (double& each : block.entries) each *= factor;
      break;
    }
    case 2: {
      const auto bits = Eigen::numext::bit_cast<std::uint32_t>(static_cast<float>(entry)) ^ (1U << bytes.below(32));
      entry = static_cast<double>(Eigen::numext::bit_cast<float>(bits));
      break;
    }
    default: entry = static_cast<double>(std::nextafter(static_cast<float>(entry), bytes.chance(128) ? 1e38F : -1e38F));
  }
  return block;
}

/// Many candidates from five bytes: random entries of one scale, or small deviations from one direction.
inline void append_random(Bytes& bytes, BlockStore& store) {
  const std::size_t max_count = std::min<std::size_t>(max_candidates - store.size(), bytes.chance(6) ? 500 : 100);
  const std::size_t count = std::min(max_count, 1 + bytes.below(256));
  CounterRandom random(bytes.byte());
  AnyBlock block;
  block.rows = 1 + static_cast<int>(bytes.below(max_block_rows));
  const double scale = bytes.times_power_of_ten(1);
  const double spread = std::pow(10.0, -static_cast<double>(bytes.below(12)));
  const auto uniform = [&] { return static_cast<double>(random.bits() >> 11) * 0x1p-52 - 1; };
  double direction[max_block_rows * state_dimension];
  for (double& entry : direction) entry = uniform();
  for (std::size_t i = 0; i < count; ++i) {
    for (int e = 0; e < block.rows * state_dimension; ++e) {
      block.entries[e] = scale * ((1 - spread) * direction[e] + spread * uniform());
    }
    store.push_back(block.entries, block.rows);
  }
}

/// What a store refuses.
inline void append_invalid(Bytes& bytes, BlockStore& store) {
  AnyBlock block;
  switch (bytes.below(4)) {
    case 0: store.push_back_invalid(); break;
    case 1: store.push_back(nullptr, static_cast<int>(bytes.below(5))); break;
    case 2:
      store.push_back(block.entries, bytes.raw<std::int8_t>() % 2 == 0 ? bytes.raw<std::int32_t>() & ~3 : -1);
      break;
    default:
      block.entries[bytes.below(state_dimension)] = std::numeric_limits<double>::quiet_NaN();
      store.push_back(block.entries, 1);
  }
}

inline void append_candidates(Bytes& bytes, BlockStore& store) {
  while (store.size() < max_candidates && !bytes.is_empty()) {
    const std::size_t kind = bytes.below(10);
    if (kind == 0) return;
    if (kind == 1) {
      append_random(bytes, store);
    } else if (kind == 2) {
      append_invalid(bytes, store);
    } else {
      const AnyBlock block = kind <= 5 && store.size() > 0 ? changed_copy(bytes, store) : any_block(bytes);
      store.push_back(block.entries, block.rows);
    }
  }
}

/// Options for these candidates, and the arrays that they point to.
class Request {
 public:
  Request(Bytes& bytes, const BlockStore& candidates) {
    const std::size_t size = candidates.size();
    // Selecting all of many near copies would take seconds under a sanitizer.
    options.budget = bytes.below(std::min<std::size_t>(size, 250) + 2);
    if (size > 250) options.budget = std::min<std::size_t>(options.budget, 40);
    if (options.budget > size) options.budget = std::numeric_limits<std::size_t>::max() / 3 + 1;  // all
    options.strategy = static_cast<Strategy>(bytes.chance(4) ? bytes.raw<std::int8_t>()
                                                             : static_cast<int>(bytes.below(std::size(strategies))));
    options.threads = bytes.chance(16) ? bytes.raw<std::int8_t>() : 1;  // more are slow where there are few cores
    options.stochastic.epsilon = bytes.chance(32) ? bytes.number() : (1 + static_cast<double>(bytes.byte())) / 257;
    options.stochastic.seed = bytes.byte();
    options.certificate = bytes.chance(128);
    if (bytes.chance(32)) options.time_limit = bytes.chance(64) ? bytes.number() : 1e-6 * bytes.byte();
    decode_prior(bytes);
    decode_constraints(bytes, candidates);
    capacity = size;
    if (bytes.chance(8)) capacity = bytes.below(capacity + 1);
    if (bytes.chance(64)) options.target_efficiency = bytes.chance(16) ? bytes.number() : (1.0 + bytes.byte()) / 256;
  }
  Request(const Request&) = delete;  // the options point into it
  Request& operator=(const Request&) = delete;

  Options options;
  std::size_t capacity = 0;  ///< of the selector to be asked; now and then too small

 private:
  // None, a multiple of the identity, of a diagonal, of a random information, or of anything.
  void decode_prior(Bytes& bytes) {
    constexpr int n = state_dimension;
    const std::size_t kind = bytes.below(8);
    if (kind < 2) return;  // the default
    options.prior = prior_;
    const double scale = bytes.times_power_of_ten(1);
    double a[n][n] = {};
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) {
        a[i][j] = i == j ? 1 : 0;
        if (kind == 3) a[i][j] *= std::pow(10.0, bytes.raw<std::int8_t>() % 8);
        if (kind == 4 || kind == 5) a[i][j] = bytes.raw<std::int8_t>();
      }
    }
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) {
        double sum = i == j && kind == 4 ? 0.1 : 0;
        for (int d = 0; d < n; ++d) sum += a[i][d] * a[j][d];
        if (kind == 6) sum = i == j ? bytes.number() : 0;
        if (kind == 7) sum = bytes.number();
        prior_[n * i + j] = scale * sum;
      }
    }
    if (bytes.chance(64)) prior_[bytes.below(n * n)] *= 1 + bytes.times_power_of_ten(1);
  }

  void decode_constraints(Bytes& bytes, const BlockStore& candidates) {
    const std::size_t size = candidates.size();
    if (bytes.chance(64)) {
      required_.assign(size, 0);  // steps from one to the next need few bytes
      for (std::size_t i = bytes.below(16); i < size; i += 1 + bytes.byte()) required_[i] = 3;
      options.required = required_.data();
      if (!bytes.chance(16)) {
        for (std::size_t i = 0; i < size; ++i) required_[i] = candidates.is_valid(i) ? required_[i] : 0;
      }
    }
    if (!bytes.chance(64)) return;
    options.groups.count = bytes.below(20);
    options.groups.maximum = bytes.below(12);
    if (bytes.chance(2)) options.groups.maximum = std::numeric_limits<std::size_t>::max();
    const bool is_listed = bytes.chance(128);
    const std::size_t end = options.groups.count + (bytes.chance(4) ? 1 : 0);
    groups_.assign(size + 1, 0);  // never null
    for (std::size_t i = 0; i < size && end > 0; ++i) {
      groups_[i] = static_cast<std::uint32_t>(is_listed ? bytes.below(end) : i % end);
    }
    options.groups.ids = groups_.data();
  }

  double prior_[state_dimension * state_dimension];
  std::vector<unsigned char> required_;
  std::vector<std::uint32_t> groups_;
};

}  // namespace maxlogdet::fuzz
