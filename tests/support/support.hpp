// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/names.hpp"
#include "bench/world/scene.hpp"
#include "kernel/base/counter_random.hpp"
#include "simd/kernel.hpp"
#include "tests/support/processor.hpp"

#include <gtest/gtest.h>
#include <maxlogdet/eigen.hpp>
#include <maxlogdet/maxlogdet.hpp>

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <ostream>
#include <string>
#include <vector>

namespace maxlogdet {

/// How GoogleTest prints them.
inline void PrintTo(Strategy strategy, std::ostream* out) { *out << to_string(strategy); }
inline void PrintTo(Status status, std::ostream* out) { *out << to_string(status); }

}  // namespace maxlogdet

namespace maxlogdet::test {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double unit_roundoff = 0x1p-53;  // of float64

/// 95 % of chi-squared with two and three degrees of freedom.
constexpr double chi2_of_two = 5.991;
constexpr double chi2_of_three = 7.815;

inline std::uint64_t bits_of(double value) {
  std::uint64_t bits = 0;
  std::memcpy(&bits, &value, sizeof bits);
  return bits;
}

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

/// Random numbers of this test, whose seed every failure prints while they exist.
class TracedRandom : public Random {
 public:
  using Random::Random;

 private:
  ::testing::ScopedTrace trace_{__FILE__, __LINE__, name()};
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

/// Calls body(random) with trials(count) variations of the test's seed, under a trace that names it, until one fails.
template <class Body>
void for_each_trial(std::size_t count, const Body& body) {
  for (std::uint64_t variation = 0; variation < trials(count); ++variation) {
    TracedRandom random(variation);
    body(random);
    if (::testing::Test::HasFailure()) return;
  }
}

/// Expects function() to return the same on every instruction set, and returns it.
template <class Function>
auto same_on_every_isa(const Function& function) {
  const ForcedIsa forced(sim::supported_isas().front().c_str());
  const auto expected = function();
  for (const std::string& isa : sim::supported_isas()) {
    const ForcedIsa each(isa.c_str());
    EXPECT_EQ(function(), expected) << isa;
  }
  return expected;
}

/// Folder of real data, or an empty string; environment MAXLOGDET_DATA overrides the default place.
std::string data_folder();

/// The kinds of blocks that tests over real and synthetic frames go through.
struct BlockKind {
  const char* name;
  DepthCue depth_cue;
  bool has_covariances;
};
constexpr BlockKind block_kinds[] = {{"monocular", DepthCue::none, false},
                                     {"stereo", DepthCue::stereo, false},
                                     {"monocular with covariances", DepthCue::none, true},
                                     {"stereo with covariances", DepthCue::stereo, true}};
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

/// Calls body(blocks) with every kind of block of a frame that the sample takes, under a trace that names them.
template <class Body>
void for_every_kind(const sim::Frame& frame, Sample& sample, const Body& body) {
  for (const BlockKind& kind : block_kinds) {
    if (!sample.takes_next()) continue;
    SCOPED_TRACE(frame.name + " " + kind.name);
    body(blocks_of(frame, kind));
  }
}

/// The same with n candidates of every scene.
template <class Body>
void for_every_family(std::size_t n, const Body& body) {
  Sample sample(4);
  for (const sim::Scene scene : sim::scenes) for_every_kind(make_scene(scene, n, Random().seed()), sample, body);
}

constexpr char no_real_frames[] = "no real frames here; MAXLOGDET_DATA names their folder";
/// data_folder() must not be empty.
std::vector<sim::Frame> real_frames();

/// The same with every real frame.
template <class Body>
void for_real_frames(const Body& body) {
  Sample sample(20);
  for (const sim::Frame& frame : real_frames()) for_every_kind(frame, sample, body);
}

// The linear algebra of oracles, compiled once: a test that instantiates a decomposition or a large product itself
// takes seconds longer to compile for each.

using Vector6 = Eigen::Matrix<double, state_dimension, 1>;
using WideMatrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
using WideMatrix6 = Eigen::Matrix<long double, state_dimension, state_dimension>;
using WideVector6 = Eigen::Matrix<long double, state_dimension, 1>;

/// A B.
Eigen::MatrixXd product(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);
WideMatrix wide_product(const WideMatrix& a, const WideMatrix& b);

/// A^T A: the information of stacked rows.
Eigen::MatrixXd gram(const Eigen::MatrixXd& a);
WideMatrix wide_gram(const WideMatrix& a);

/// The inverse, by LU with pivoting.
Eigen::MatrixXd inverse(const Eigen::MatrixXd& a);
WideMatrix wide_inverse(const WideMatrix& a);

/// L, lower triangular, of a symmetric positive definite S = L L^T; not finite where S is not.
Eigen::MatrixXd cholesky(const Eigen::MatrixXd& s);

/// |A - B| / |B|, Frobenius.
inline double relative_difference(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return (a - b).norm() / b.norm();
}

/// The largest |entry| of A, and of A - B.
inline double largest_entry(const Eigen::MatrixXd& a) { return a.cwiseAbs().maxCoeff(); }
inline double largest_difference(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) { return largest_entry(a - b); }

/// The log determinant of a symmetric positive definite matrix.
double log_det(const Eigen::MatrixXd& s);

/// The eigenvalues of a symmetric matrix in ascending order.
Vector6 eigenvalues(const Matrix6& s);
WideVector6 wide_eigenvalues(const WideMatrix6& s);

/// The singular values in descending order.
Eigen::VectorXd singular_values(const Eigen::MatrixXd& a);

/// Eigenvalues of a symmetric matrix in ascending order, and their eigenvectors of length 1, as columns.
struct Spectrum4 {
  Eigen::Vector4d values;
  Eigen::Matrix4d vectors;
};
Spectrum4 spectrum(const Eigen::Matrix4d& s);

/// The x that minimises |A x - b| for an A of full column rank, by QR with pivoting.
Eigen::VectorXd solve_least_squares(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);

/// The orthogonal Q of A = Q R P, all its columns: those of the range of A are the first.
Eigen::MatrixXd orthogonal_factor(const Eigen::MatrixXd& a);

}  // namespace maxlogdet::test
