// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <string>

// Each repetition of Google Benchmark is a block: some milliseconds of one case. The blocks of all cases are
// interleaved at random, so that a transient load disturbs all cases alike. The time of a block is that of its fastest
// call, and results.py takes the median over the blocks.

namespace maxlogdet::bench {

/// Sums over calls, by counter; reported as means per call.
using Sums = std::map<std::string, double>;

/// A case that is ready to run.
struct Work {
  std::function<void(std::size_t call)> run;                      ///< timed
  std::function<void(std::size_t call, Sums& sums)> record = {};  ///< not timed; may be empty
  std::function<void(std::size_t call)> prepare = {};             ///< not timed, before run; may be empty
  std::size_t inputs = 1;  ///< calls cycle through so many; the time of a block is the mean of their minima
};

/// Hot: calls follow each other. Cold: before each, other work evicts the caches and retrains the branch predictors.
enum class Caches { hot, cold };
constexpr const char* to_string(Caches caches) { return caches == Caches::hot ? "hot" : "cold"; }

/// Registers the case KIND/METHOD/KEY:VALUE/..., whose work is constructed again for each block. `blocks`: how many; 0:
/// as many as --benchmark_repetitions says.
void add_case(const std::string& name, const std::function<Work()>& make_work, Caches caches = Caches::hot,
              int blocks = 0);

/// grid/: select() and Eigen's selections over n, k, epsilon and instruction sets. threads/, choose/: select()
/// on several threads.
void add_selection_cases();
/// tracker/: the cost per frame of a tracker. baseline/: a selection with Eigen, to see whether the machine is steady.
void add_tracker_cases();

}  // namespace maxlogdet::bench
