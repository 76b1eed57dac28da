// SPDX-License-Identifier: MIT
// Every strategy and its bound against the true optimum, by trying every subset of up to 16 candidates.
//
// MAXLOGDET_EXHAUSTIVE_CSV names a file that the test appends to: a line for each instance, budget and answer, how far
// it is from the optimum. bench/run how_good makes the tables of docs/trust.md from it.
#include "tests/support/request.hpp"
#include "tests/support/stores.hpp"
#include "tests/support/triangle.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

namespace maxlogdet::test {
namespace {

constexpr int max_candidates = 16;
constexpr long double enumeration_error = 1e-10L;  // of a log det in long double, nats; real ones are 1e-15

enum class Family {
  random,           // 1, 2 or 3 rows, in any direction
  duplicated,       // copies of a few, one of them perhaps zero
  nearly_singular,  // all rows in a few directions, but for 1e-7 to 1e-2 of their length
  far,              // image points 100 m to 10 km away: translation columns tiny against rotation ones
  clustered,        // around a few, 1e-3 to 0.3 of their length apart
  mixed             // 1 to 3 rows in one store, some zero, duplicated, nearly parallel, a thousand times as long
};

constexpr Family families[] = {Family::random, Family::duplicated, Family::nearly_singular,
                               Family::far,    Family::clustered,  Family::mixed};

constexpr const char* family_names[] = {"random", "duplicated", "nearly_singular", "far", "clustered", "mixed"};
const char* to_string(Family family) { return family_names[static_cast<int>(family)]; }

std::vector<Block> some_blocks(Random& random, int max_count, int rows) {
  std::vector<Block> blocks;
  for (int i = random.integer(1, max_count); i > 0; --i) blocks.push_back(random_block(random, rows));
  return blocks;
}

const Block& one_of(Random& random, const std::vector<Block>& blocks) { return blocks[random.index(blocks.size())]; }

BlockStore far_blocks(Random& random, int n) {
  std::vector<double> points;
  for (int i = 0; i < n; ++i) {
    const double depth = std::pow(10.0, random.uniform(2, 4));
    for (const double slope : {random.uniform(-0.8, 0.8), random.uniform(-0.5, 0.5), 1.0}) {
      points.push_back(depth * slope);
    }
  }
  PinholeCamera camera;
  camera.fx = camera.fy = 450;
  camera.bf = 50;
  Matches matches;
  matches.size = static_cast<std::size_t>(n);
  matches.points = points.data();
  BlockOptions options;
  options.weighting = Weighting::measurement;
  options.depth_cue = random.chance(0.5) ? DepthCue::stereo : DepthCue::none;
  BlockStore blocks;
  EXPECT_EQ(append_blocks(camera, RigidTransform::identity(), matches, options, blocks).invalid, 0U);
  return blocks;
}

BlockStore blocks_of(Family family, Random& random, int n) {
  if (family == Family::far) return far_blocks(random, n);
  if (family == Family::mixed) return awkward_blocks(random, static_cast<std::size_t>(n));
  const int rows = random.integer(1, 3);
  const double scale = std::pow(10.0, random.uniform(-2, 2));
  const std::vector<Block> centres = some_blocks(random, family == Family::clustered ? 4 : std::max(1, n / 2), rows);
  const Block directions = random_block(random, random.integer(2, 5));
  const double distance = std::pow(10.0, random.uniform(-3, -0.5));
  const double off = std::pow(10.0, random.uniform(-7, -2));
  return store_of(static_cast<std::size_t>(n), [&](std::size_t) {
    Block block = random_block(random, rows);
    if (family == Family::duplicated) block = random.chance(0.05) ? Block::Zero(rows, 6) : one_of(random, centres);
    if (family == Family::clustered) block = one_of(random, centres) + distance * block;
    if (family == Family::nearly_singular) {
      block = random_block(random, rows).leftCols(directions.rows()) * directions + off * block;
    }
    return Block(block * scale);
  });
}

Options asking(const Problem& problem, std::size_t budget, Strategy strategy) {
  Options options = problem.options(strategy);
  options.budget = budget;
  return options;
}

Problem random_instance(Family family, Random& random, int n) {
  Problem instance = problem_of(blocks_of(family, random, n), 0);
  instance.required.resize(instance.blocks.size());
  const bool is_constrained = random.chance(0.2);
  for (std::size_t i = 0; i < instance.blocks.size() && is_constrained; ++i) {
    instance.required[i] = random.chance(0.1) ? 1 : 0;
  }
  if (random.chance(0.5)) instance.set_prior(std::pow(10.0, random.uniform(-3, 3)) * random_prior(random));
  return instance;
}

// One instance in sixteen is large; these are nearly all of the work.
int random_size(Random& random, std::uint64_t variation) {
  return variation % 16 == 0 ? random.integer(14, max_candidates) : random.integer(1, 12);
}

// The optimum for every budget at once, by a walk over all subsets of the free candidates.
class AllSubsets {
 public:
  explicit AllSubsets(const Problem& instance) : required_(instance.required_count()) {
    Triangle base(instance.information());  // gains are counted from prior and required candidates
    for (std::size_t i = 0; i < instance.blocks.size(); ++i) {
      const Block block = stored_block(instance.blocks, i);
      if (instance.is_required(i)) base.add(block);
      if (!instance.is_free(i)) continue;
      Rows rows{};
      for (int row = 0; row < block.rows(); ++row) {
        if (block.row(row).isZero(0)) continue;
        for (int d = 0; d < state_dimension; ++d) rows.entry[rows.count][d] = block(row, d);
        ++rows.count;
      }
      blocks_.push_back(rows);
    }
    best_.assign(blocks_.size() + 1, 0);
    base_ = base.log_det();
    descend(base, 0, 0);
  }

  std::size_t min_budget() const { return required_; }
  std::size_t max_budget() const { return required_ + blocks_.size(); }
  std::size_t subsets() const { return subsets_; }
  // log det of the base, and of the optimum for a budget, nats.
  long double base() const { return base_; }
  long double optimum(std::size_t budget) const { return 2 * std::log(best_[budget - required_]); }

 private:
  struct Rows {
    int count;
    long double entry[max_block_rows][state_dimension];
  };

  void descend(const Triangle& triangle, std::size_t first, std::size_t size) {
    ++subsets_;
    best_[size] = std::max(best_[size], triangle.volume());
    for (std::size_t i = first; i < blocks_.size(); ++i) {
      Triangle with_i = triangle;
      for (int row = 0; row < blocks_[i].count; ++row) with_i.add_row(blocks_[i].entry[row]);
      descend(with_i, i + 1, size + 1);
    }
  }

  std::vector<Rows> blocks_;
  std::vector<long double> best_;  // sqrt(det), by how many of the free ones are in
  std::size_t required_;
  std::size_t subsets_ = 0;
  long double base_ = 0;
};

// Appends to the file that MAXLOGDET_EXHAUSTIVE_CSV names, if it names one.
class Csv {
 public:
  Csv() {
    const char* const name = std::getenv("MAXLOGDET_EXHAUSTIVE_CSV");
    if (name == nullptr) return;
    file_.open(name, std::ios::app);
    EXPECT_TRUE(file_.is_open()) << "cannot write " << name;
    file_.seekp(0, std::ios::end);
    if (file_.tellp() == 0) file_ << "family,prior,n,k,answer,share_of_optimum,distance_nats\n";
  }
  // `distance`: optimum less the answer's log det, or bound less optimum, nats.
  void write(Family family, const Problem& instance, std::size_t budget, const std::string& answer, long double share,
             long double distance) {
    if (!file_.is_open()) return;
    file_ << to_string(family) << ',' << (instance.prior.empty() ? "default" : "own") << ',' << instance.blocks.size()
          << ',' << budget << ',' << answer << ',' << static_cast<double>(share) << ',' << static_cast<double>(distance)
          << '\n';
  }

 private:
  std::ofstream file_;
};

long double log_det(const Problem& instance, const std::vector<std::uint32_t>& indices) {
  Triangle triangle(instance.information());
  for (const std::uint32_t index : indices) triangle.add(stored_block(instance.blocks, index));
  return triangle.log_det();
}

// Greedy's guarantee for k rounds, 1 - (1 - 1/k)^k, which falls to 1 - 1/e.
long double guarantee(std::size_t rounds) {
  if (rounds == 0) return 1;
  const auto k = static_cast<long double>(rounds);
  return 1 - std::pow(1 - 1 / k, k);
}

class Exhaustive : public ::testing::TestWithParam<Family> {
 protected:
  // log det of an answer, which must be a selection of that budget, keep to constraints and not beat the optimum.
  long double checked_log_det(const Problem& instance, const AllSubsets& all, const Options& options) {
    const Selection selection = selector_.select(instance.blocks, options);
    EXPECT_TRUE(selection.has_answer()) << to_string(selection.status);
    EXPECT_EQ(selection.size, options.budget);
    std::vector<int> taken(instance.blocks.size());
    for (const std::uint32_t index : selection) {
      EXPECT_LT(index, taken.size());
      if (index >= taken.size()) return 0;
      EXPECT_EQ(taken[index]++, 0) << index << " twice";
    }
    for (std::size_t i = 0; i < taken.size(); ++i) EXPECT_TRUE(!instance.is_required(i) || taken[i] == 1);
    indices_ = indices_of(selection);
    upper_bound_ = selection.upper_bound;
    const long double result = log_det(instance, indices_);
    EXPECT_LE(result, all.optimum(options.budget) + enumeration_error) << "better than the best of all subsets";
    return result;
  }

  void check(const Problem& instance, const AllSubsets& all, std::size_t budget, std::uint64_t variation) {
    check_strategies(instance, all, budget, variation);
    check_bound(instance, all, budget);
  }

  // Whether there is a choice: only these budgets are counted.
  static bool is_choice(const AllSubsets& all, std::size_t budget) {
    return budget > all.min_budget() && budget < all.max_budget();
  }

  // The share of the optimum's gain.
  static long double share(const AllSubsets& all, std::size_t budget, long double reached) {
    const long double max_gain = all.optimum(budget) - all.base();
    return max_gain > 0 ? (reached - all.base()) / max_gain : 1;
  }

  void record(const Problem& instance, const AllSubsets& all, std::size_t budget, const std::string& answer,
              long double reached) {
    if (!is_choice(all, budget)) return;
    csv_.write(GetParam(), instance, budget, answer, share(all, budget, reached), all.optimum(budget) - reached);
  }

  void check_strategies(const Problem& instance, const AllSubsets& all, std::size_t budget, std::uint64_t variation) {
    std::vector<std::uint32_t> indices_of_greedy;
    for (const Strategy strategy : strategies) {
      SCOPED_TRACE(to_string(strategy));
      Options options = asking(instance, budget, strategy);
      options.stochastic.seed = variation;
      const long double reached = checked_log_det(instance, all, options);
      record(instance, all, budget, to_string(strategy), reached);
      if (strategy == Strategy::greedy) {
        indices_of_greedy = indices_;
        check_greedy(all, budget, reached);
      }
      if (strategy == Strategy::lazy_greedy) {
        EXPECT_EQ(indices_, indices_of_greedy);
      }
    }
  }

  void check_greedy(const AllSubsets& all, std::size_t budget, long double reached) {
    const long double optimum = all.optimum(budget);
    const long double guaranteed = guarantee(budget - all.min_budget()) * (optimum - all.base());
    EXPECT_GE(reached - all.base(), guaranteed - enumeration_error);
    if (!is_choice(all, budget)) return;
    worst_ = std::min(worst_, share(all, budget, reached));
    optimal_ += reached > optimum - enumeration_error ? 1 : 0;
    ++choices_;
  }

  void check_bound(const Problem& instance, const AllSubsets& all, std::size_t budget) {
    Options options = asking(instance, budget, Strategy::lazy_greedy);
    options.certificate = true;
    checked_log_det(instance, all, options);
    EXPECT_GE(upper_bound_, all.optimum(budget) - enumeration_error) << "a false bound";
    if (is_choice(all, budget)) {
      csv_.write(GetParam(), instance, budget, "upper_bound", 0, upper_bound_ - all.optimum(budget));
    }
  }

  Selector selector_{max_candidates};
  std::vector<std::uint32_t> indices_;  // of the last answer
  double upper_bound_ = 0;              // of the last answer
  Csv csv_;
  long double worst_ = 1;  // greedy's share of the optimum
  std::size_t optimal_ = 0, choices_ = 0;
};

TEST_P(Exhaustive, answers_keep_their_guarantees_and_bounds_are_above_the_optimum) {
  const std::size_t instances = trials(800);
  std::size_t subsets = 0;
  for (std::uint64_t variation = 0; variation < instances; ++variation) {
    Random random(variation);
    const Problem instance = random_instance(GetParam(), random, random_size(random, variation));
    const AllSubsets all(instance);
    subsets += all.subsets();
    for (std::size_t budget = all.min_budget(); budget <= all.max_budget(); ++budget) {
      SCOPED_TRACE(random.name() + ", budget " + std::to_string(budget));
      check(instance, all, budget, variation);
      if (HasFailure()) return;
    }
  }
  std::printf("%zu instances, %zu subsets; greedy optimal in %zu of %zu, worst share of the optimum %.4f\n", instances,
              subsets, optimal_, choices_, static_cast<double>(worst_));
}

TEST_P(Exhaustive, mean_of_stochastic_greedy_keeps_its_guarantee) {
  constexpr int seeds = 100;
  for (const double epsilon : {0.01, 0.1, 0.3}) {
    for (std::uint64_t variation = 0; variation < trials(40); ++variation) {
      Random random(variation);
      const Problem instance = random_instance(GetParam(), random, random.integer(1, 14));
      const AllSubsets all(instance);
      for (std::size_t budget = all.min_budget() + 1; budget < all.max_budget(); ++budget) {
        SCOPED_TRACE(random.name() + ", epsilon " + std::to_string(epsilon) + ", budget " + std::to_string(budget));
        Options options = asking(instance, budget, Strategy::stochastic_greedy);
        options.stochastic.epsilon = epsilon;
        long double mean = 0;
        for (int seed = 0; seed < seeds; ++seed) {
          options.stochastic.seed = static_cast<std::uint64_t>(seed);
          const Selection selection = selector_.select(instance.blocks, options);
          ASSERT_EQ(selection.size, budget);
          mean += (selection.log_det - all.base()) / seeds;
        }
        const long double max_gain = all.optimum(budget) - all.base();
        ASSERT_GE(mean, (guarantee(budget - all.min_budget()) - epsilon) * max_gain - 1e-9L);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(, Exhaustive, ::testing::ValuesIn(families),
                         [](const auto& parameter) { return std::string(to_string(parameter.param)); });

}  // namespace
}  // namespace maxlogdet::test
