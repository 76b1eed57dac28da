// SPDX-License-Identifier: MIT
#pragma once

#include "bench/problem.hpp"
#include "sim/draws.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace maxlogdet::bench {

/// One selection of a soak: what a tracker asks for, and what a broken one asks for.
struct SoakRequest {
  const BlockStore* store;
  Options options;
  bool is_ordinary = false;  ///< 100 of a frame of 2000 by lazy greedy, all defaults
  bool must_fail = false;    ///< the options name something that is not allowed
};

/// An endless mixture of selections, the same for the same seed: all strategies, sizes, constraints, certificates,
/// exchanges, threads and deadlines; stores with NaN, infinity, denormal, huge and zero blocks; invalid options. All
/// memory is taken when this is made: next() refills stores within their capacity.
class SoakRequests {
 public:
  static constexpr std::size_t capacity = 3000;  ///< of every store, and for every selector

  explicit SoakRequests(std::uint64_t seed);

  /// The next one; the last one's store and arrays are not valid any more.
  const SoakRequest& next();

  /// What touches all the memory there is: full stores of three rows, and every strategy with all that can follow it.
  std::vector<SoakRequest> warm_up() const;

 private:
  void refill(BlockStore& store);
  void push_garbage(BlockStore& store);
  void ask(Options& options, std::size_t n);
  void constrain(Options& options, std::size_t n);
  void spoil(Options& options);

  sim::Draws draws_;
  std::vector<BlockStore> sources_;   // blocks to copy
  std::vector<BlockStore> ordinary_;  // whole frames, never changed
  std::vector<BlockStore> stores_;    // refilled
  BlockStore full_;
  std::vector<unsigned char> required_, excluded_;
  std::vector<std::uint32_t> groups_, group_maxima_, wrong_groups_;
  SoakRequest request_{};
  std::size_t drawn_ = 0;
};

}  // namespace maxlogdet::bench
