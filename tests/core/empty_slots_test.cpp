// SPDX-License-Identifier: MIT
// Candidates without a block take an index and nothing else, and so do excluded ones: the answer is that of a store
// that holds only the others, bit for bit, whatever is asked for.
#include "sim/frame.hpp"
#include "tests/support/support.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <new>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace maxlogdet::test {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

// Blocks in the order of their indices; of an invalid candidate none.
using Slots = std::vector<std::optional<Block>>;

// 1 to 3 rows each; some duplicated, scaled, zero or nearly parallel to others.
std::vector<Block> random_blocks(Random& random, std::size_t n) {
  const BlockStore made = awkward_blocks(random, n);
  std::vector<Block> blocks;
  for (std::size_t i = 0; i < n; ++i) {
    const Block padded = stored_block(made, i);
    Eigen::Index rows = padded.rows();
    while (rows > 1 && padded.row(rows - 1).isZero(0)) --rows;
    blocks.emplace_back(padded.topRows(rows));
  }
  return blocks;
}

// The same blocks with empty slots before, between and behind them.
Slots with_empty_slots(Random& random, const std::vector<Block>& blocks, double share) {
  Slots slots;
  for (const Block& block : blocks) {
    while (random.chance(share)) slots.emplace_back();
    slots.emplace_back(block);
  }
  while (random.chance(share)) slots.emplace_back();
  return slots;
}

// Each of the ways to have no block.
std::size_t push_back_empty(Random& random, BlockStore& blocks) {
  double entries[18] = {};
  const double broken[] = {nan, std::numeric_limits<double>::infinity(), 1e39, -1e300};
  entries[random.integer(0, 5)] = broken[random.integer(0, 3)];
  switch (random.integer(0, 3)) {
    case 0: return blocks.push_back(entries, random.integer(1, 3));
    case 1: return blocks.push_back(nullptr, 2);
    case 2: return blocks.push_back(entries, random.chance(0.5) ? 0 : 4);
    default: return blocks.push_back_invalid();
  }
}

void push_back_slot(Random& random, const std::optional<Block>& slot, BlockStore& blocks) {
  if (slot) {
    push_back(blocks, *slot);
  } else {
    push_back_empty(random, blocks);
  }
}

// One more slot, with a block or without.
void push_back_random(Random& random, BlockStore& blocks, Slots& slots) {
  slots.emplace_back();
  if (random.chance(0.5)) slots.back() = random_block(random, random.integer(1, 3));
  push_back_slot(random, slots.back(), blocks);
}

BlockStore store_of(Random& random, const Slots& slots) {
  BlockStore blocks;
  for (const std::optional<Block>& slot : slots) push_back_slot(random, slot, blocks);
  return blocks;
}

std::vector<std::uint32_t> present(const Slots& slots) {
  std::vector<std::uint32_t> indices;
  for (std::uint32_t i = 0; i < slots.size(); ++i) {
    if (slots[i]) indices.push_back(i);
  }
  return indices;
}

template <class T>
std::vector<T> gathered(const std::vector<T>& values, const std::vector<std::uint32_t>& indices) {
  std::vector<T> result;
  if (values.empty()) return result;
  for (const std::uint32_t i : indices) result.push_back(values[i]);
  return result;
}

// What is asked for, with the caller's arrays, each of which may be empty.
struct Request {
  std::vector<unsigned char> required, excluded;
  std::vector<std::uint32_t> groups, maxima;
  std::vector<double> prior;
  Options plain;  // all but the arrays

  Options options(Strategy strategy) const {
    Options result = plain;
    result.strategy = strategy;
    result.prior = prior.empty() ? nullptr : prior.data();
    result.required = required.empty() ? nullptr : required.data();
    result.excluded = excluded.empty() ? nullptr : excluded.data();
    result.groups = groups.empty() ? nullptr : groups.data();
    result.group_count = maxima.size();
    result.group_maxima = maxima.empty() ? nullptr : maxima.data();
    return result;
  }

  // The same of a store that holds these candidates alone.
  Request of(const std::vector<std::uint32_t>& indices) const {
    Request result = *this;
    result.required = gathered(required, indices);
    result.excluded = gathered(excluded, indices);
    result.groups = gathered(groups, indices);
    return result;
  }
};

// Any subset of the constraints, certificate and exchange. Slots without a block are excluded, in groups and never
// required, as a tracker's arrays have it.
Request random_request(Random& random, const BlockStore& blocks, double excluded_share) {
  const std::size_t n = blocks.size();
  Request request;
  const auto some = [&](double share) {
    std::vector<unsigned char> flags(n);
    for (unsigned char& flag : flags) flag = random.chance(share) ? 9 : 0;
    return flags;
  };
  if (excluded_share > 0) request.excluded = some(excluded_share);
  if (random.chance(0.4)) {
    request.required = some(0.03);
    for (std::size_t i = 0; i < n; ++i) {
      const bool may_be = blocks.is_valid(i) && (request.excluded.empty() || request.excluded[i] == 0);
      if (!may_be) request.required[i] = 0;
    }
  }
  if (random.chance(0.3)) {
    const int count = random.integer(1, 8);
    for (int g = 0; g < count; ++g) request.maxima.push_back(static_cast<std::uint32_t>(random.integer(0, 9)));
    for (std::size_t i = 0; i < n; ++i) {
      request.groups.push_back(static_cast<std::uint32_t>(random.integer(0, count - 1)));
    }
  }
  if (random.chance(0.5)) {
    const Matrix6 prior = random_prior(random);
    request.prior.assign(prior.data(), prior.data() + prior.size());
  }
  request.plain.budget = static_cast<std::size_t>(random.integer(0, static_cast<int>(blocks.stored() + 2)));
  request.plain.seed = random.seed();
  request.plain.epsilon = random.uniform(0.01, 0.9);
  request.plain.certify = random.chance(0.5);
  request.plain.certificate_passes = static_cast<std::size_t>(random.integer(0, 4));
  request.plain.exchange_sweeps = static_cast<std::size_t>(random.integer(0, 2));
  return request;
}

std::uint64_t bits_of(double value) {
  std::uint64_t bits = 0;
  std::memcpy(&bits, &value, sizeof bits);
  return bits;
}

// How a selection ended. Of a store without candidates nothing is missing, of one whose candidates are all out all are
// selected that there are.
void expect_same_end(const Selection& actual, const Selection& expected, bool has_candidates, std::size_t budget) {
  const bool differ = !has_candidates && budget > 0 && expected.status == Status::ok;
  EXPECT_EQ(actual.status, differ ? Status::all_selected : expected.status);
}

// The same but for indices, of which `kept` says what they are in the store with more candidates.
void expect_same_answer(const Selection& actual, const Selection& expected, const std::vector<std::uint32_t>& kept) {
  EXPECT_EQ(indices_of(actual), gathered(kept, indices_of(expected)));
  ASSERT_EQ(actual.size, expected.size);
  for (std::size_t j = 0; j < actual.size; ++j) EXPECT_EQ(bits_of(actual.gains[j]), bits_of(expected.gains[j])) << j;
  EXPECT_EQ(bits_of(actual.log_det), bits_of(expected.log_det));
  EXPECT_EQ(bits_of(actual.upper_bound), bits_of(expected.upper_bound));
  EXPECT_EQ(actual.strategy, expected.strategy);
  EXPECT_EQ(actual.threads, expected.threads);
}

// And at the same cost.
void expect_same(const Selection& actual, const Selection& expected, const std::vector<std::uint32_t>& kept) {
  expect_same_answer(actual, expected, kept);
  EXPECT_EQ(actual.evaluations, expected.evaluations);
  EXPECT_EQ(actual.float64_decisions, expected.float64_decisions);
}

Selector selector_for(const BlockStore& blocks, const Request& request) {
  return Selector(std::max({blocks.size(), request.plain.budget, request.maxima.size()}));
}

// Every strategy's answer of `whole` against that of `dense`, which holds the candidates `kept` of it alone.
// `is_alike`: blocks of both are screened in the same form (simd/kernel.hpp), at the same cost.
void expect_same_answers(const BlockStore& whole, const Request& request, const BlockStore& dense,
                         const std::vector<std::uint32_t>& kept, bool is_alike = true) {
  const Request of_dense = request.of(kept);
  Selector selector = selector_for(whole, request);
  Selector dense_selector = selector_for(dense, of_dense);
  for (const Strategy strategy : strategies) {
    SCOPED_TRACE(to_string(strategy));
    const Selection expected = dense_selector.select(dense, of_dense.options(strategy));
    const Selection actual = selector.select(whole, request.options(strategy));
    // Without candidates there are no groups to refuse.
    if (dense.size() == 0 && actual.status == Status::unsupported_groups) continue;
    expect_same_end(actual, expected, dense.size() > 0, request.plain.budget);
    is_alike ? expect_same(actual, expected, kept) : expect_same_answer(actual, expected, kept);
    EXPECT_EQ(actual.invalid_candidates, whole.invalid_count());
  }
}

TEST(EmptySlots, answers_are_those_of_the_store_without_them) {
  for (std::uint64_t variation = 0; variation < trials(600); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const std::vector<Block> blocks = random_blocks(random, static_cast<std::size_t>(random.integer(0, 150)));
    const Slots slots = with_empty_slots(random, blocks, random.uniform(0.02, 0.9));
    const BlockStore holed = store_of(random, slots);
    BlockStore dense;
    for (const Block& block : blocks) push_back(dense, block);
    ASSERT_EQ(holed.stored(), dense.size());
    if (holed.size() == 0) continue;
    expect_same_answers(holed, random_request(random, holed, random.chance(0.5) ? 0.05 : 0), dense, present(slots));
    if (HasFailure()) return;
  }
}

// Some matches that have no block, for every reason that there is.
std::vector<unsigned char> spoil(Random& random, double share, sim::Frame& frame) {
  std::vector<unsigned char> usable(frame.matches.size(), 1);
  for (std::size_t i = 0; i < frame.matches.size(); ++i) {
    if (!random.chance(share)) continue;
    sim::Match& match = frame.matches[i];
    switch (random.integer(0, 3)) {
      case 0: match.point[random.integer(0, 2)] = nan; break;
      case 1: match.inv_sigma2 = random.chance(0.5) ? nan : -1; break;
      case 2:  // to the other side of the camera
        for (std::size_t d = 0; d < 3; ++d) {
          const std::array<double, 12>& T = frame.T_cw_prior;
          const double camera = -(T[d] * T[3] + T[4 + d] * T[7] + T[8 + d] * T[11]);
          match.point[d] = 2 * camera - match.point[d];
        }
        break;
      default: usable[i] = 0;
    }
  }
  return usable;
}

TEST(EmptySlots, answers_are_those_of_the_frame_without_them) {
  for (const sim::Scene scene : sim::scenes) {
    for (const BlockKind& kind : block_kinds) {
      Random random(static_cast<std::uint64_t>(scene));
      SCOPED_TRACE(random.name() + ", " + to_string(scene) + ' ' + kind.name);
      sim::Frame frame = make_scene(scene, 1500, random.seed());
      const std::vector<unsigned char> usable = spoil(random, random.uniform(0.05, 0.8), frame);
      const sim::MatchArrays arrays(frame);
      Matches matches = arrays.view();
      matches.usable = usable.data();
      BlockOptions options;
      options.weighting = kind.weighting;
      options.third = kind.third;
      BlockStore holed;
      append_blocks(frame.camera, frame.T_cw_prior.data(), matches, options, holed);
      const std::vector<std::uint32_t> kept(holed.indices(), holed.indices() + holed.stored());
      ASSERT_GT(kept.size(), 200U);
      ASSERT_LT(kept.size(), 1500U);
      BlockStore dense;
      sim::build_blocks(frame, sim::MatchArrays(frame, kept), options, dense);
      ASSERT_EQ(dense.stored(), kept.size());
      Request request;
      request.plain.budget = 20;
      request.plain.certify = true;
      request.plain.certificate_passes = 3;
      request.plain.exchange_sweeps = 1;
      expect_same_answers(holed, request, dense, kept);
      request.plain.budget = kept.size() - 10;
      expect_same_answers(holed, request, dense, kept);
    }
  }
}

// Draws are of the valid ones in their order, wherever the others are.
TEST(EmptySlots, samples_do_not_depend_on_them) {
  Random random;
  SCOPED_TRACE(random.name());
  const std::vector<Block> blocks = random_blocks(random, 200);
  BlockStore dense;
  for (const Block& block : blocks) push_back(dense, block);
  Options options;
  options.strategy = Strategy::stochastic_greedy;
  options.budget = 30;
  Selector selector(4000);
  for (options.seed = 0; options.seed < 20; ++options.seed) {
    const std::vector<std::uint32_t> expected = indices_of(selector.select(dense, options));
    for (const double share : {0.01, 0.5, 0.9}) {
      const Slots slots = with_empty_slots(random, blocks, share);
      const BlockStore holed = store_of(random, slots);
      EXPECT_EQ(indices_of(selector.select(holed, options)), gathered(present(slots), expected)) << options.seed;
    }
  }
}

// Proposals of both in step, whatever the answers are.
void expect_same_proposals(Random& random, ActiveSelection& active, ActiveSelection& dense,
                           const std::vector<std::uint32_t>& kept) {
  constexpr std::size_t most = 8;
  for (;;) {
    std::uint32_t proposed[most];
    std::uint32_t expected[most];
    const auto wanted = static_cast<std::size_t>(random.integer(1, most));
    const std::size_t count = dense.next(expected, wanted);
    ASSERT_EQ(active.next(proposed, wanted), count);
    if (count == 0) break;
    for (std::size_t j = 0; j < count; ++j) ASSERT_EQ(proposed[j], kept[expected[j]]);
    ASSERT_EQ(active.next(), proposed[0]);
    const Block measured = random_block(random, random.integer(1, 3));
    const auto rows = static_cast<int>(measured.rows());
    switch (random.integer(0, 2)) {
      case 0:
        ASSERT_EQ(active.accept(proposed[count - 1]), Status::ok);
        ASSERT_EQ(dense.accept(expected[count - 1]), Status::ok);
        break;
      case 1:
        ASSERT_EQ(active.accept(measured.data(), rows), Status::ok);
        ASSERT_EQ(dense.accept(measured.data(), rows), Status::ok);
        break;
      default: ASSERT_EQ(active.reject(proposed[0]), Status::ok); ASSERT_EQ(dense.reject(expected[0]), Status::ok);
    }
  }
}

void expect_same_active(Random& random, const BlockStore& whole, const Request& request, const BlockStore& dense,
                        const std::vector<std::uint32_t>& kept) {
  const Request of_dense = request.of(kept);
  ActiveSelection active(std::max({whole.size(), request.plain.budget, request.maxima.size()}));
  ActiveSelection expected(std::max({dense.size(), request.plain.budget, request.maxima.size()}));
  const Status status = expected.start(dense, of_dense.options(Strategy::lazy_greedy));
  ASSERT_EQ(active.start(whole, request.options(Strategy::lazy_greedy)), status);
  if (status != Status::ok) return;
  expect_same_proposals(random, active, expected, kept);
  expect_same_end(active.selection(), expected.selection(), dense.size() > 0, request.plain.budget);
  expect_same_answer(active.selection(), expected.selection(), kept);
  EXPECT_EQ(active.selection().invalid_candidates, whole.invalid_count());
}

TEST(EmptySlots, active_selection_proposes_the_same_without_them) {
  for (std::uint64_t variation = 0; variation < trials(300); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const std::vector<Block> blocks = random_blocks(random, static_cast<std::size_t>(random.integer(1, 150)));
    const Slots slots = with_empty_slots(random, blocks, random.uniform(0.02, 0.9));
    const BlockStore holed = store_of(random, slots);
    BlockStore dense;
    for (const Block& block : blocks) push_back(dense, block);
    const Request request = random_request(random, holed, random.chance(0.5) ? 0.05 : 0);
    expect_same_active(random, holed, request, dense, present(slots));
    if (HasFailure()) return;
  }
}

TEST(EmptySlots, a_store_of_nothing_else_has_nothing_to_select) {
  for (const std::size_t n : {std::size_t{1}, std::size_t{16}, std::size_t{1000}}) {
    Random random(n);
    SCOPED_TRACE(random.name());
    BlockStore blocks;
    for (std::size_t i = 0; i < n; ++i) EXPECT_EQ(push_back_empty(random, blocks), i);
    EXPECT_EQ(blocks.stored(), 0U);
    EXPECT_EQ(blocks.rows(), 0);
    Request request = random_request(random, blocks, 0.5);
    request.groups.clear();
    request.plain.budget = 1;
    request.plain.certify = true;
    expect_same_answers(blocks, request, BlockStore(), {});
    ActiveSelection active(n);
    ASSERT_EQ(active.start(blocks, request.options(Strategy::greedy)), Status::ok);
    EXPECT_EQ(active.next(), ActiveSelection::none);
    EXPECT_EQ(active.selection().status, Status::all_selected);
    std::vector<unsigned char> required(n);
    required[n / 2] = 1;
    request.required = required;
    Selector selector = selector_for(blocks, request);
    EXPECT_EQ(selector.select(blocks, request.options(Strategy::greedy)).status, Status::infeasible);
  }
}

// Candidates of which some are excluded, and the store of the others. The first is kept, and as tall as any.
struct Excluded {
  BlockStore whole, dense;
  std::vector<std::uint32_t> kept;
  Request request;
};

// `excluded` of the valid ones, `share` of empty slots. Some of those excluded are larger than all that is kept.
Excluded random_excluded(Random& random, std::size_t n, std::size_t excluded, double share) {
  std::vector<Block> blocks = random_blocks(random, n);
  blocks[0] = random_block(random, 3);
  const Slots slots = with_empty_slots(random, blocks, share);
  std::vector<std::uint32_t> valid = present(slots);
  std::vector<unsigned char> flags(slots.size());
  for (std::size_t i = 0; i < slots.size(); ++i) flags[i] = !slots[i] && random.chance(0.5) ? 1 : 0;
  for (std::size_t j = 0; j < excluded; ++j) {  // the first j + 1 of a shuffle, but for the first candidate
    std::swap(valid[j + 1],
              valid[static_cast<std::size_t>(random.integer(static_cast<int>(j + 1), static_cast<int>(n - 1)))]);
    flags[valid[j + 1]] = 5;
  }
  Excluded made;
  for (std::uint32_t i = 0; i < slots.size(); ++i) {
    const bool is_out = flags[i] != 0;
    push_back_slot(random, is_out && slots[i] ? std::optional<Block>(*slots[i] * random.uniform(0.1, 50)) : slots[i],
                   made.whole);
    if (is_out || !slots[i]) continue;
    push_back(made.dense, *slots[i]);
    made.kept.push_back(i);
  }
  made.request = random_request(random, made.whole, 0);
  made.request.excluded = flags;
  for (std::size_t i = 0; i < flags.size() && !made.request.required.empty(); ++i) {
    if (flags[i] != 0) made.request.required[i] = 0;
  }
  return made;
}

TEST(ExcludedCandidates, many_are_as_if_they_were_not_there) {
  for (std::uint64_t variation = 0; variation < trials(600); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const int n = random.integer(2, 150);
    const int excluded = random.integer(n / 8 + 1, n - 1);
    const Excluded problem = random_excluded(random, static_cast<std::size_t>(n), static_cast<std::size_t>(excluded),
                                             random.chance(0.5) ? 0.3 : 0);
    Request request = problem.request;
    expect_same_answers(problem.whole, request, problem.dense, problem.kept);
    expect_same_active(random, problem.whole, request, problem.dense, problem.kept);
    if (HasFailure()) return;
  }
}

// What is left is pushed back one by one, and so not known to be factored.
TEST(ExcludedCandidates, many_of_a_frame_are_as_if_they_were_not_there) {
  for_every_family(1500, [](const BlockStore& blocks) {
    Random random;
    SCOPED_TRACE(random.name());
    Request request;
    BlockStore dense;
    std::vector<std::uint32_t> kept;
    for (std::uint32_t i = 0; i < blocks.size(); ++i) {
      request.excluded.push_back(random.chance(0.4) ? 1 : 0);
      if (request.excluded[i] != 0) continue;
      push_back(dense, stored_block(blocks, i));
      kept.push_back(i);
    }
    request.plain.budget = 20;
    request.plain.certify = true;
    request.plain.certificate_passes = 3;
    request.plain.exchange_sweeps = 1;
    expect_same_answers(blocks, request, dense, kept, false);
    request.plain.budget = kept.size() - 10;
    expect_same_answers(blocks, request, dense, kept, false);
  });
}

// Too few to be left out by a copy, they are passed over. Sums of float64 then have other zeros among them, which shows
// in the last digits of a bound, and the relaxation starts from another sample.
TEST(ExcludedCandidates, few_are_never_selected_and_change_no_gain) {
  for (std::uint64_t variation = 0; variation < trials(600); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const int n = random.integer(8, 150);
    const Excluded problem =
        random_excluded(random, static_cast<std::size_t>(n), static_cast<std::size_t>(random.integer(1, n / 8)),
                        random.chance(0.5) ? 0.3 : 0);
    const Request of_dense = problem.request.of(problem.kept);
    Selector selector = selector_for(problem.whole, problem.request);
    Selector dense_selector = selector_for(problem.dense, of_dense);
    for (const Strategy strategy : strategies) {
      if (strategy == Strategy::relaxed) continue;
      SCOPED_TRACE(to_string(strategy));
      const Selection expected = dense_selector.select(problem.dense, of_dense.options(strategy));
      const Selection actual = selector.select(problem.whole, problem.request.options(strategy));
      EXPECT_EQ(actual.status, expected.status);
      EXPECT_EQ(indices_of(actual), gathered(problem.kept, indices_of(expected)));
      if (HasFailure()) return;
      for (std::size_t j = 0; j < actual.size; ++j) EXPECT_EQ(bits_of(actual.gains[j]), bits_of(expected.gains[j]));
      EXPECT_EQ(bits_of(actual.log_det), bits_of(expected.log_det));
      EXPECT_EQ(std::isnan(actual.upper_bound), std::isnan(expected.upper_bound));
      if (std::isnan(expected.upper_bound)) continue;
      EXPECT_NEAR(actual.upper_bound, expected.upper_bound, 1e-6 * (1 + std::abs(expected.upper_bound)));
    }
    expect_same_active(random, problem.whole, problem.request, problem.dense, problem.kept);
    if (HasFailure()) return;
  }
}

TEST(ExcludedCandidates, are_not_relaxed_either) {
  for_every_family(1500, [](const BlockStore& blocks) {
    Random random;
    std::vector<unsigned char> excluded(blocks.size());
    for (unsigned char& flag : excluded) flag = random.chance(0.05) ? 1 : 0;
    Options options;
    options.budget = 30;
    options.excluded = excluded.data();
    Selector selector(blocks.size());
    const double greedy = selector.select(blocks, options).log_det;
    options.strategy = Strategy::relaxed;
    const Selection relaxed = selector.select(blocks, options);
    for (const std::uint32_t i : relaxed) EXPECT_EQ(excluded[i], 0);
    EXPECT_GT(relaxed.log_det, greedy - 0.02);
  });
}

TEST(ExcludedCandidates, all_of_them_leave_nothing) {
  for (const std::size_t n : {std::size_t{1}, std::size_t{7}, std::size_t{400}}) {
    Random random(n);
    SCOPED_TRACE(random.name());
    const Slots slots = with_empty_slots(random, random_blocks(random, n), 0.3);
    const BlockStore blocks = store_of(random, slots);
    Request request;
    request.excluded.assign(slots.size(), 1);
    request.plain.budget = 5;
    request.plain.certify = true;
    request.plain.certificate_passes = 2;
    request.plain.exchange_sweeps = 1;
    expect_same_answers(blocks, request, BlockStore(), {});
    ActiveSelection active(std::max<std::size_t>(5, slots.size()));
    ASSERT_EQ(active.start(blocks, request.options(Strategy::lazy_greedy)), Status::ok);
    EXPECT_EQ(active.next(), ActiveSelection::none);
    EXPECT_EQ(active.selection().status, Status::all_selected);
  }
}

// A store against what was put into it.
void expect_holds(const BlockStore& blocks, const Slots& slots) {
  const std::vector<std::uint32_t> valid = present(slots);
  ASSERT_EQ(blocks.size(), slots.size());
  ASSERT_EQ(blocks.stored(), valid.size());
  ASSERT_EQ(blocks.invalid_count(), slots.size() - valid.size());
  ASSERT_LE(blocks.size(), blocks.capacity());
  ASSERT_EQ(std::vector<std::uint32_t>(blocks.indices(), blocks.indices() + blocks.stored()), valid);
  int rows = 0;
  Eigen::Matrix<double, 1, 6> largest = Eigen::Matrix<double, 1, 6>::Zero();
  for (std::size_t j = 0; j < valid.size(); ++j) {
    ASSERT_EQ(blocks.place(valid[j]), j);
    rows = std::max(rows, static_cast<int>(slots[valid[j]]->rows()));
  }
  ASSERT_EQ(blocks.rows(), rows);
  for (std::size_t i = 0; i < slots.size(); ++i) {
    ASSERT_EQ(blocks.is_valid(i), slots[i].has_value()) << i;
    ASSERT_EQ(blocks.validity()[i], slots[i] ? 1 : 0);
    if (!slots[i]) continue;
    Block padded = Block::Zero(rows, 6);
    padded.topRows(slots[i]->rows()) = rounded(*slots[i]);
    ASSERT_EQ(stored_block(blocks, i), padded) << i;
    largest = largest.cwiseMax(padded.cwiseAbs().colwise().maxCoeff());
  }
  for (int column = 0; column < 6; ++column) ASSERT_EQ(blocks.column_max()[column], largest(column));
}

// Matches of a random frame, some without a block, as random options make them: appended to both.
void append_matches(Random& random, BlockStore& blocks, Slots& slots) {
  const std::size_t n = static_cast<std::size_t>(random.integer(0, 40));
  sim::Frame frame = make_scene(sim::Scene::euroc_like, n, random.seed() + blocks.size());
  const std::vector<unsigned char> usable = spoil(random, random.uniform(0, 1), frame);
  const sim::MatchArrays arrays(frame);
  Matches matches = arrays.view();
  matches.usable = usable.data();
  const BlockKind& kind = block_kinds[random.integer(0, static_cast<int>(std::size(block_kinds)) - 1)];
  BlockOptions options;
  options.weighting = kind.weighting;
  options.third = kind.third;
  BlockStore alone;
  append_blocks(frame.camera, frame.T_cw_prior.data(), matches, options, alone);
  const BlockReport report = append_blocks(frame.camera, frame.T_cw_prior.data(), matches, options, blocks);
  EXPECT_EQ(report.invalid, alone.invalid_count());
  const std::vector<std::uint32_t> listed(alone.indices(), alone.indices() + alone.stored());
  for (std::uint32_t i = 0; i < n; ++i) {
    slots.emplace_back();
    if (!std::binary_search(listed.begin(), listed.end(), i)) continue;
    slots.back() = stored_block(alone, i);
  }
}

// One change of a store, and the same of the model.
void change(Random& random, BlockStore& blocks, Slots& slots) {
  switch (random.integer(0, 9)) {
    case 0: {
      const BlockStore copy = blocks;
      expect_holds(copy, slots);
      EXPECT_EQ(copy.capacity(), blocks.size());
      blocks = copy;
      break;
    }
    case 1: {
      BlockStore moved = std::move(blocks);
      expect_holds(moved, slots);
      expect_holds(blocks, {});  // NOLINT(bugprone-use-after-move,clang-analyzer-cplusplus.Move)
      EXPECT_EQ(blocks.capacity(), 0U);
      blocks = std::move(moved);
      break;
    }
    case 2: blocks.reserve(blocks.size() + static_cast<std::size_t>(random.integer(0, 200))); break;
    case 3:
      if (!random.chance(0.2)) break;
      blocks.clear();
      slots.clear();
      break;
    case 4:
    case 5: append_matches(random, blocks, slots); break;
    default:
      for (int i = random.integer(1, 30); i > 0; --i) push_back_random(random, blocks, slots);
  }
}

TEST(EmptySlots, indices_and_places_are_right_after_any_change) {
  for (std::uint64_t variation = 0; variation < trials(100); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    BlockStore blocks;
    Slots slots;
    for (int step = 0; step < 40; ++step) {
      change(random, blocks, slots);
      expect_holds(blocks, slots);
      if (HasFailure()) return;
    }
  }
}

// Blocks of two rows, of three, and candidates pushed between them.
TEST(EmptySlots, blocks_of_different_rows_are_appended_one_after_the_other) {
  for (std::uint64_t variation = 0; variation < trials(100); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    BlockStore blocks;
    Slots slots;
    for (int step = 0; step < 6; ++step) {
      append_matches(random, blocks, slots);
      expect_holds(blocks, slots);
      if (HasFailure()) return;
      if (random.chance(0.5)) push_back_random(random, blocks, slots);
    }
  }
}

TEST(EmptySlots, more_candidates_than_indices_are_refused) {
  constexpr std::size_t most = std::numeric_limits<std::uint32_t>::max();
  Random random;
  BlockStore blocks;
  const Block block = random_block(random, 2);
  push_back(blocks, block);
  for (const std::size_t capacity : {most + 1, 2 * most, std::numeric_limits<std::size_t>::max()}) {
    EXPECT_THROW(blocks.reserve(capacity), std::bad_alloc) << capacity;
    EXPECT_THROW(BlockStore{capacity}, std::bad_alloc) << capacity;
  }
  expect_holds(blocks, {block});
  EXPECT_EQ(blocks.capacity(), 64U);
}

}  // namespace
}  // namespace maxlogdet::test
