// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/draws.hpp"
#include "bench/world/problem.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace maxlogdet::bench {

/// One selection of a soak, as a tracker or as a faulty tracker asks for it.
struct SoakRequest {
  const BlockStore* store;
  Options options;
  bool is_ordinary = false;  ///< 100 of 2000 candidates of a frame by lazy greedy, all defaults
  bool must_fail = false;    ///< the options are invalid
};

/// An endless mixture of selections that the seed determines: all strategies, sizes, constraints, certificates,
/// threads and deadlines; stores with NaN, infinite, denormal, huge and zero blocks; invalid options. The
/// constructor allocates all memory: next() refills stores within their capacity.
class SoakRequests {
 public:
  static constexpr std::size_t capacity = 3000;  ///< of every store, and for every selector

  explicit SoakRequests(std::uint64_t seed);

  /// Returns the next request, and invalidates the store and the arrays of the last one.
  const SoakRequest& next();

  /// Requests that touch all memory of a selector: full stores of three rows, every strategy, and all that can follow.
  std::vector<SoakRequest> warm_up() const;

 private:
  void refill(BlockStore& store);
  void push_extreme(BlockStore& store);
  void ask(Options& options, std::size_t n);
  void constrain(Options& options, std::size_t n);
  void spoil(Options& options);

  sim::Draws draws_;
  std::vector<BlockStore> sources_;   // their blocks are copied
  std::vector<BlockStore> ordinary_;  // whole frames, which never change
  std::vector<BlockStore> stores_;    // refilled
  BlockStore full_;
  std::vector<unsigned char> required_;
  std::vector<std::uint32_t> groups_, wrong_groups_;
  SoakRequest request_{};
  std::size_t drawn_ = 0;
};

}  // namespace maxlogdet::bench
