// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace maxlogdet::sim {

/// Finished runs of an experiment in a file of JSON lines, so that a rerun resumes where the last one stopped: first
/// the settings, then a line for each run, in the order in which they finished. An incomplete last line is dropped.
class RunLog {
 public:
  /// Opens or creates `file`. Throws InputError if it holds runs of other settings, or cannot be written.
  RunLog(std::string file, const nlohmann::ordered_json& settings);

  bool has(const std::string& key) const { return runs_.count(key) != 0; }
  const nlohmann::json& at(const std::string& key) const { return runs_.at(key); }

  /// Appends a run to the file at once. Thread-safe. Throws InputError if it cannot be written.
  void add(const std::string& key, nlohmann::json result);

 private:
  std::string file_;
  std::mutex mutex_;
  std::map<std::string, nlohmann::json> runs_;
};

/// While an object exists, Ctrl-C only requests a stop: runs under way finish, and no other starts. A second Ctrl-C
/// terminates the program.
class StopOnInterrupt {
 public:
  StopOnInterrupt();
  ~StopOnInterrupt();
  StopOnInterrupt(const StopOnInterrupt&) = delete;
  StopOnInterrupt& operator=(const StopOnInterrupt&) = delete;

  static bool is_asked_for() noexcept;

 private:
  void (*previous_)(int);
};

/// Calls work(key) for every key that the log lacks, on up to `threads` threads (0: all) of sim::executor(), and logs
/// the results; null is an interrupted run (StopOnInterrupt), which is not logged. The result of work() must depend on
/// its key alone. Shows progress under the name `what`. Rethrows what work() throws. Returns how many of the keys are
/// then in the log.
std::size_t run_missing(const std::string& what, const std::vector<std::string>& keys, int threads, RunLog& log,
                        const std::function<nlohmann::json(const std::string& key)>& work);

/// Returns a number of a log, where null stands for NaN, which JSON lacks.
double number_of(const nlohmann::json& value);

/// Returns outcomes of doubles as JSON: a list for each, in the order of `members`.
template <class Outcome, std::size_t n>
nlohmann::json lists_of(const std::vector<Outcome>& outcomes, double Outcome::*const (&members)[n]) {
  nlohmann::json lists = nlohmann::json::array();
  for (const Outcome& outcome : outcomes) {
    lists.push_back(nlohmann::json::array());
    for (const auto member : members) lists.back().push_back(outcome.*member);
  }
  return lists;
}

/// Reads outcomes from such lists. Other JSON makes the JSON library throw.
template <class Outcome, std::size_t n>
std::vector<Outcome> outcomes_of(const nlohmann::json& lists, double Outcome::*const (&members)[n]) {
  std::vector<Outcome> outcomes;
  for (const nlohmann::json& list : lists) {
    outcomes.emplace_back();
    for (std::size_t i = 0; i < n; ++i) outcomes.back().*members[i] = number_of(list.at(i));
  }
  return outcomes;
}

}  // namespace maxlogdet::sim
