// SPDX-License-Identifier: MIT
// The C API is the C++ one in other words: the same answers, bit for bit, errors included, and the same recordings.
// Most of it is the code of the fuzz target c_api, on random bytes.
#include "tests/api/c_api.hpp"
#include "tests/fuzz/c_api_calls.hpp"
#include "tests/fuzz/c_api_frames.hpp"
#include "tests/fuzz/c_api_same.hpp"
#include "tests/fuzz/problem.hpp"
#include "tests/fuzz/require.hpp"
#include "tests/support/recording.hpp"
#include "tests/support/support.hpp"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

namespace maxlogdet::test {
namespace {

// The names of the enumerators of C++, which are numbered from 0 on.
template <class Enum>
std::vector<std::string> names_of() {
  std::vector<std::string> names;
  for (std::string name; (name = to_string(static_cast<Enum>(names.size()))) != "unknown";) names.push_back(name);
  return names;
}

// Values of the C API are permanent: the header has each name with its number. It is read as text: nothing in C could
// loop over its enumerators, and one that is missing has no name to test.
void expect_enumerators(const std::vector<std::string>& names, const std::string& type) {
  std::ifstream file(MAXLOGDET_C_HEADER);
  const std::string header((std::istreambuf_iterator<char>(file)), {});
  const auto upper = [](std::string text) {
    std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::toupper(c); });
    return text;
  };
  ASSERT_NE(header.find("typedef int32_t " + type + ";"), std::string::npos) << MAXLOGDET_C_HEADER;
  ASSERT_GE(names.size(), 3U);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string line = upper(type + "_" + names[i]) + " = " + std::to_string(i);
    const std::size_t at = header.find("  " + line);
    const bool is_there = at != std::string::npos && std::isdigit(header[at + 2 + line.size()]) == 0;
    EXPECT_TRUE(is_there) << MAXLOGDET_C_HEADER << " lacks " << line;
  }
}

template <class Enum>
void expect_names(const std::string& type, const char* (*name_in_c)(std::int32_t)) {
  const std::vector<std::string> names = names_of<Enum>();
  expect_enumerators(names, type);
  for (std::size_t i = 0; i < names.size(); ++i) EXPECT_EQ(name_in_c(static_cast<std::int32_t>(i)), names[i]);
}

template <class Enum, std::size_t count>
void expect_in_order(const Enum (&all)[count]) {
  EXPECT_EQ(count, names_of<Enum>().size());
  for (std::size_t i = 0; i < count; ++i) EXPECT_EQ(static_cast<std::size_t>(all[i]), i);
}

TEST(CApi, lists_of_enumerators_are_whole_and_in_their_order) {
  expect_in_order(camera_models);
  expect_in_order(strategies);
  expect_in_order(weightings);
}

TEST(CApi, every_enumerator_has_its_value_and_name_in_c) {
  expect_names<CameraModel>("maxlogdet_camera_model", maxlogdet_camera_model_name);
  expect_names<Error>("maxlogdet_error", maxlogdet_error_name);
  expect_names<Status>("maxlogdet_status", maxlogdet_status_name);
  expect_names<Strategy>("maxlogdet_strategy", maxlogdet_strategy_name);
  expect_names<Weighting>("maxlogdet_weighting", maxlogdet_weighting_name);
}

// They have no names in the library.
TEST(CApi, every_depth_cue_has_its_value_in_c) {
  static_assert(DepthCue::none == DepthCue{0} && DepthCue::stereo == DepthCue{1} && DepthCue::depth == DepthCue{2}, "");
  expect_enumerators({"none", "stereo", "depth"}, "maxlogdet_depth_cue");
}

// Calls check() with random bytes; a failure names their seed.
template <class Check>
void check_with_bytes(std::size_t inputs, int max_size, const Check& check) {
  for (std::uint64_t variation = 0; variation < inputs; ++variation) {
    Random random(variation);
    std::vector<std::uint8_t> data(static_cast<std::size_t>(random.integer(0, max_size)));
    for (std::uint8_t& byte : data) byte = static_cast<std::uint8_t>(random.integer(0, 255));
    fuzz::Bytes bytes(data.data(), data.size());
    try {
      check(bytes);
    } catch (const fuzz::Violation& violation) {
      FAIL() << violation.what() << ", " << random.name();
    }
  }
}

TEST(CApi, any_calls_equal_those_of_cpp) {
  std::size_t answers = 0;
  check_with_bytes(trials(5000), 5000, [&](fuzz::Bytes& bytes) { answers += fuzz::check_c_api(bytes); });
  EXPECT_GE(answers, trials(5000) / 5);
}

TEST(CApi, good_features_equal_those_of_cpp) {
  std::size_t selected = 0;
  check_with_bytes(trials(3000), 5000, [&](fuzz::Bytes& bytes) {
    fuzz::Frames frames(bytes, bytes.below(40));
    for (int frame = 0; frame < 3; ++frame) {
      frames.run();
      selected += frames.selected();
    }
  });
  EXPECT_GE(selected, 3 * trials(3000));
}

TEST(CApi, recordings_equal_those_of_cpp) {
  std::size_t recorded = 0;
  check_with_bytes(20, 20000, [&](fuzz::Bytes& bytes) {
    const TemporaryFolder in_c, in_cpp;
    fuzz::Frames frames(bytes, 40);
    frames.record(in_c.path(), in_cpp.path());
    for (int frame = 0; frame < 10; ++frame) frames.run();  // until one cannot be recorded, which ends both
    ASSERT_EQ(in_c.files(), in_cpp.files());
    for (const std::string& name : in_cpp.files()) EXPECT_EQ(text_of(in_c / name), text_of(in_cpp / name)) << name;
    recorded += in_cpp.files().size();
  });
  EXPECT_GE(recorded, 20U);
}

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

TEST(CApi, selections_equal_those_of_cpp) {
  std::size_t answers = 0, errors = 0;
  check_with_bytes(trials(2000), 3000, [&](fuzz::Bytes& bytes) {
    BlockStore blocks;
    fuzz::append_candidates(bytes, blocks);
    fuzz::Request request(bytes, blocks);
    if (request.options.time_limit > 0) request.options.time_limit = 1e-9;  // so that C and C++ agree
    const maxlogdet_options options = options_in_c(request.options);
    const CSelector selector = c_selector(request.capacity);
    Selector expected(request.capacity);
    const maxlogdet_selection* const selection =
        maxlogdet_selector_select(selector.get(), copied(blocks).get(), &options);
    fuzz::check_same(selection, expected.select(blocks, request.options));
    ++(maxlogdet_selection_has_answer(selection) != 0 ? answers : errors);
  });
  EXPECT_GE(answers, trials(2000) / 3);
  EXPECT_GE(errors, trials(2000) / 50);
}

// One answer of any kind to both, about any of the proposals or none of them.
void answer_both(Random& random, const std::vector<std::uint32_t>& proposed, maxlogdet_active_selection* in_c,
                 ActiveSelection& in_cpp) {
  const std::uint32_t index =
      random.chance(0.9) ? proposed[random.index(proposed.size())] : static_cast<std::uint32_t>(random.integer(0, 201));
  const Block measured = random_block(random, random.integer(1, 3));
  const auto rows = static_cast<int>(measured.rows()) + (random.chance(0.1) ? 3 : 0);
  const double* const block = random.chance(0.1) ? nullptr : measured.data();
  std::vector<unsigned char> matched(proposed.size() + (random.chance(0.1) ? 1 : 0));
  for (unsigned char& flag : matched) flag = random.chance(0.5) ? 9 : 0;
  const unsigned char* const flags = random.chance(0.1) ? nullptr : matched.data();
  struct Errors {
    maxlogdet_error in_c;
    Error in_cpp;
  };
  const auto errors = [&]() -> Errors {
    switch (random.integer(0, 6)) {
      case 0: return {maxlogdet_active_selection_reject_index(in_c, index), in_cpp.reject(index)};
      case 1: return {maxlogdet_active_selection_accept_index(in_c, index), in_cpp.accept(index)};
      case 2:
        return {maxlogdet_active_selection_accept_block_index(in_c, index, block, rows),
                in_cpp.accept(index, block, rows)};
      case 3:
        return {maxlogdet_active_selection_answer(in_c, flags, matched.size()), in_cpp.answer(flags, matched.size())};
      case 4: return {maxlogdet_active_selection_reject(in_c), in_cpp.reject()};
      case 5: return {maxlogdet_active_selection_accept(in_c), in_cpp.accept()};
      default: return {maxlogdet_active_selection_accept_block(in_c, block, rows), in_cpp.accept(block, rows)};
    }
  }();
  ASSERT_EQ(errors.in_c, static_cast<int>(errors.in_cpp));
}

// Until nothing is proposed any more: more of them in a row than random bytes make.
TEST(CApi, active_selections_equal_those_of_cpp) {
  const std::size_t instances = std::max<std::size_t>(20, trials(500));
  std::size_t accepted = 0;
  for (std::uint64_t variation = 0; variation < instances; ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const BlockStore blocks = awkward_blocks(random, static_cast<std::size_t>(random.integer(0, 150)));
    const CBlocks copy = copied(blocks);
    const CActive active = c_active(200);
    ActiveSelection expected(200);
    const Options cpp_options = with_budget(random.index(60));
    const maxlogdet_options options = options_in_c(cpp_options);
    ASSERT_EQ(maxlogdet_active_selection_start(active.get(), copy.get(), &options), MAXLOGDET_ERROR_NONE);
    expected.start(blocks, cpp_options);
    for (;;) {
      const std::size_t wanted = 1 + random.index(10);
      std::vector<std::uint32_t> proposed(wanted), in_c(wanted);
      proposed.resize(expected.next(proposed.data(), wanted));
      if (wanted > 1) in_c.resize(maxlogdet_active_selection_next_batch(active.get(), in_c.data(), wanted));
      if (wanted == 1) in_c[0] = maxlogdet_active_selection_next(active.get());
      if (proposed.empty()) break;
      ASSERT_EQ(in_c, proposed);
      answer_both(random, proposed, active.get(), expected);
      if (HasFailure()) return;
    }
    accepted += expected.selection().size;
    EXPECT_NO_THROW(fuzz::check_same(maxlogdet_active_selection_selection(active.get()), expected.selection()));
  }
  EXPECT_GT(accepted, 2 * instances);
}

}  // namespace
}  // namespace maxlogdet::test
