// SPDX-License-Identifier: MIT
#include "tests/core/slots.hpp"

#include "tests/support/answer.hpp"
#include "tests/support/numbers.hpp"
#include "tests/support/stores.hpp"

#include <algorithm>
#include <array>

namespace maxlogdet::test {
namespace {

// How a selection ended: an empty store gives ok, one whose candidates are all invalid all_selected.
void expect_same_end(const Selection& actual, const Selection& expected, bool has_candidates, std::size_t budget) {
  const bool differ = !has_candidates && budget > 0 && expected.status == Status::ok;
  EXPECT_EQ(actual.status, differ ? Status::all_selected : expected.status);
}

// The same but for indices, of which `kept` says what they are in the store with more candidates.
void expect_same_answer(const Selection& actual, const Selection& expected, const std::vector<std::uint32_t>& kept) {
  EXPECT_EQ(indices_of(actual), gathered(kept, indices_of(expected)));
  EXPECT_EQ(Answer(actual).numbers, Answer(expected).numbers);
  EXPECT_EQ(actual.threads, expected.threads);
}

// To the other side of the camera.
void mirror(const std::array<double, 12>& T_cw, double* point) {
  for (std::size_t d = 0; d < 3; ++d) {
    const double camera = -(T_cw[d] * T_cw[3] + T_cw[4 + d] * T_cw[7] + T_cw[8 + d] * T_cw[11]);
    point[d] = 2 * camera - point[d];
  }
}

}  // namespace

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

Slots with_empty_slots(Random& random, const std::vector<Block>& blocks, double share) {
  Slots slots;
  for (const Block& block : blocks) {
    while (random.chance(share)) slots.emplace_back();
    slots.emplace_back(block);
  }
  while (random.chance(share)) slots.emplace_back();
  return slots;
}

std::size_t push_back_empty(Random& random, BlockStore& blocks) {
  double entries[18] = {};
  const double broken[] = {nan, infinity, 1e39, -1e300};
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

Request request_of(const Request& request, const std::vector<std::uint32_t>& indices) {
  Request result = request;
  result.required = gathered(request.required, indices);
  result.groups = gathered(request.groups, indices);
  return result;
}

Request random_request(Random& random, const BlockStore& blocks) {
  Problem problem = problem_of(blocks, 0);
  constrain(random, problem, random.chance(0.3));
  if (random.chance(0.5)) problem.set_prior(random_prior(random));
  const std::size_t required = problem.required_count();
  problem.plain.budget = required + random.index(blocks.stored() - required + 3);
  problem.plain.stochastic.seed = random.seed();
  problem.plain.stochastic.epsilon = random.uniform(0.01, 0.9);
  problem.plain.certificate = random.chance(0.5);
  return static_cast<const Request&>(problem);
}

void expect_same_answers(const BlockStore& whole, const Request& request, const BlockStore& dense,
                         const std::vector<std::uint32_t>& kept) {
  const Request of_dense = request_of(request, kept);
  Selector selector(std::max(whole.size(), request.plain.budget));
  Selector dense_selector(std::max(dense.size(), request.plain.budget));
  for (const Strategy strategy : strategies) {
    SCOPED_TRACE(to_string(strategy));
    const Selection expected = dense_selector.select(dense, of_dense.options(strategy));
    const Selection actual = selector.select(whole, request.options(strategy));
    expect_same_end(actual, expected, dense.size() > 0, request.plain.budget);
    expect_same_answer(actual, expected, kept);
    EXPECT_EQ(actual.evaluations, expected.evaluations);
    EXPECT_EQ(actual.float64_decisions, expected.float64_decisions);
    EXPECT_EQ(actual.invalid_candidates, whole.invalid_count());
  }
}

std::vector<unsigned char> spoil(Random& random, double share, sim::Frame& frame) {
  std::vector<unsigned char> usable(frame.matches.size(), 1);
  for (std::size_t i = 0; i < frame.matches.size(); ++i) {
    if (!random.chance(share)) continue;
    sim::Match& match = frame.matches[i];
    switch (random.integer(0, 3)) {
      case 0: match.point[random.integer(0, 2)] = nan; break;
      case 1: match.inv_sigma2 = random.chance(0.5) ? nan : -1; break;
      case 2: mirror(frame.T_cw_prior, match.point); break;
      default: usable[i] = 0;
    }
  }
  return usable;
}

BlockReport append(const sim::Frame& frame, const std::vector<unsigned char>& usable, const BlockKind& kind,
                   BlockStore& blocks) {
  const sim::MatchArrays arrays(frame);
  Matches matches = arrays.view();
  matches.usable = usable.data();
  BlockOptions options;
  options.weighting = kind.weighting;
  options.depth_cue = kind.depth_cue;
  const RigidTransform T_cw = RigidTransform::row_major(frame.T_cw_prior.data());
  return append_blocks(frame.camera, T_cw, matches, options, blocks);
}

}  // namespace maxlogdet::test
