// SPDX-License-Identifier: MIT
#pragma once

#include "bench/problem.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

// What all tables of maxlogdet_search_tables share: how they measure, over which frames, and their form.

namespace maxlogdet::bench {

struct Measured {
  double microseconds = std::numeric_limits<double>::infinity();  ///< of the fastest call
  double log_det = 0;                                             ///< nats
  double gap = 0;                                                 ///< upper bound less log det, nats
};

/// Selects with each of the `cases` by turns, so that what slows the machine down for a while slows all of them down.
std::vector<Measured> measure(const BlockStore& store, const std::vector<Options>& cases);

Options options_of(Strategy strategy, std::size_t budget);

constexpr Blocks block_kinds[] = {Blocks::two_rows, Blocks::two_rows_measurement, Blocks::three_rows,
                                  Blocks::three_rows_measurement};

/// Synthetic frames: of each family, size and seed, with each kind of block.
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

/// Calls body(problem) for each of them; only one is in memory at a time.
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

/// Writes the line "table NAME" and the header to stdout, and to stderr what is measured now.
void begin_table(const char* name, const std::vector<const char*>& columns);

}  // namespace maxlogdet::bench
