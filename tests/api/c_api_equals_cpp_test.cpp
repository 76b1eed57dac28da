// SPDX-License-Identifier: MIT
// The C API is the C++ one in other words: every selection is the same, bit for bit, errors included.
#include "tests/api/c_api.hpp"
#include "tests/support/request.hpp"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

namespace maxlogdet::test {
namespace {

CBlocks copied(const BlockStore& blocks) {
  CBlocks copy = c_blocks(blocks.size());
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const Block block = stored_block(blocks, i);
    const maxlogdet_error error = blocks.is_valid(i)
                                      ? maxlogdet_block_store_push_back(copy.get(), block.data(), blocks.rows())
                                      : maxlogdet_block_store_push_back_invalid(copy.get());
    EXPECT_EQ(error, MAXLOGDET_ERROR_NONE);
  }
  return copy;
}

// Candidates, and options that use every field; some are errors.
class Instance {
 public:
  explicit Instance(Random& random) {
    problem_.blocks = awkward_blocks(random, static_cast<std::size_t>(random.integer(0, 150)));
    for (int i = random.integer(0, 3); i > 0; --i) problem_.blocks.push_back_invalid();
    capacity_ = problem_.blocks.size() + static_cast<std::size_t>(random.integer(0, 30));
    draw_plain(random, problem_.plain);
    if (random.chance(0.5)) problem_.set_prior(random_prior(random));
    draw_flags(random);
    if (random.chance(0.3)) draw_groups(random);
    if (random.chance(0.3)) draw_targets(random, problem_.plain);
    options_ = problem_.options();
    spoil(random);
  }
  Instance(const Instance&) = delete;  // the options point into it
  Instance& operator=(const Instance&) = delete;

  const BlockStore& blocks() const { return problem_.blocks; }
  const Options& options() const { return options_; }
  std::size_t capacity() const { return capacity_; }

 private:
  void draw_plain(Random& random, Options& options) const {
    const int known = static_cast<int>(std::size(strategies));
    const int strategy = random.chance(0.03) ? random.integer(-1, known) : random.integer(0, known - 1);
    options.strategy = static_cast<Strategy>(strategy);
    options.budget = static_cast<std::size_t>(random.integer(0, static_cast<int>(problem_.blocks.size())));
    options.stochastic.epsilon = random.uniform(0.01, 0.9);
    options.stochastic.seed = static_cast<std::uint64_t>(random.integer(0, 1000));
    options.threads = random.integer(0, 4);
    options.certificate.compute = random.chance(0.5);
    options.certificate.passes = static_cast<std::size_t>(random.integer(0, 3));
    options.exchange.sweeps = static_cast<std::size_t>(random.integer(0, 2));
    options.time_limit = random.chance(0.2) ? 1e-9 : random.chance(0.5) ? 1000 : 0;
  }

  void draw_flags(Random& random) {
    const std::size_t n = problem_.blocks.size();
    if (random.chance(0.3)) problem_.required.resize(n);
    for (unsigned char& flag : problem_.required) flag = random.chance(0.03) ? 1 : 0;
    if (random.chance(0.3)) problem_.excluded.resize(n);
    for (unsigned char& flag : problem_.excluded) flag = random.chance(0.2) ? 3 : 0;
  }

  void draw_groups(Random& random) {
    const int count = random.integer(1, 10);
    problem_.groups.resize(problem_.blocks.size());
    for (std::uint32_t& group : problem_.groups) group = static_cast<std::uint32_t>(random.integer(0, count - 1));
    problem_.plain.groups.count = static_cast<std::size_t>(count);
    problem_.plain.groups.maximum = static_cast<std::size_t>(random.integer(1, 20));
    if (!random.chance(0.5)) return;
    for (int g = 0; g < count; ++g) problem_.maxima.push_back(static_cast<std::uint32_t>(random.integer(0, 20)));
  }

  // With strategies and sweeps that mostly allow them.
  static void draw_targets(Random& random, Options& options) {
    if (random.chance(0.9)) options.exchange.sweeps = 0;
    if (random.chance(0.9)) options.strategy = strategies[random.integer(0, 2)];
    if (random.chance(0.5)) options.target.efficiency = random.uniform(0, 1);
    if (random.chance(0.5)) options.target.translation_sigma = random.uniform(0, 1);
    if (random.chance(0.5)) options.target.rotation_sigma = random.uniform(0, 1);
    if (random.chance(0.03)) options.target.efficiency = random.uniform(1, 2);
  }

  void spoil(Random& random) {
    const int kind = random.integer(0, 80);
    if (kind == 0) options_.target.rotation_sigma = -1;
    if (kind == 1) options_.stochastic.epsilon = 0;
    if (kind == 2) options_.threads = -1;
    if (kind == 3) options_.time_limit = -1;
    if (kind == 4) capacity_ = problem_.blocks.size() / 2;
    if (kind == 5) options_.groups.count = 0;
    if (kind == 6) std::fill(problem_.prior.begin(), problem_.prior.end(), 0.0);
  }

  Problem problem_;
  Options options_;
  std::size_t capacity_ = 0;
};

// The header is read as text: nothing in C could loop over its enumerators, and one that is missing has no name to
// test.
template <class Enum, std::size_t count>
void expect_enumerators(const Enum (&all)[count], const std::string& type, const char* (*name_in_c)(std::int32_t)) {
  std::ifstream file(MAXLOGDET_C_HEADER);
  const std::string header((std::istreambuf_iterator<char>(file)), {});
  const auto upper = [](std::string text) {
    std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::toupper(c); });
    return text;
  };
  ASSERT_NE(header.find("typedef int32_t " + type + ";"), std::string::npos) << MAXLOGDET_C_HEADER;
  for (std::size_t i = 0; i < count; ++i) {
    EXPECT_EQ(static_cast<std::size_t>(all[i]), i) << "the list of C++ is in the order of the enumerators";
    const std::string line = upper(type + "_" + to_string(all[i])) + " = " + std::to_string(i);
    const std::size_t at = header.find("  " + line);
    const bool is_there = at != std::string::npos && std::isdigit(header[at + 2 + line.size()]) == 0;
    EXPECT_TRUE(is_there) << MAXLOGDET_C_HEADER << " lacks " << line;
    EXPECT_STREQ(name_in_c(static_cast<std::int32_t>(i)), to_string(all[i]));
  }
}

TEST(CApi, every_strategy_has_its_enumerator) {
  expect_enumerators(strategies, "maxlogdet_strategy", maxlogdet_strategy_name);
}

TEST(CApi, every_camera_model_has_its_enumerator) {
  expect_enumerators(camera_models, "maxlogdet_camera_model", maxlogdet_camera_model_name);
}

TEST(CApi, selections_equal_those_of_cpp) {
  std::size_t answers = 0;
  std::size_t errors = 0;
  const std::size_t count = trials(2000);
  for (std::uint64_t variation = 0; variation < count; ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const Instance instance(random);
    const CBlocks blocks = copied(instance.blocks());
    expect_same(*blocks, instance.blocks());
    const CSelector selector = c_selector(instance.capacity());
    EXPECT_EQ(maxlogdet_selector_capacity(selector.get()), instance.capacity());
    Selector expected(instance.capacity());
    const maxlogdet_options options = options_in_c(instance.options());
    const maxlogdet_selection* const selection = maxlogdet_selector_select(selector.get(), blocks.get(), &options);
    expect_same(*selection, expected.select(instance.blocks(), instance.options()));
    if (HasFatalFailure()) return;
    ++(maxlogdet_selection_has_answer(selection) != 0 ? answers : errors);
  }
  EXPECT_GE(answers, count / 2);
  EXPECT_GE(errors, count / 50);
}

// One answer to the proposal under way in C and C++.
void expect_same_answer(Random& random, maxlogdet_active_selection* active, ActiveSelection& expected) {
  const int answer = random.integer(0, 3);
  const Block measured = random_block(random, random.integer(1, 3));
  const auto rows = static_cast<int>(measured.rows()) + (answer == 3 ? 3 : 0);  // 3: of too many rows
  Error error = Error::none;
  maxlogdet_error in_c = MAXLOGDET_ERROR_NONE;
  if (answer == 0) {
    error = expected.reject();
    in_c = maxlogdet_active_selection_reject(active);
  } else if (answer == 1) {
    error = expected.accept();
    in_c = maxlogdet_active_selection_accept(active);
  } else {
    error = expected.accept(measured.data(), rows);
    in_c = maxlogdet_active_selection_accept_block(active, measured.data(), rows);
  }
  ASSERT_EQ(in_c, static_cast<int>(error));
  expect_same(*maxlogdet_active_selection_selection(active), expected.selection());
}

// Until nothing is proposed, or now and then earlier.
void expect_same_proposals(Random& random, maxlogdet_active_selection* active, ActiveSelection& expected) {
  while (!::testing::Test::HasFailure()) {
    const std::uint32_t proposed = expected.next();
    ASSERT_EQ(maxlogdet_active_selection_next(active), proposed);
    if (proposed == MAXLOGDET_NONE || random.chance(0.01)) break;
    expect_same_answer(random, active, expected);
  }
}

TEST(CApi, active_selections_equal_those_of_cpp) {
  std::size_t accepted = 0;
  for (std::uint64_t variation = 0; variation < trials(500); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const CActive active = c_active(200);
    ActiveSelection expected(200);
    for (int round = 0; round < 2; ++round) {  // a handle is used again
      const Instance instance(random);
      const CBlocks blocks = copied(instance.blocks());
      Options cpp_options = instance.options();
      if (random.chance(0.9)) cpp_options.strategy = Strategy::lazy_greedy;
      const maxlogdet_options options = options_in_c(cpp_options);
      ASSERT_EQ(maxlogdet_active_selection_start(active.get(), blocks.get(), &options),
                static_cast<int>(expected.start(instance.blocks(), cpp_options)));
      expect_same_proposals(random, active.get(), expected);
      if (HasFailure()) return;
      accepted += expected.selection().size;
      expect_same(*maxlogdet_active_selection_selection(active.get()), expected.selection());
    }
  }
  EXPECT_GT(accepted, 1000U * trials(500) / 500);
}

// One answer of any kind to both, about any of the proposals or none of them.
void expect_same_answer(Random& random, const std::vector<std::uint32_t>& proposed, maxlogdet_active_selection* active,
                        ActiveSelection& expected) {
  const auto any = static_cast<std::uint32_t>(random.integer(0, 201));
  const auto place = static_cast<std::size_t>(random.integer(0, static_cast<int>(proposed.size()) - 1));
  const std::uint32_t index = random.chance(0.9) ? proposed[place] : any;
  const Block measured = random_block(random, random.integer(1, 3));
  const auto rows = static_cast<int>(measured.rows()) + (random.chance(0.1) ? 3 : 0);
  std::vector<unsigned char> matched(proposed.size() + (random.chance(0.1) ? 1 : 0));
  for (unsigned char& flag : matched) flag = random.chance(0.5) ? 9 : 0;
  Error error = Error::none;
  maxlogdet_error in_c = MAXLOGDET_ERROR_NONE;
  switch (random.integer(0, 4)) {
    case 0:
      error = expected.reject(index);
      in_c = maxlogdet_active_selection_reject_index(active, index);
      break;
    case 1:
      error = expected.accept(index, measured.data(), rows);
      in_c = maxlogdet_active_selection_accept_block_index(active, index, measured.data(), rows);
      break;
    case 2:
      error = expected.answer(matched.data(), matched.size());
      in_c = maxlogdet_active_selection_answer(active, matched.data(), matched.size());
      break;
    case 3:
      error = expected.reject();
      in_c = maxlogdet_active_selection_reject(active);
      break;
    default: error = expected.accept(index); in_c = maxlogdet_active_selection_accept_index(active, index);
  }
  ASSERT_EQ(in_c, static_cast<int>(error));
}

TEST(CApi, batches_equal_those_of_cpp) {
  const std::size_t instances = std::max<std::size_t>(20, trials(500));
  std::size_t accepted = 0;
  for (std::uint64_t variation = 0; variation < instances; ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const CActive active = c_active(200);
    ActiveSelection expected(200);
    const Instance instance(random);
    const CBlocks blocks = copied(instance.blocks());
    Options cpp_options = instance.options();
    cpp_options.strategy = Strategy::lazy_greedy;
    const maxlogdet_options options = options_in_c(cpp_options);
    ASSERT_EQ(maxlogdet_active_selection_start(active.get(), blocks.get(), &options),
              static_cast<int>(expected.start(instance.blocks(), cpp_options)));
    for (;;) {
      const auto wanted = static_cast<std::size_t>(random.integer(1, 20));
      std::vector<std::uint32_t> proposed(wanted), in_c(wanted);
      proposed.resize(expected.next(proposed.data(), wanted));
      in_c.resize(maxlogdet_active_selection_next_batch(active.get(), in_c.data(), wanted));
      ASSERT_EQ(in_c, proposed);
      if (proposed.empty()) break;
      expect_same_answer(random, proposed, active.get(), expected);
      if (HasFailure()) return;
    }
    accepted += expected.selection().size;
    expect_same(*maxlogdet_active_selection_selection(active.get()), expected.selection());
  }
  EXPECT_GT(accepted, 2 * instances);
}

}  // namespace
}  // namespace maxlogdet::test
