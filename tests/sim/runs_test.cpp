// SPDX-License-Identifier: MIT
#include "experiments/runs.hpp"

#include "sim/frame_reader.hpp"
#include "tests/support/support.hpp"

#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <limits>
#include <mutex>
#include <numeric>
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

std::string text_of(const std::string& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

void write(const std::string& file, const std::string& text) { std::ofstream(file, std::ios::binary) << text; }

std::vector<std::string> keys_up_to(int n) {
  std::vector<std::string> keys;
  for (int i = 0; i < n; ++i) keys.push_back("run " + std::to_string(i));
  return keys;
}

json length_of(const std::string& key) { return key.size(); }

// Each test has its folder.
class Runs : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto now = std::chrono::steady_clock::now().time_since_epoch().count();
    folder_ = std::filesystem::path(::testing::TempDir()) /
              ("maxlogdet_runs_" + std::to_string(Random().seed()) + "_" + std::to_string(now));
    std::filesystem::create_directories(folder_);
    file_ = (folder_ / "runs.jsonl").string();
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path folder_;
  std::string file_;
};

// Special cases: escapes, a line end, an empty text, nesting, all digits of a number.
const std::vector<std::pair<std::string, json>> results = {
    {"a", json::array({1.0 / 3, -0.0, 1e300})},
    {"b \"quoted\"\n", {{"key", "a"}, {"result", 5}}},
    {"c", nullptr},
    {"", {{"text", "}\n{\\"}, {"list", {json::array(), {{"x", nullptr}}}}}},
    {"e", 12},
};

TEST_F(Runs, come_back_from_the_file) {
  {
    RunLog log(file_, settings);
    for (const auto& [key, result] : results) {
      EXPECT_FALSE(log.has(key));
      log.add(key, result);
      EXPECT_TRUE(log.has(key));
      EXPECT_EQ(log.at(key), result);
    }
  }
  for (int i = 0; i < 2; ++i) {
    const RunLog log(file_, settings);
    for (const auto& [key, result] : results) {
      ASSERT_TRUE(log.has(key)) << key;
      EXPECT_EQ(log.at(key), result);
    }
    EXPECT_FALSE(log.has("d"));
  }
}

TEST_F(Runs, truncated_anywhere_keep_every_complete_line_and_no_other) {
  {
    RunLog log(file_, settings);
    for (const auto& [key, result] : results) log.add(key, result);
  }
  const std::string complete = text_of(file_);
  for (std::size_t cut = 0; cut <= complete.size(); ++cut) {
    SCOPED_TRACE(cut);
    const std::string kept = complete.substr(0, cut);
    const auto lines = static_cast<std::size_t>(std::count(kept.begin(), kept.end(), '\n'));
    write(file_, kept);
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
  write(file_, settings.dump() + "\n\n7\n{\"key\":5,\"result\":1}\n{\"key\":\"a\"}\nnot {json\n" +
                   "{\"key\":\"b\",\"result\":2}\n");
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
  EXPECT_THROW(RunLog((folder_ / "missing" / "runs.jsonl").string(), settings), sim::InputError);
  EXPECT_THROW(RunLog(folder_.string(), settings), sim::InputError);
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

TEST_F(Runs, that_are_missing_run_exactly_once) {
  const auto keys = keys_up_to(20);
  {
    RunLog log(file_, settings);
    for (const int i : {3, 4, 17}) log.add(keys[static_cast<std::size_t>(i)], "old");
  }
  for (const int threads : {1, 2}) {
    RunLog log(file_, settings);
    std::mutex mutex;
    std::multiset<std::string> called;
    const std::size_t done = run_missing("test", keys, threads, log, [&](const std::string& key) {
      const std::lock_guard<std::mutex> lock(mutex);
      called.insert(key);
      return length_of(key);
    });
    EXPECT_EQ(done, keys.size());
    EXPECT_EQ(called.size(), threads == 1 ? 17U : 0U) << "the second time all are there";
    EXPECT_EQ(called.count(keys[3]) + called.count(keys[4]) + called.count(keys[17]), 0U);
    EXPECT_EQ(log.at(keys[4]), "old");
    EXPECT_EQ(log.at(keys[12]), length_of(keys[12]));
  }
}

TEST_F(Runs, are_the_same_on_any_number_of_threads) {
  const auto keys = keys_up_to(40);
  for (const int threads : {0, 1, 2, 4}) {
    const std::string file = file_ + std::to_string(threads);
    {
      RunLog log(file, settings);
      const auto square = [](const std::string& key) { return json(std::sqrt(static_cast<double>(key.back()))); };
      EXPECT_EQ(run_missing("test", keys, threads, log, square), keys.size());
    }
    const RunLog log(file, settings);
    for (const auto& key : keys) EXPECT_EQ(log.at(key), std::sqrt(static_cast<double>(key.back())));
  }
}

TEST_F(Runs, stop_at_an_exception_and_keep_finished_ones) {
  const auto keys = keys_up_to(10);
  const auto fail_at_5 = [&](const std::string& key) {
    if (key == keys[5]) throw std::runtime_error("at " + key);
    return length_of(key);
  };
  RunLog log(file_, settings);
  try {
    run_missing("test", keys, 1, log, fail_at_5);
    FAIL() << "no exception";
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(), "at run 5");
  }
  const RunLog again(file_, settings);
  for (std::size_t i = 0; i < keys.size(); ++i) EXPECT_EQ(again.has(keys[i]), i < 5) << i;
}

TEST_F(Runs, under_way_on_other_threads_are_kept_when_one_throws) {
  const auto keys = keys_up_to(50);
  RunLog log(file_, settings);
  std::mutex mutex;
  std::set<std::string> returned;
  EXPECT_THROW(run_missing("test", keys, 4, log,
                           [&](const std::string& key) {
                             if (key == keys[7]) throw std::runtime_error("at " + key);
                             const std::lock_guard<std::mutex> lock(mutex);
                             returned.insert(key);
                             return length_of(key);
                           }),
               std::runtime_error);
  for (const auto& key : keys) EXPECT_EQ(log.has(key), returned.count(key) == 1) << key;
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
