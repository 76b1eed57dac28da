// SPDX-License-Identifier: MIT
// Every strategy and its bound against the true optimum, by trying every subset of up to 16 candidates; and bounds
// where there are too many subsets to try.
//
// MAXLOGDET_EXHAUSTIVE_CSV names a file that the test appends to: a line for each instance, budget and answer, how far
// it is from the optimum. bench/run how_good makes the tables of docs/trust.md from it.
#include "tests/support/oracle.hpp"
#include "tests/support/request.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace maxlogdet::test {
namespace {

constexpr int max_candidates = 16;
constexpr long double enumeration_error = 1e-10L;  // of a log det in long double, nats; real ones are 1e-15

using Family = std::string;
const Family families[] = {
    "random",           // 1, 2 or 3 rows, in any direction
    "duplicated",       // copies of a few, one of them perhaps zero
    "nearly_singular",  // all rows in a few directions, but for 1e-7 to 1e-2 of their length
    "far",              // image points 100 m to 10 km away: translation columns tiny against rotation ones
    "clustered",        // around a few, 1e-3 to 0.3 of their length apart
    "mixed"             // 1 to 3 rows in one store, some zero, duplicated, nearly parallel, a thousand times as long
};

BlockStore far_blocks(Random& random, int n) {
  const bool is_stereo = random.chance(0.5);
  std::vector<FeatureMatch> matches;
  for (int i = 0; i < n; ++i) {
    const double depth = std::pow(10.0, random.uniform(2, 4));
    const double p[3] = {depth * random.uniform(-0.8, 0.8), depth * random.uniform(-0.5, 0.5), depth};
    matches.emplace_back(p);
    if (is_stereo) matches.back().u_right = 1;
  }
  BlockStore blocks;
  const Camera camera(450, 450, 0, 0, 50);
  const BlockReport report =
      append_blocks(&camera, 1, RigidTransform::identity(), matches.data(), matches.size(), BlockOptions(), blocks);
  EXPECT_EQ(report.invalid, 0U);
  return blocks;
}

BlockStore blocks_of(const Family& family, Random& random, int n) {
  if (family == "far") return far_blocks(random, n);
  if (family == "mixed") return awkward_blocks(random, static_cast<std::size_t>(n));
  const int rows = random.integer(1, 3);
  const double scale = std::pow(10.0, random.uniform(-2, 2));
  const int most = family == "clustered" ? 4 : std::max(1, n / 2);
  std::vector<Block> centres;
  for (int i = random.integer(1, most); i > 0; --i) centres.push_back(random_block(random, rows));
  const auto one_of_them = [&] { return centres[random.index(centres.size())]; };
  const Block directions = random_block(random, random.integer(2, 5));
  const double distance = std::pow(10.0, random.uniform(-3, -0.5));
  const double off = std::pow(10.0, random.uniform(-7, -2));
  return store_of(static_cast<std::size_t>(n), [&](std::size_t) {
    Block block = random_block(random, rows);
    if (family == "duplicated") block = random.chance(0.05) ? Block::Zero(rows, 6) : one_of_them();
    if (family == "clustered") block = one_of_them() + distance * block;
    if (family == "nearly_singular") {
      block = random_block(random, rows).leftCols(directions.rows()) * directions + off * block;
    }
    return Block(block * scale);
  });
}

Problem random_instance(const Family& family, Random& random, int n) {
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

// Room in groups: chosen candidates leave it to each other, or required ones alone take it, as the certificate has it.
enum class Groups { kept, relaxed };

// The optimum for every budget at once, by a walk over all subsets of up to `max_free` of the free candidates.
class AllSubsets {
 public:
  explicit AllSubsets(const Problem& problem, Groups groups = Groups::kept, std::size_t max_free = max_candidates)
      : problem_(problem), groups_(groups), required_(problem.required_count()) {
    Triangle base(problem.information());  // gains are counted from prior and required candidates
    for (std::size_t i = 0; i < problem.blocks.size(); ++i) {
      blocks_.push_back(stored_block(problem.blocks, i));
      if (problem.is_free(i)) free_.push_back(i);
      if (!problem.is_required(i)) continue;
      base.add(blocks_[i]);
      ++members_[problem.group_of(i)];
    }
    best_.assign(1 + std::min(max_free, free_.size()), 0);
    base_ = base.log_det();
    descend(base, 0, 0);
  }

  std::size_t min_budget() const { return required_; }
  std::size_t max_budget() const { return required_ + best_.size() - 1; }
  // log det of the base, and of the optimum of at most `budget` candidates, nats.
  long double base() const { return base_; }
  long double optimum(std::size_t budget) const {
    const auto end = best_.begin() + static_cast<std::ptrdiff_t>(std::min(budget, max_budget()) - required_ + 1);
    return 2 * std::log(*std::max_element(best_.begin(), end));
  }

 private:
  void descend(const Triangle& triangle, std::size_t first, std::size_t size) {
    best_[size] = std::max(best_[size], triangle.volume());
    if (size + 1 == best_.size()) return;
    for (std::size_t next = first; next < free_.size(); ++next) {
      std::size_t& in_group = members_[problem_.group_of(free_[next])];
      if (in_group >= problem_.room()) continue;
      Triangle with_next = triangle;
      with_next.add(blocks_[free_[next]]);
      const std::size_t before = in_group;
      if (groups_ == Groups::kept) ++in_group;
      descend(with_next, next + 1, size + 1);
      in_group = before;
    }
  }

  const Problem& problem_;
  Groups groups_;
  std::size_t required_;
  std::vector<Block> blocks_;
  std::vector<std::size_t> free_;
  std::map<std::uint32_t, std::size_t> members_;
  std::vector<long double> best_;  // sqrt(det), by how many of the free ones are in
  long double base_ = 0;
};

// Appends a line to the file that MAXLOGDET_EXHAUSTIVE_CSV names, if it names one. `distance`: optimum less the
// answer's log det, or bound less optimum, nats.
void record(const Family& family, const Problem& asked, const char* answer, long double share, long double distance) {
  const char* const name = std::getenv("MAXLOGDET_EXHAUSTIVE_CSV");
  if (name == nullptr) return;
  static std::ofstream file(name, std::ios::app);
  ASSERT_TRUE(file.is_open()) << "cannot write " << name;
  file.seekp(0, std::ios::end);
  if (file.tellp() == 0) file << "family,prior,n,k,answer,share_of_optimum,distance_nats\n";
  file << family << ',' << (asked.prior.empty() ? "default" : "own") << ',' << asked.blocks.size() << ','
       << asked.plain.budget << ',' << answer << ',' << static_cast<double>(share) << ','
       << static_cast<double>(distance) << '\n';
}

// Greedy's guarantee for k rounds, 1 - (1 - 1/k)^k, which falls to 1 - 1/e.
long double guarantee(std::size_t rounds) {
  if (rounds == 0) return 1;
  const auto k = static_cast<long double>(rounds);
  return 1 - std::pow(1 - 1 / k, k);
}

// Every strategy's answer, and its bound.
void expect_guarantees(const Family& family, const Problem& asked, const AllSubsets& all, Selector& selector) {
  const std::size_t budget = asked.plain.budget;
  const long double optimum = all.optimum(budget), max_gain = optimum - all.base();
  const bool is_choice = budget > all.min_budget() && budget < all.max_budget();  // only these are recorded
  std::vector<std::uint32_t> of_greedy;
  for (const Strategy strategy : strategies) {
    SCOPED_TRACE(to_string(strategy));
    const Selection selection = selector.select(asked.blocks, asked.options(strategy));
    EXPECT_EQ(selection.size, budget);
    expect_sound(asked, selection);
    EXPECT_GE(selection.upper_bound, optimum - enumeration_error) << "a false bound";
    const std::vector<std::uint32_t> indices = indices_of(selection);
    const long double reached = log_det_of(asked.blocks, indices, asked.information());
    EXPECT_LE(reached, optimum + enumeration_error) << "better than the best of all subsets";
    const long double share = max_gain > 0 ? (reached - all.base()) / max_gain : 1;
    if (is_choice) record(family, asked, to_string(strategy), share, optimum - reached);
    if (budget == 0) {
      EXPECT_NEAR(selection.upper_bound, selection.log_det, 1e-10) << "the prior";
    }
    if (strategy == Strategy::stochastic_greedy) continue;
    EXPECT_GE(reached - all.base(), guarantee(budget - all.min_budget()) * max_gain - enumeration_error);
    if (strategy == Strategy::greedy) of_greedy = indices;
    EXPECT_EQ(indices, of_greedy);
    if (is_choice && strategy == Strategy::lazy_greedy) {
      record(family, asked, "upper_bound", 0, selection.upper_bound - optimum);
    }
  }
}

class Exhaustive : public ::testing::TestWithParam<Family> {
 protected:
  Selector selector_{max_candidates};
};

TEST_P(Exhaustive, answers_keep_their_guarantees_and_bounds_are_above_the_optimum) {
  for (std::uint64_t variation = 0; variation < trials(800); ++variation) {
    TracedRandom random(variation);
    Problem asked = random_instance(GetParam(), random, random_size(random, variation));
    asked.plain.certificate = true;
    asked.plain.stochastic.seed = variation;
    const AllSubsets all(asked);
    for (std::size_t budget = all.min_budget(); budget <= all.max_budget(); ++budget) {
      SCOPED_TRACE("budget " + std::to_string(budget));
      asked.plain.budget = budget;
      expect_guarantees(GetParam(), asked, all, selector_);
      if (HasFailure()) return;
    }
  }
}

TEST_P(Exhaustive, mean_of_stochastic_greedy_keeps_its_guarantee) {
  constexpr int seeds = 100;
  for (const double epsilon : {0.01, 0.1, 0.3}) {
    for (std::uint64_t variation = 0; variation < trials(40); ++variation) {
      TracedRandom random(variation);
      Problem asked = random_instance(GetParam(), random, random.integer(1, 14));
      asked.plain.stochastic.epsilon = epsilon;
      const AllSubsets all(asked);
      for (std::size_t budget = all.min_budget() + 1; budget < all.max_budget(); ++budget) {
        SCOPED_TRACE("epsilon " + std::to_string(epsilon) + ", budget " + std::to_string(budget));
        asked.plain.budget = budget;
        long double mean = 0;
        for (int seed = 0; seed < seeds; ++seed) {
          asked.plain.stochastic.seed = static_cast<std::uint64_t>(seed);
          const Selection selection = selector_.select(asked.blocks, asked.options(Strategy::stochastic_greedy));
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
                         [](const auto& parameter) { return parameter.param; });

// `scale`: of the blocks, and of the roots of the prior. The prior's eigenvalues are spread over up to six decades, so
// that a triangle in long double finds the optimum to many digits.
Problem constrained_problem(Random& random, double scale) {
  const BlockStore made = awkward_blocks(random, static_cast<std::size_t>(random.integer(1, 11)));
  Problem problem = problem_of(scaled(random, made, std::pow(10, random.uniform(-3, 1)) * scale, 0.1), 0);
  constrain(random, problem);
  problem.plain.budget = std::min(problem.plain.budget, problem.required_count() + 5);
  problem.plain.certificate = true;
  const Matrix6 prior = random.chance(0.5) ? Matrix6(Matrix6::Identity()) : random_prior(random);
  problem.set_prior(prior * std::pow(10, random.uniform(-6, 0)) * scale * scale);
  return problem;
}

// Half of the optimum is what greedy guarantees over a matroid.
TEST(Certificate, is_never_below_the_optimum_at_any_scale_and_greedy_never_below_half_of_it) {
  for_each_trial(3600, [&](Random& random) {
    const double scale = random.chance(1.0 / 6) ? std::pow(10, random.uniform(-6, 30)) : 1;
    const Problem problem = constrained_problem(random, scale);
    Selector selector(problem.capacity());
    const Selection selection = selector.select(problem.blocks, problem.options());
    expect_sound(problem, selection, infinity);
    const AllSubsets feasible(problem, Groups::kept, 5), relaxed(problem, Groups::relaxed, 5);
    const long double optimum = feasible.optimum(problem.plain.budget), base = feasible.base();
    const long double reached = log_det_of(problem.blocks, indices_of(selection), problem.information());
    const long double error = 1e-16L * (1 + std::abs(optimum));
    EXPECT_GE(reached - base, (optimum - base) / 2 - error);
    EXPECT_LE(reached, optimum + error);
    // Where groups leave no more, no selection is longer than the answer.
    const bool is_full = selection.status == Status::all_selected;
    EXPECT_GE(selection.upper_bound, relaxed.optimum(is_full ? selection.size : problem.plain.budget) - error);
    EXPECT_GE(selection.certified_efficiency(), 0);  // 0 where the bound is thousands of nats
    EXPECT_LE(selection.certified_efficiency(), 1 + 1e-12);
  });
}

Options with_certificate(std::size_t budget) {
  Options options = with_budget(budget);
  options.certificate = true;
  return options;
}

TEST(Certificate, is_tight_where_everything_is_selected) {
  for_every_family(50, [](const BlockStore& blocks) {
    Selector selector(80);
    for (const std::size_t budget : {std::size_t{50}, std::size_t{80}}) {
      const Selection selection = selector.select(blocks, with_certificate(budget));
      EXPECT_EQ(selection.status, Status::all_selected);
      EXPECT_NEAR(selection.upper_bound, selection.log_det, 1e-6);
    }
  });
}

// And as much with half of the answer required: the candidates of the smallest traces.
TEST(Certificate, proves_greedy_nearly_optimal_on_frames) {
  for_every_family(1000, [](const BlockStore& blocks) {
    Selector selector(blocks.size());
    EXPECT_GE(selector.select(blocks, with_certificate(20)).certified_efficiency(), 0.9);
    Options options = with_certificate(100);
    EXPECT_GE(selector.select(blocks, options).certified_efficiency(), 0.99);
    std::vector<std::pair<double, std::size_t>> by_trace;
    for (std::size_t i = 0; i < blocks.size(); ++i) by_trace.emplace_back(stored_block(blocks, i).squaredNorm(), i);
    std::nth_element(by_trace.begin(), by_trace.begin() + 50, by_trace.end());
    std::vector<unsigned char> required(blocks.size());
    for (std::size_t j = 0; j < 50; ++j) required[by_trace[j].second] = 1;
    options.required = required.data();  // those of the smallest traces, which weaken the bound a little
    EXPECT_GE(selector.select(blocks, options).certified_efficiency(), 0.98);
  });
}

}  // namespace
}  // namespace maxlogdet::test
