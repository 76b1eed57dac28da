// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

namespace maxlogdet::sim {

/// Finished runs of an experiment, kept in a file of JSON lines, so that a rerun goes on where the last one stopped:
/// first the settings, then one line a run, in the order in which they ended. What a killed program left of a last line
/// is dropped.
class RunLog {
 public:
  /// Opens or makes `file`. Throws InputError if it holds runs of other settings, or cannot be written.
  RunLog(std::string file, const nlohmann::ordered_json& settings);

  bool has(const std::string& key) const { return runs_.count(key) != 0; }
  const nlohmann::json& at(const std::string& key) const { return runs_.at(key); }

  /// Writes it down at once. For several threads. Throws InputError if it cannot be written.
  void add(const std::string& key, nlohmann::json result);

 private:
  std::string file_;
  std::mutex mutex_;
  std::map<std::string, nlohmann::json> runs_;
};

/// Ctrl-C: what is finished is written; says how much that is.
class Interrupted : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// While one lives, Ctrl-C only asks to stop: runs under way end, no other begins. A second Ctrl-C ends the program.
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
/// what it returns; null is a run broken off (StopOnInterrupt) and is not logged. What work() computes must depend on
/// its key alone. Shows its progress under the name of `what`. Rethrows what work() throws. Returns how many of the
/// keys the log has then.
std::size_t run_missing(const std::string& what, const std::vector<std::string>& keys, int threads, RunLog& log,
                        const std::function<nlohmann::json(const std::string& key)>& work);

/// A number of a log: JSON has no NaN and holds null in its place.
double number_of(const nlohmann::json& value);

/// Outcomes that are doubles alone as a log keeps them: a list for each, in the order of `members`.
template <class Outcome, std::size_t n>
nlohmann::json lists_of(const std::vector<Outcome>& outcomes, double Outcome::*const (&members)[n]) {
  nlohmann::json lists = nlohmann::json::array();
  for (const Outcome& outcome : outcomes) {
    lists.push_back(nlohmann::json::array());
    for (const auto member : members) lists.back().push_back(outcome.*member);
  }
  return lists;
}

/// The outcomes of such lists. Throws what the JSON library throws about others.
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
