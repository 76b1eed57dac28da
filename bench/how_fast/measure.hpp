// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <string>

// Cases of Google Benchmark that time every call by itself. A benchmark iteration is a run of many calls; the times of
// all repetitions of a case are pooled, so that the row with the highest `calls` covers them all. Repetitions of all
// cases are interleaved at random (the default here), so that a transient load slows all cases down.

namespace maxlogdet::bench {

/// Sums over calls, by counter; reported as means per call. Every case also gets `preemptions`, how often the scheduler
/// took the processor away, which causes the highest latencies of a busy machine; undisturbed_p99_us excludes such
/// calls.
using Sums = std::map<std::string, double>;

/// A case that is ready to run.
struct Work {
  std::function<void(std::size_t call)> run;                 ///< timed
  std::function<void(std::size_t call, Sums& sums)> record;  ///< not timed; may be empty
  std::function<void(std::size_t call)> prepare = {};  ///< not timed, before run; may be empty; only groups call it
};

/// Registers the case `name`, whose work is constructed again for each repetition. `calls`: the number of calls, all in
/// one repetition; 0: as many as fit into a repetition's time.
void add_case(const std::string& name, std::function<Work()> make_work, std::size_t calls = 0);

/// The order of the calls of a group's cases.
struct Turns {
  std::size_t untimed = 0;        ///< calls at the beginning of a case's turn
  std::size_t timed = 1;          ///< calls after those
  std::function<void()> disturb;  ///< before each timed call, after its prepare(); not timed; may be empty
  double seconds_per_case = 1;    ///< total wall time, averaged over the cases
};

/// Cases that take turns within one repetition, so that a transient load slows all of them down. Interleaved
/// repetitions are not enough for a ratio of two cases, which still depends on when each of them ran. The first case
/// that Google Benchmark runs measures all cases of the group that pass the filter.
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

/// Runs the registered cases, with progress on stderr: one line that is rewritten on a terminal, else a line per run.
/// `all`: no filter excludes cases, so that the number of runs is known.
void run_cases(std::size_t repetitions, bool all);

}  // namespace maxlogdet::bench
