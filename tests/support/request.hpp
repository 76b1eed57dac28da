// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/information/factor.hpp"
#include "tests/support/support.hpp"

#include <maxlogdet/block_store.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <ostream>
#include <string>
#include <type_traits>
#include <vector>

// Stores of candidates of every sort, requests for some of them, and answers.

namespace maxlogdet::test {

/// The n blocks that make(i) returns.
template <class Make>
BlockStore store_of(std::size_t n, const Make& make) {
  static_assert(std::is_same<decltype(make(n)), Block>::value, "an expression might refer to what is gone");
  BlockStore blocks;
  for (std::size_t i = 0; i < n; ++i) push_back(blocks, make(i));
  return blocks;
}

inline BlockStore copies_of(const Block& block, std::size_t n) {
  return store_of(n, [&](std::size_t) { return block; });
}

/// Blocks of `rows` rows, or of 1 to 3, with entries uniform in [-scale, scale].
BlockStore random_store(Random& random, std::size_t n, double scale = 1, int rows = 0);

/// Blocks of any size that leave directions unobserved or nearly so: the information has a condition number of up to
/// 1e30, and its sum in float64 is singular, so that it is computed row by row.
BlockStore ill_conditioned_blocks(Random& random, std::size_t n);

/// The blocks times `scale`; a share of them becomes invalid.
BlockStore scaled(Random& random, const BlockStore& blocks, double scale, double invalid_share = 0);

/// The valid candidates of a store, by their rows alone: the new store does not know that append_blocks built them.
/// Invalid ones are kept.
BlockStore pushed(const BlockStore& blocks);

/// Of 2 rows, of 3 rows that append_blocks built or that were pushed, or awkward: copies, zeros, a direction that none
/// observes, some that float32 cannot hold, which are invalid.
BlockStore any_blocks(Random& random, std::size_t n);

constexpr DepthCue thirds[] = {DepthCue::none, DepthCue::stereo, DepthCue::depth};
inline std::string name_of(DepthCue depth_cue) { return "third " + std::to_string(static_cast<int>(depth_cue)); }

const RigidTransform identity_pose = RigidTransform::identity();

constexpr std::size_t BlockReport::*counts_of_report[] = {&BlockReport::appended, &BlockReport::invalid,
                                                          &BlockReport::unusable, &BlockReport::behind_camera,
                                                          &BlockReport::invalid_covariances};

/// Whether the library found the same matches invalid, for the same reasons.
inline void expect_same(const BlockReport& actual, const BlockReport& expected) {
  EXPECT_EQ(actual.error, expected.error) << to_string(actual.error) << " instead of " << to_string(expected.error);
  for (const auto& count : counts_of_report) EXPECT_EQ(actual.*count, expected.*count) << &count - counts_of_report;
}

/// All that a store says of its candidates, byte by byte.
inline std::vector<unsigned char> bytes_of(const BlockStore& blocks) {
  std::vector<unsigned char> bytes(blocks.validity(), blocks.validity() + blocks.size());
  const auto append = [&](const void* data, std::size_t size) {
    const auto* const first = static_cast<const unsigned char*>(data);
    bytes.insert(bytes.end(), first, first + size);
  };
  for (std::size_t plane = 0; plane < 6 * static_cast<std::size_t>(blocks.rows()); ++plane)
    append(blocks.planes() + plane * blocks.stride(), blocks.size() * sizeof(float));
  append(blocks.column_max(), 6 * sizeof(double));
  return bytes;
}

/// The library's factor of an information; and with a block more.
InformationFactor factor_of(const Matrix6& information);
void add(InformationFactor& factor, const Block& block);

/// Options with the arrays that they point to, each of which may be empty: then it is not given.
struct Request {
  std::vector<unsigned char> required;
  std::vector<std::uint32_t> groups;
  std::vector<double> prior;
  Options plain;  ///< all but the arrays

  Options options() const;
  Options options(Strategy strategy) const;

  void set_prior(const Matrix6& information);

  bool is_required(std::size_t i) const { return !required.empty() && required[i] != 0; }
  std::size_t required_count() const;
  /// The group of candidate i, and how many of a group may be selected; all are in one group if there are no groups.
  std::uint32_t group_of(std::size_t i) const { return groups.empty() ? 0 : groups[i]; }
  std::size_t room() const;
};

/// Candidates, and a request for some of them.
struct Problem : Request {
  BlockStore blocks;

  /// The capacity that a selector needs for it.
  std::size_t capacity() const;
  /// The prior that it starts from.
  Matrix6 information() const;
  /// Whether a strategy may choose it: valid, not required.
  bool is_free(std::size_t i) const { return blocks.is_valid(i) && !is_required(i); }
};

/// Without any constraint.
Problem problem_of(BlockStore blocks, std::size_t budget);

/// Gives it any subset of the constraints, such that there is an answer, and any budget.
void constrain(Random& random, Problem& problem, double share_with_groups = 0.5);

/// Up to `max_size` candidates, some of which may be invalid, with any prior and constraints. Groups may be numbered as
/// objects or the cells of a fine grid are, beyond the selector's capacity.
Problem any_problem(Random& random, std::size_t max_size);

/// Expects what holds of any answer, whatever the strategy: distinct valid candidates, the required ones among them; as
/// many as budget and groups allow, and no more; a status that fits; gains and log det as computed
/// in long double, to `tolerance` nats; and no upper bound below log det.
void expect_sound(const Problem& problem, const Selection& selection, double tolerance = 1e-7);

/// What a selection says, kept beyond the next selection. Two are equal if all of it is, bit for bit, but for the
/// costs, which may differ between instruction sets.
struct Answer {
  Answer(const Selection& selection)  // NOLINT(google-explicit-constructor): compared as if it were one
      : reason(selection.reason()),
        status(selection.status),
        error(selection.error),
        indices(indices_of(selection)),
        searched(selection.searched),
        evaluations(selection.evaluations),
        float64_decisions(selection.float64_decisions),
        gains(selection.gains, selection.gains + selection.size),
        log_det(selection.log_det),
        upper_bound(selection.upper_bound) {
    for (std::size_t j = 0; j < selection.size; ++j) numbers.push_back(bits_of(selection.gains[j]));
    for (const double number : {selection.log_det, selection.upper_bound, selection.efficiency}) {
      numbers.push_back(bits_of(number));
    }
  }

  std::string reason;
  Status status;
  Error error;
  std::vector<std::uint32_t> indices;
  std::size_t searched, evaluations, float64_decisions;
  std::vector<double> gains;
  double log_det, upper_bound;
  std::vector<std::uint64_t> numbers;  ///< the bits of gains, log det, upper bound and efficiency
};

/// By a selector of its own, of just enough capacity.
inline Answer answer_to(const BlockStore& blocks, const Options& options, Executor* executor = nullptr) {
  Selector selector(std::max(blocks.size(), options.budget), executor);
  return selector.select(blocks, options);
}

inline bool operator==(const Answer& a, const Answer& b) {
  return a.reason == b.reason && a.indices == b.indices && a.searched == b.searched && a.numbers == b.numbers;
}

inline void PrintTo(const Answer& answer, std::ostream* out) {
  *out << answer.reason << ", of " << answer.searched << " searched:";
  for (const std::uint32_t i : answer.indices) *out << ' ' << i;
  *out << "; bits";
  for (const std::uint64_t bits : answer.numbers) *out << ' ' << bits;
}

}  // namespace maxlogdet::test
