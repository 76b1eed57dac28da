// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/runs.hpp"

#include "bench/world/executor.hpp"
#include "bench/world/input_error.hpp"
#include "bench/world/output_file.hpp"
#include "bench/world/progress.hpp"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <exception>
#include <filesystem>
#include <fstream>
#include <limits>
#include <utility>

namespace maxlogdet::sim {
namespace {

// Read by all workers; a signal handler may only write atomics without locks.
std::atomic<int> stop_asked_for{0};
static_assert(std::atomic<int>::is_always_lock_free, "for the signal handler");

void ask_to_stop(int signal) {
  constexpr char message[] = "\nfinishing the runs under way; Ctrl-C again terminates at once\n";
  const ssize_t written = write(STDERR_FILENO, message, sizeof message - 1);
  static_cast<void>(written);
  stop_asked_for = 1;
  std::signal(signal, SIG_DFL);  // for the next one
}

// Shared by the workers of one call of run_missing().
struct Work {
  const std::vector<std::string>& keys;
  const std::function<nlohmann::json(const std::string&)>& run;
  RunLog& log;
  Progress progress;
  std::size_t already_done;
  std::size_t all;
  std::atomic<std::size_t> next{0};
  std::atomic<std::size_t> done{0};
  std::mutex mutex;
  std::exception_ptr error;

  bool is_over() const { return StopOnInterrupt::is_asked_for() || next.load() >= keys.size(); }

  void take_one() noexcept {
    try {
      const std::size_t i = next.fetch_add(1);
      if (i >= keys.size()) return;
      nlohmann::json result = run(keys[i]);
      if (result.is_null()) return;
      log.add(keys[i], std::move(result));
      done.fetch_add(1);
    } catch (...) {
      const std::lock_guard<std::mutex> lock(mutex);
      error = std::current_exception();
      next.store(keys.size());
    }
  }

  static void body(void* context, int worker) {
    auto& work = *static_cast<Work*>(context);
    while (!work.is_over()) {
      work.take_one();
      if (worker == 0) work.progress.update(work.already_done + work.done.load(), work.all);
    }
  }
};

// Describes how the settings differ from those in the first line of a file.
std::string difference(const std::string& line, const nlohmann::ordered_json& settings) {
  const nlohmann::json there = nlohmann::json::parse(line, nullptr, false);
  if (!there.is_object()) return "not written by this program";
  std::string text;
  for (const auto& [name, value] : settings.items()) {
    const bool is_there = there.contains(name);
    if (is_there && there[name] == nlohmann::json(value)) continue;
    text += (text.empty() ? "" : ", ") + name + " " + (is_there ? there[name].dump() : "missing") + " instead of " +
            value.dump();
  }
  return text.empty() ? "more of them" : text;
}

}  // namespace

RunLog::RunLog(std::string file, const nlohmann::ordered_json& settings) : file_(std::move(file)) {
  std::ifstream old(file_);
  if (!old && std::filesystem::exists(file_)) throw InputError(file_ + ": cannot be read; expected finished runs");
  std::string line;
  std::string kept = settings.dump() + '\n';
  if (std::getline(old, line) && !old.eof()) {  // a line without its end is incomplete
    if (line + '\n' != kept) {
      throw InputError(file_ + ":1: holds runs of other settings (" + difference(line, settings) +
                       "): choose another --output, or delete the file");
    }
    while (std::getline(old, line) && !old.eof()) {
      const nlohmann::json run = nlohmann::json::parse(line, nullptr, false);
      if (!run.is_object() || !run.contains("key") || !run["key"].is_string() || !run.contains("result")) continue;
      runs_[run["key"].get<std::string>()] = run["result"];
      kept += line + '\n';
    }
  }
  old.close();
  write_file(file_, kept);
}

void RunLog::add(const std::string& key, nlohmann::json result) {
  const nlohmann::ordered_json line = {{"key", key}, {"result", result}};
  const std::string text = line.dump() + '\n';
  const std::lock_guard<std::mutex> lock(mutex_);
  errno = 0;
  std::ofstream file(file_, std::ios::app);
  file << text << std::flush;
  if (!file) fail_to_write(file_);
  runs_[key] = std::move(result);
}

StopOnInterrupt::StopOnInterrupt() {
  stop_asked_for = 0;
  previous_ = std::signal(SIGINT, ask_to_stop);
}

StopOnInterrupt::~StopOnInterrupt() {
  std::signal(SIGINT, previous_);
  stop_asked_for = 0;
}

bool StopOnInterrupt::is_asked_for() noexcept { return stop_asked_for != 0; }

std::size_t run_missing(const std::string& what, const std::vector<std::string>& keys, int threads, RunLog& log,
                        const std::function<nlohmann::json(const std::string& key)>& work) {
  std::vector<std::string> missing;
  for (const std::string& key : keys) {
    if (!log.has(key)) missing.push_back(key);
  }
  Work shared{missing, work, log, Progress(what, "run"), keys.size() - missing.size(), keys.size(), {}, {}, {}, {}};
  shared.progress.update(shared.already_done, shared.all);
  Executor* const helpers = executor();
  const int max_workers = helpers == nullptr ? 1 : helpers->concurrency();
  const int workers = threads == 0 ? max_workers : std::min(threads, max_workers);
  if (workers > 1) {
    helpers->run(workers, &Work::body, &shared);
  } else {
    Work::body(&shared, 0);
  }
  if (shared.error) std::rethrow_exception(shared.error);
  return shared.already_done + shared.done.load();
}

double number_of(const nlohmann::json& value) {
  return value.is_null() ? std::numeric_limits<double>::quiet_NaN() : value.get<double>();
}

}  // namespace maxlogdet::sim
