// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <string>

// Cases of Google Benchmark that time every call by itself. A benchmark iteration is a run of many calls; the times of
// all repetitions of a case are pooled, so that the row with the highest `calls` holds them all. Repetitions of all
// cases are interleaved at random (the default here): what slows the machine down for a while slows all cases down.

namespace maxlogdet::bench {

/// Sums over calls, by counter; reported as means a call. `preemptions` is added to what a case records: how often
/// another process took the processor away, which is what the highest latencies of a busy machine are;
/// undisturbed_p99_us leaves such calls out.
using Sums = std::map<std::string, double>;

/// A case made ready to run.
struct Work {
  std::function<void(std::size_t call)> run;                 ///< timed
  std::function<void(std::size_t call, Sums& sums)> record;  ///< not timed; may be empty
  std::function<void(std::size_t call)> prepare = {};  ///< not timed, before run; may be empty; groups alone do it
};

/// Registers the case `name`, whose work is made anew for each repetition. `calls`: exactly so many, in one repetition;
/// 0: as many as fit into a repetition's time.
void add_case(const std::string& name, std::function<Work()> make_work, std::size_t calls = 0);

/// How the calls of a group's cases follow each other.
struct Turns {
  std::size_t untimed = 0;        ///< calls of a case at the beginning of its turn
  std::size_t timed = 1;          ///< and then so many that count
  std::function<void()> disturb;  ///< before each that counts, after what prepares it, not timed; may be empty
  double seconds_per_case = 1;    ///< wall time, all of it, on average over the cases
};

/// Cases that are measured by turns, in one repetition: each has its turn in every round, so that all meet the same
/// machine, whatever it does meanwhile. Where repetitions are interleaved, a ratio of two cases still depends on when
/// each had its own. The first case of a group that is asked for measures all that pass the filter.
class Group {
 public:
  Group(const std::string& name, const Turns& turns);
  /// Registers the case `name`, as add_case does.
  void add(const std::string& name, std::function<Work()> make_work);

  struct State;

 private:
  std::shared_ptr<State> state_;
};

/// Wall time of one repetition, s.
void set_seconds_per_repetition(double seconds);

/// Runs what was registered, in so many repetitions, with progress on stderr: one line rewritten on a terminal, else a
/// line a run. `all`: no filter leaves cases out, so that it is known how many runs there will be.
void run_cases(std::size_t repetitions, bool all);

}  // namespace maxlogdet::bench
