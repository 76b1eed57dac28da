// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/names.hpp"
#include "bench/world/scene.hpp"
#include "kernel/base/counter_random.hpp"
#include "simd/kernel.hpp"
#include "tests/support/block_kinds.hpp"

#include <gtest/gtest.h>
#include <maxlogdet/eigen.hpp>
#include <maxlogdet/maxlogdet.hpp>

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <ostream>
#include <string>
#include <vector>

namespace maxlogdet {

/// How GoogleTest prints them.
inline void PrintTo(Strategy strategy, std::ostream* out) { *out << to_string(strategy); }
inline void PrintTo(Status status, std::ostream* out) { *out << to_string(status); }

}  // namespace maxlogdet

namespace maxlogdet::test {

/// Random numbers that are the same on every machine. The seed derives from the running test's own name, so that no two
/// tests share data, and is printed when an assertion in the same scope fails:  Random random;
/// SCOPED_TRACE(random.name());
class Random {
 public:
  explicit Random(std::uint64_t variation = 0);
  Random(const std::string& name, std::uint64_t variation);

  double uniform(double low, double high);
  int integer(int low, int high);  ///< low <= result <= high
  std::size_t index(std::size_t count) { return static_cast<std::size_t>(integer(0, static_cast<int>(count) - 1)); }
  bool chance(double probability) { return uniform(0, 1) < probability; }
  std::uint64_t seed() const { return seed_; }
  std::string name() const { return "seed " + std::to_string(seed_); }

 private:
  std::uint64_t seed_;
  CounterRandom random_;
};

using Block = Eigen::Matrix<double, Eigen::Dynamic, state_dimension, Eigen::RowMajor>;
using Matrix6 = Eigen::Matrix<double, state_dimension, state_dimension>;

/// Entries uniform in [-scale, scale].
Block random_block(Random& random, int rows, double scale = 1);

/// A well-conditioned symmetric positive definite matrix.
Matrix6 random_prior(Random& random);

/// The block that the store holds for candidate i, exactly, with as many rows as the store has.
Block stored_block(const BlockStore& blocks, std::size_t i);

/// To float32 and back. Not by two casts in a row, which GCC 12 drops at -O3 (docs/numerics.md).
Block rounded(Block block);

/// n blocks of 1 to 3 rows; some duplicated, scaled, zero or nearly parallel to others.
BlockStore awkward_blocks(Random& random, std::size_t n);

/// 17 to 120 copies of a few blocks of scale 10^min_exponent to 10^max_exponent, some moved by one float32 ulp: they
/// differ by as little as rounding.
BlockStore near_copies(Random& random, double min_exponent, double max_exponent);

Options with_budget(std::size_t budget, Strategy strategy = Options().strategy);

/// The indices of an answer; empty for an error.
std::vector<std::uint32_t> indices_of(const Selection& selection);

/// The indices that a selector of just enough capacity selects.
std::vector<std::uint32_t> select_indices(const BlockStore& blocks, const Options& options);

/// The kernels that this machine can run.
std::vector<const simd::Kernel*> supported_kernels();

/// How many of `count` repetitions to run, at least one: all, or the share that the environment variable
/// MAXLOGDET_TEST_SHARE names (0.1, say), for emulators and sanitizers.
std::size_t trials(std::size_t count);

/// Folder of real data, or an empty string; environment MAXLOGDET_DATA overrides the default place.
std::string data_folder();

BlockStore blocks_of(const sim::Frame& frame, const BlockKind& kind);

/// Which of many cases run where only a share does: every `step`-th, from a different one on in each test.
class Sample {
 public:
  explicit Sample(std::size_t max_step) : step_(std::min(max_step, 100 / trials(100))) {}
  bool takes_next() { return (next_++ % step_) == 0; }

 private:
  std::size_t step_;
  std::uint64_t next_ = Random().seed() % step_;
};

/// Calls body(blocks) with n candidates of every scene and every kind of block, under a trace that names them.
template <class Body>
void for_every_family(std::size_t n, const Body& body) {
  Sample sample(4);
  for (const sim::Scene scene : sim::scenes) {
    for (const BlockKind& kind : block_kinds) {
      if (!sample.takes_next()) continue;
      const sim::Frame frame = make_scene(scene, n, Random().seed());
      SCOPED_TRACE(frame.name + " " + kind.name);
      body(blocks_of(frame, kind));
    }
  }
}

/// Calls body(blocks) with n candidates of every scene and kind of block, always the same: recorded answers are about
/// these.
template <class Body>
void for_every_recorded(std::size_t n, const Body& body) {
  constexpr std::uint64_t seed = 7;
  for (const sim::Scene scene : sim::scenes) {
    for (const BlockKind& kind : block_kinds) body(blocks_of(make_scene(scene, n, seed), kind));
  }
}

/// As for_every_family with every `every`-th real frame; data_folder() must not be empty.
constexpr char no_real_frames[] = "no real frames here; MAXLOGDET_DATA names their folder";
std::vector<sim::Frame> real_frames();

template <class Body>
void for_real_frames(std::size_t every, const Body& body) {
  Sample sample(20);
  const std::vector<sim::Frame> frames = real_frames();
  for (std::size_t i = 0; i < frames.size(); i += every) {
    for (const BlockKind& kind : block_kinds) {
      if (!sample.takes_next()) continue;
      SCOPED_TRACE(frames[i].name + " " + kind.name);
      body(blocks_of(frames[i], kind));
    }
  }
}

}  // namespace maxlogdet::test
