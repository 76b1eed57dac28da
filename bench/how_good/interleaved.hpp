// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/problem.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

// The measurement, the frames, and the format that all tables of maxlogdet_search_tables share.

namespace maxlogdet::bench {

/// The wall time of work(), us.
template <class Work>
double microseconds_of(const Work& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count();
}

struct Measured {
  double microseconds = std::numeric_limits<double>::infinity();  ///< time of the fastest call
  double log_det = 0;                                             ///< nats
  double gap = 0;                                                 ///< upper bound minus log det, nats
};

/// Selects with the `cases` in turn, so that a transient load slows all of them down.
std::vector<Measured> measure(const BlockStore& store, const std::vector<Options>& cases);

Options options_of(Strategy strategy, std::size_t budget);

constexpr Blocks block_kinds[] = {Blocks::two_rows, Blocks::two_rows_measurement, Blocks::three_rows,
                                  Blocks::three_rows_measurement};

/// Synthetic frames of each family, size and seed, with each kind of block.
struct Frames {
  std::vector<std::string> families;
  std::vector<std::size_t> sizes;
  std::vector<std::uint64_t> seeds = {scene_seed};
};

struct Problem {
  std::string family;
  Blocks blocks;
  std::size_t n;
  BlockStore store;
};

/// Calls body(problem) for each of the frames; only one is in memory at a time.
template <class Body>
void for_every_problem(const Frames& frames, const Body& body) {
  for (const std::string& family : frames.families) {
    for (const Blocks blocks : block_kinds) {
      for (const std::size_t n : frames.sizes) {
        for (const std::uint64_t seed : frames.seeds) {
          body(Problem{family, blocks, n, synthetic_store(family, n, blocks, seed)});
        }
      }
    }
  }
}

/// Writes the line "table NAME" and the table's header to stdout, and a line of progress to stderr.
void begin_table(const char* name, const std::vector<const char*>& columns);

}  // namespace maxlogdet::bench
