// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/runs.hpp"

#include "bench/world/frame_reader.hpp"
#include "tests/support/text_folder.hpp"

#include <atomic>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <limits>
#include <mutex>
#include <set>
#include <sstream>
#include <stdexcept>
#include <thread>

namespace maxlogdet::test {
namespace {

using nlohmann::json;
using sim::RunLog;
using sim::StopOnInterrupt;

const nlohmann::ordered_json settings = {{"experiment", "test"}, {"seed", 7}, {"sizes", {3, 1, 2}}};

std::vector<std::string> keys_up_to(int n) {
  std::vector<std::string> keys;
  for (int i = 0; i < n; ++i) keys.push_back("run " + std::to_string(i));
  return keys;
}

json length_of(const std::string& key) { return key.size(); }

class Runs : public TextFolder {
 protected:
  std::string file_ = path("runs.jsonl");
};

// Special cases: escapes, a line end, an empty text, nesting, all digits of a number.
const std::vector<std::pair<std::string, json>> results = {
    {"a", json::array({1.0 / 3, -0.0, 1e300})},
    {"b \"quoted\"\n", {{"key", "a"}, {"result", 5}}},
    {"c", nullptr},
    {"", {{"text", "}\n{\\"}, {"list", {json::array(), {{"x", nullptr}}}}}},
    {"e", 12},
};

TEST_F(Runs, truncated_anywhere_keep_every_complete_line_and_no_other) {
  {
    RunLog log(file_, settings);
    for (const auto& [key, result] : results) {
      EXPECT_FALSE(log.has(key));
      log.add(key, result);
      EXPECT_TRUE(log.has(key));
      EXPECT_EQ(log.at(key), result);
    }
  }
  const std::string complete = text_of(file_);
  for (std::size_t cut = 0; cut <= complete.size(); ++cut) {
    SCOPED_TRACE(cut);
    const std::string kept = complete.substr(0, cut);
    const auto lines = static_cast<std::size_t>(std::count(kept.begin(), kept.end(), '\n'));
    std::ofstream(file_, std::ios::binary) << kept;
    {
      RunLog log(file_, settings);
      for (std::size_t i = 0; i < results.size(); ++i) {
        ASSERT_EQ(log.has(results[i].first), i + 1 < lines);
        if (i + 1 < lines) {
          ASSERT_EQ(log.at(results[i].first), results[i].second);
        }
      }
      log.add("next", cut);
    }
    const RunLog log(file_, settings);
    ASSERT_TRUE(log.has("next"));
    EXPECT_EQ(log.at("next"), cut);
    for (std::size_t i = 0; i < results.size(); ++i) ASSERT_EQ(log.has(results[i].first), i + 1 < lines);
  }
}

TEST_F(Runs, skip_other_lines) {
  write("runs.jsonl", {settings.dump(), "", "7", R"({"key":5,"result":1})", R"({"key":"a"})", "not {json",
                       R"({"key":"b","result":2})"});
  const RunLog log(file_, settings);
  EXPECT_FALSE(log.has("a"));
  ASSERT_TRUE(log.has("b"));
  EXPECT_EQ(log.at("b"), 2);
}

TEST_F(Runs, of_other_settings_are_refused_and_kept) {
  RunLog(file_, settings).add("a", 1);
  const std::string before = text_of(file_);
  nlohmann::ordered_json others = settings;
  others["seed"] = 8;
  try {
    const RunLog log(file_, others);
    FAIL() << "opened";
  } catch (const sim::InputError& error) {
    EXPECT_EQ(std::string(error.what()).rfind(file_ + ":1:", 0), 0U) << error.what();
  }
  EXPECT_EQ(text_of(file_), before);
}

TEST_F(Runs, need_a_folder_that_can_be_written_to) {
  EXPECT_THROW(RunLog(path("missing/runs.jsonl"), settings), sim::InputError);
  EXPECT_THROW(RunLog(folder_, settings), sim::InputError);
  RunLog log(file_, settings);
  std::filesystem::remove_all(folder_);
  EXPECT_THROW(log.add("a", 1), sim::InputError);
  EXPECT_FALSE(log.has("a"));
}

TEST_F(Runs, hold_null_for_nan) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  {
    RunLog log(file_, settings);
    log.add("a", {nan, 1.5});
    EXPECT_TRUE(std::isnan(sim::number_of(log.at("a").at(0))));
  }
  const RunLog log(file_, settings);
  EXPECT_TRUE(log.at("a").at(0).is_null());
  EXPECT_TRUE(std::isnan(sim::number_of(log.at("a").at(0))));
  EXPECT_EQ(sim::number_of(log.at("a").at(1)), 1.5);
}

TEST_F(Runs, that_are_missing_run_exactly_once_on_any_number_of_threads) {
  const auto keys = keys_up_to(40);
  for (const int threads : {0, 1, 2, 4}) {
    const std::string file = file_ + std::to_string(threads);
    {
      RunLog log(file, settings);
      for (const int i : {3, 4, 17}) log.add(keys[static_cast<std::size_t>(i)], "old");
    }
    RunLog log(file, settings);
    std::mutex mutex;
    std::multiset<std::string> called;
    const auto square_root = [&](const std::string& key) -> json {
      const std::lock_guard<std::mutex> lock(mutex);
      called.insert(key);
      return std::sqrt(static_cast<double>(key.back()));
    };
    EXPECT_EQ(run_missing("test", keys, threads, log, square_root), keys.size());
    EXPECT_EQ(run_missing("test", keys, threads, log, square_root), keys.size());
    const RunLog read(file, settings);
    for (std::size_t i = 0; i < keys.size(); ++i) {
      const bool is_old = i == 3 || i == 4 || i == 17;
      EXPECT_EQ(called.count(keys[i]), is_old ? 0U : 1U) << "the second time all are there";
      EXPECT_EQ(read.at(keys[i]), is_old ? json("old") : json(std::sqrt(static_cast<double>(keys[i].back()))));
    }
  }
}

TEST_F(Runs, that_returned_before_an_exception_are_kept) {
  const auto keys = keys_up_to(50);
  for (const int threads : {1, 4}) {
    const std::string file = file_ + std::to_string(threads);
    RunLog log(file, settings);
    std::mutex mutex;
    std::set<std::string> returned;
    const auto fail_at_7 = [&](const std::string& key) {
      if (key == keys[7]) throw std::runtime_error("at " + key);
      const std::lock_guard<std::mutex> lock(mutex);
      returned.insert(key);
      return length_of(key);
    };
    try {
      run_missing("test", keys, threads, log, fail_at_7);
      FAIL() << "no exception";
    } catch (const std::runtime_error& error) {
      EXPECT_STREQ(error.what(), "at run 7");
    }
    const RunLog read(file, settings);
    for (const auto& key : keys) EXPECT_EQ(read.has(key), returned.count(key) == 1) << key;
    if (threads == 1) {
      EXPECT_EQ(returned, std::set<std::string>(keys.begin(), keys.begin() + 7));
    }
  }
}

TEST_F(Runs, that_give_null_are_not_logged) {
  const auto keys = keys_up_to(4);
  RunLog log(file_, settings);
  const std::size_t done = run_missing(
      "test", keys, 1, log, [&](const std::string& key) { return key == keys[1] ? json() : length_of(key); });
  EXPECT_EQ(done, 3U);
  EXPECT_FALSE(log.has(keys[1]));
  EXPECT_TRUE(log.has(keys[2]));
}

TEST_F(Runs, under_way_finish_after_an_interrupt_and_no_other_starts) {
  const auto keys = keys_up_to(100);
  for (const int threads : {1, 2}) {
    RunLog log(file_ + std::to_string(threads), settings);
    const StopOnInterrupt guard;
    std::atomic<int> started{0};
    const std::size_t done = run_missing("test", keys, threads, log, [&](const std::string& key) {
      const int before = started.fetch_add(1);
      if (before == 2) std::raise(SIGINT);
      // A run of the other worker lasts until then.
      while (before > 2 && !StopOnInterrupt::is_asked_for()) std::this_thread::yield();
      return length_of(key);
    });
    EXPECT_TRUE(StopOnInterrupt::is_asked_for());
    EXPECT_EQ(done, static_cast<std::size_t>(started.load())) << "all that started were logged";
    if (threads == 1) {
      EXPECT_EQ(done, 3U);
    }
    EXPECT_LT(done, keys.size());
  }
  EXPECT_FALSE(StopOnInterrupt::is_asked_for()) << "a request ends with its guard";
  RunLog log(file_ + "1", settings);
  EXPECT_EQ(run_missing("test", keys, 1, log, length_of), keys.size());
}

TEST(StopOnInterrupt, leaves_the_second_interrupt_to_the_system) {
  const StopOnInterrupt guard;
  std::raise(SIGINT);
  EXPECT_TRUE(StopOnInterrupt::is_asked_for());
  EXPECT_EQ(std::signal(SIGINT, SIG_IGN), SIG_DFL) << "the default terminates the program";
}

void handler_of_the_caller(int) {}

TEST(StopOnInterrupt, restores_the_signal_handler) {
  const auto before = std::signal(SIGINT, handler_of_the_caller);
  { const StopOnInterrupt guard; }
  EXPECT_EQ(std::signal(SIGINT, before), handler_of_the_caller);
}

}  // namespace
}  // namespace maxlogdet::test
