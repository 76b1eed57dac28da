// SPDX-License-Identifier: MIT
// Proposals one by one and in batches, accepted, rejected, or accepted otherwise than proposed.
#include "tests/support/forced_isa.hpp"
#include "tests/support/oracle.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <limits>
#include <set>
#include <string>
#include <thread>
#include <type_traits>
#include <utility>
#include <vector>

namespace maxlogdet::test {
namespace {

constexpr std::uint32_t none = ActiveSelection::none;

Options with_budget(std::size_t budget) {
  Options options;
  options.budget = budget;
  return options;
}

TEST(ActiveSelection, accepting_everything_is_greedy) {
  for_every_family(600, [&](const BlockStore& blocks) {
    Selector selector(600);
    const Selection expected = selector.select(blocks, with_budget(60));
    ActiveSelection active(600);
    ASSERT_EQ(active.start(blocks, with_budget(60)), Status::ok);
    for (std::size_t i = 0; i < 60; ++i) {
      ASSERT_EQ(active.next(), expected.indices[i]) << "proposal " << i;
      ASSERT_EQ(active.next(), expected.indices[i]) << "asked again";
      ASSERT_EQ(active.accept(), Status::ok);
    }
    EXPECT_EQ(active.next(), none);
    const Selection selection = active.selection();
    EXPECT_EQ(selection.status, Status::ok);
    EXPECT_EQ(indices_of(selection), indices_of(expected));
    EXPECT_TRUE(std::equal(expected.gains, expected.gains + 60, selection.gains));
    EXPECT_EQ(selection.log_det, expected.log_det);
    EXPECT_EQ(selection.evaluations, expected.evaluations);
  });
}

// What is rejected, and blocks measured otherwise: each proposal is still the best of what is left.
TEST(ActiveSelection, every_proposal_is_the_best_of_what_is_left) {
  for (std::uint64_t variation = 0; variation < trials(300); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const auto n = static_cast<std::size_t>(random.integer(1, 150));
    const BlockStore blocks = awkward_blocks(random, n);
    GreedyOracle<long double> oracle(blocks);
    const auto budget = static_cast<std::size_t>(random.integer(1, static_cast<int>(n)));
    const double rejected_share = random.uniform(0, 0.9);
    ActiveSelection active(n);
    ASSERT_EQ(active.start(blocks, with_budget(budget)), Status::ok);
    std::size_t answered = 0;
    for (std::uint32_t i = active.next(); i != none; i = active.next(), ++answered) {
      const std::size_t best = oracle.best();
      ASSERT_LT(best, n);
      ASSERT_LE(oracle.gain(best) - oracle.gain(i), 1e-9L) << "answer " << answered;
      if (random.chance(rejected_share)) {
        ASSERT_EQ(active.reject(), Status::ok);
        oracle.exclude(i);
      } else if (random.chance(0.5)) {
        const Block measured = rounded(random_block(random, random.integer(1, 3)));
        ASSERT_EQ(active.accept(measured.data(), static_cast<int>(measured.rows())), Status::ok);
        oracle.take(i, measured);
      } else {
        ASSERT_EQ(active.accept(), Status::ok);
        oracle.take(i);
      }
    }
    const Selection selection = active.selection();
    EXPECT_TRUE(selection.size == budget || answered == n) << "ended early";
    EXPECT_NEAR(selection.log_det, static_cast<double>(oracle.log_det()), 1e-7);
    EXPECT_EQ(active.next(), none);
  }
}

TEST(ActiveSelection, takes_what_was_measured_as_a_store_would_hold_it) {
  for (std::uint64_t variation = 0; variation < trials(50); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const BlockStore blocks = awkward_blocks(random, 50);
    ActiveSelection exact(50), stored(50);
    ASSERT_EQ(exact.start(blocks, with_budget(10)), Status::ok);
    ASSERT_EQ(stored.start(blocks, with_budget(10)), Status::ok);
    while (exact.next() != none) {
      ASSERT_EQ(stored.next(), exact.next());
      const Block measured = random_block(random, random.integer(1, 3));
      ASSERT_EQ(exact.accept(measured.data(), static_cast<int>(measured.rows())), Status::ok);
      ASSERT_EQ(stored.accept(rounded(measured).data(), static_cast<int>(measured.rows())), Status::ok);
    }
    EXPECT_EQ(exact.selection().log_det, stored.selection().log_det);
  }
}

TEST(ActiveSelection, rejecting_everything_proposes_everything_once) {
  Random random;
  SCOPED_TRACE(random.name());
  const BlockStore blocks = awkward_blocks(random, 100);
  ActiveSelection active(100);
  ASSERT_EQ(active.start(blocks, with_budget(10)), Status::ok);
  std::set<std::uint32_t> proposed;
  for (std::uint32_t i = active.next(); i != none; i = active.next()) {
    EXPECT_TRUE(proposed.insert(i).second);
    EXPECT_EQ(active.reject(), Status::ok);
  }
  EXPECT_EQ(proposed.size(), 100U);
  EXPECT_EQ(active.selection().size, 0U);
  EXPECT_EQ(active.selection().status, Status::all_selected);
}

TEST(ActiveSelection, begins_anew) {
  Random random;
  const BlockStore first = awkward_blocks(random, 80);
  const BlockStore second = awkward_blocks(random, 50);
  ActiveSelection active(80);
  for (const BlockStore* const blocks : {&first, &second, &first}) {
    ASSERT_EQ(active.start(*blocks, with_budget(20)), Status::ok);
    while (active.next() != none) active.accept();
    EXPECT_EQ(indices_of(active.selection()), select_indices(*blocks, with_budget(20)));
  }
}

TEST(ActiveSelection, keeps_to_constraints) {
  Random random;
  SCOPED_TRACE(random.name());
  const BlockStore blocks = awkward_blocks(random, 90);
  std::vector<std::uint32_t> groups(90);
  for (std::uint32_t i = 0; i < 90; ++i) groups[i] = i % 5;
  std::vector<unsigned char> required(90);
  std::vector<unsigned char> excluded(90);
  required[7] = required[8] = 1;
  excluded[0] = excluded[1] = 1;
  Options options = with_budget(50);
  options.groups = groups.data();
  options.group_count = 5;
  options.max_per_group = 3;
  options.required = required.data();
  options.excluded = excluded.data();
  ActiveSelection active(90);
  ASSERT_EQ(active.start(blocks, options), Status::ok);
  EXPECT_EQ(active.selection().size, 2U);
  while (active.next() != none) active.accept();
  EXPECT_EQ(active.selection().status, Status::all_selected);
  EXPECT_EQ(active.selection().size, 15U);
  EXPECT_EQ(indices_of(active.selection()), select_indices(blocks, options));

  std::size_t rejected = 0;  // what is rejected takes no place of its group
  ASSERT_EQ(active.start(blocks, options), Status::ok);
  for (std::size_t i = 0; active.next() != none; ++i)
    rejected += (i % 2 == 0 ? active.reject() : active.accept()) == Status::ok && i % 2 == 0 ? 1U : 0U;
  EXPECT_EQ(active.selection().size, 15U);
  EXPECT_GE(rejected, 13U);
}

TEST(ActiveSelection, answers_without_a_proposal_and_bad_blocks_are_named) {
  Random random;
  const BlockStore blocks = awkward_blocks(random, 20);
  const Block block = random_block(random, 3);
  ActiveSelection active(20);
  EXPECT_EQ(active.next(), none);
  EXPECT_EQ(active.accept(), Status::nothing_proposed);
  EXPECT_EQ(active.reject(), Status::nothing_proposed);
  EXPECT_EQ(active.accept(block.data(), 3), Status::nothing_proposed);
  EXPECT_EQ(active.selection().size, 0U);
  EXPECT_EQ(active.selection().invalid_candidates, 0U);
  EXPECT_EQ(active.selection().status, Status::nothing_proposed);
  EXPECT_FALSE(active.selection().has_answer());

  ASSERT_EQ(active.start(blocks, with_budget(5)), Status::ok);
  EXPECT_EQ(active.accept(), Status::nothing_proposed);
  const std::uint32_t proposed = active.next();
  Block bad = block;
  bad(2, 5) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(active.accept(bad.data(), 3), Status::invalid_block);
  bad(2, 5) = 1e39;  // beyond float32, as in a store
  EXPECT_EQ(active.accept(bad.data(), 3), Status::invalid_block);
  EXPECT_EQ(active.accept(nullptr, 2), Status::invalid_block);
  EXPECT_EQ(active.accept(block.data(), 0), Status::invalid_block);
  EXPECT_EQ(active.accept(block.data(), 4), Status::invalid_block);
  EXPECT_EQ(active.next(), proposed);
  EXPECT_EQ(active.accept(block.data(), 3), Status::ok);
  EXPECT_EQ(active.accept(), Status::nothing_proposed) << "answered already";
  EXPECT_EQ(active.selection().size, 1U);
}

TEST(ActiveSelection, bad_requests_are_named) {
  Random random;
  const BlockStore blocks = awkward_blocks(random, 20);
  ActiveSelection active(10);
  EXPECT_EQ(active.start(blocks, with_budget(5)), Status::capacity_exceeded);
  EXPECT_EQ(active.next(), none);
  EXPECT_EQ(active.selection().status, Status::capacity_exceeded);
  EXPECT_TRUE(std::isnan(active.selection().log_det));
  active = ActiveSelection(20);
  Options options = with_budget(21);
  EXPECT_EQ(active.start(blocks, options), Status::invalid_budget);
  options = with_budget(5);
  for (const Strategy strategy : sim::strategies) {
    options.strategy = strategy;
    const bool is_greedy =
        strategy == Strategy::greedy || strategy == Strategy::lazy_greedy || strategy == Strategy::automatic;
    EXPECT_EQ(active.start(blocks, options), is_greedy ? Status::ok : Status::invalid_strategy) << to_string(strategy);
  }
  options = with_budget(5);
  const double zeros[36] = {};
  options.prior = zeros;
  EXPECT_EQ(active.start(blocks, options), Status::invalid_prior);
  EXPECT_EQ(active.next(), none);
  EXPECT_THROW(ActiveSelection{std::size_t{1} << 32U}, std::bad_alloc);
}

TEST(ActiveSelection, no_candidates_and_no_budget) {
  Random random;
  const BlockStore blocks = awkward_blocks(random, 20);
  ActiveSelection active(20);
  EXPECT_EQ(active.start(BlockStore(), with_budget(5)), Status::ok);
  EXPECT_EQ(active.next(), none);
  EXPECT_EQ(active.start(blocks, with_budget(0)), Status::ok);
  EXPECT_EQ(active.next(), none);
  EXPECT_EQ(active.selection().status, Status::ok);
}

TEST(ActiveSelection, stops_at_the_time_limit) {
  Random random;
  const BlockStore blocks = awkward_blocks(random, 20);
  ActiveSelection active(20);
  Options options = with_budget(20);
  options.time_limit = 1e-9;
  ASSERT_EQ(active.start(blocks, options), Status::ok);
  EXPECT_EQ(active.next(), none);
  EXPECT_EQ(active.selection().status, Status::deadline_reached);
}

TEST(ActiveSelection, the_moved_from_one_says_so) {
  Random random;
  const BlockStore blocks = awkward_blocks(random, 20);
  ActiveSelection first(20);
  ASSERT_EQ(first.start(blocks, with_budget(3)), Status::ok);
  first.next();
  ActiveSelection second(std::move(first));
  EXPECT_EQ(second.accept(), Status::ok);
  EXPECT_EQ(second.selection().size, 1U);
  // NOLINTBEGIN(bugprone-use-after-move,clang-analyzer-cplusplus.Move)
  EXPECT_EQ(first.capacity(), 0U);
  EXPECT_EQ(first.next(), none);
  EXPECT_EQ(first.accept(), Status::nothing_proposed);
  EXPECT_EQ(first.start(blocks, with_budget(3)), Status::capacity_exceeded);
  EXPECT_EQ(first.selection().status, Status::capacity_exceeded);
  // NOLINTEND(bugprone-use-after-move,clang-analyzer-cplusplus.Move)
}

// Candidates, and whatever may be asked of them.
struct Request {
  BlockStore blocks;
  std::vector<unsigned char> required, excluded;
  std::vector<std::uint32_t> groups, maxima;
  std::size_t budget = 0;
  bool has_prior = false;
  Matrix6 prior = default_information();

  Options options() const {
    Options result = with_budget(budget);
    if (has_prior) result.prior = prior.data();
    if (!required.empty()) result.required = required.data();
    if (!excluded.empty()) result.excluded = excluded.data();
    if (groups.empty()) return result;
    result.groups = groups.data();
    result.group_count = maxima.size();
    result.group_maxima = maxima.data();
    return result;
  }

  std::size_t capacity() const { return std::max(blocks.size(), budget); }

  bool is_free(std::size_t i) const {
    return blocks.is_valid(i) && (excluded.empty() || excluded[i] == 0) && (required.empty() || required[i] == 0);
  }
};

// Each is there several times, in any order.
BlockStore repeated_blocks(Random& random, std::size_t n) {
  const BlockStore different = awkward_blocks(random, 1 + n / 4);
  BlockStore blocks;
  while (blocks.size() < n) {
    push_back(
        blocks,
        stored_block(different, static_cast<std::size_t>(random.integer(0, static_cast<int>(different.size()) - 1))));
  }
  return blocks;
}

// The same candidates by their rows alone.
BlockStore pushed(const BlockStore& blocks) {
  BlockStore copy;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (blocks.is_valid(i)) {
      push_back(copy, stored_block(blocks, i));
    } else {
      copy.push_back_invalid();
    }
  }
  return copy;
}

// 2 rows, 3 rows that append_blocks built, 3 rows that were pushed, or blocks of every sort.
BlockStore any_blocks(Random& random, std::size_t n) {
  const int sort = random.integer(0, 5);
  if (sort == 0) return awkward_blocks(random, n);
  if (sort == 1) return repeated_blocks(random, n);
  const sim::Scene scene = sim::scenes[random.integer(0, static_cast<int>(std::size(sim::scenes)) - 1)];
  const BlockKind& kind = block_kinds[random.integer(0, static_cast<int>(std::size(block_kinds)) - 1)];
  const BlockStore blocks = blocks_of(make_scene(scene, n, random.seed()), kind);
  return sort == 2 ? pushed(blocks) : blocks;
}

void set_prior(Random& random, Request& request) {
  const int sort = random.integer(0, 3);
  request.has_prior = sort > 0;
  if (sort == 1) request.prior = random_prior(random);
  if (sort == 2) request.prior = 1e4 * random_prior(random);
  if (sort == 3) request.prior = 1e-6 * Matrix6::Identity();
}

Request any_request(Random& random, std::size_t n) {
  Request request;
  request.blocks = any_blocks(random, n);
  request.budget = static_cast<std::size_t>(random.integer(1, static_cast<int>(n) + 5));
  set_prior(random, request);
  return request;
}

// One that can be met, with any subset of the constraints.
Request any_constrained_request(Random& random, std::size_t n) {
  Request request = any_request(random, n);
  if (random.chance(0.5)) {
    request.excluded.resize(n);
    for (unsigned char& flag : request.excluded) flag = random.chance(0.15) ? 1 : 0;
  }
  if (random.chance(0.5)) {
    const int count = random.integer(1, 12);
    for (int g = 0; g < count; ++g) request.maxima.push_back(static_cast<std::uint32_t>(random.integer(0, 5)));
    for (std::size_t i = 0; i < n; ++i) {
      request.groups.push_back(static_cast<std::uint32_t>(random.integer(0, count - 1)));
    }
  }
  if (random.chance(0.5)) {
    std::vector<unsigned char> required(n);
    std::vector<std::uint32_t> places = request.maxima;
    std::size_t count = 0;
    for (std::size_t i = 0; i < n && count < request.budget; ++i) {
      if (!random.chance(0.05) || !request.is_free(i)) continue;
      if (!places.empty() && places[request.groups[i]]-- == 0) break;
      required[i] = 1;
      ++count;
    }
    request.required = required;
  }
  return request;
}

// What an active selection has to propose, all gains worked out anew in long double whenever it is asked.
class Model {
 public:
  explicit Model(const Request& request)
      : oracle_(request.blocks, request.prior),
        groups_(request.groups),
        places_(request.maxima),
        left_(request.budget),
        is_open_(request.blocks.size()) {
    for (std::size_t i = 0; i < is_open_.size(); ++i) {
      is_open_[i] = request.is_free(i);
      if (!request.required.empty() && request.required[i] != 0) take(static_cast<std::uint32_t>(i));
    }
    find_copies(request.blocks);
  }

  std::size_t size() const { return is_open_.size(); }
  std::size_t left() const { return left_; }
  bool is_open(std::size_t i) const { return is_open_[i] && has_place(i, places_); }
  std::size_t open_count() const {
    std::size_t count = 0;
    for (std::size_t i = 0; i < size(); ++i) count += is_open(i) ? 1 : 0;
    return count;
  }

  // Whether these are the best of what may be accepted together.
  void expect_best(const std::vector<std::uint32_t>& proposed, std::size_t wanted) const {
    const std::vector<long double> gains = gains_of_open();
    const std::vector<std::uint32_t> expected = best(gains, wanted);
    ASSERT_EQ(proposed.size(), expected.size());
    std::vector<std::uint32_t> places = places_;
    for (std::size_t j = 0; j < proposed.size(); ++j) {
      const std::uint32_t i = proposed[j];
      ASSERT_LT(i, size());
      ASSERT_TRUE(is_open_[i] && has_place(i, places)) << i << " may not be accepted with those before it";
      ASSERT_EQ(std::find(proposed.begin(), proposed.begin() + static_cast<std::ptrdiff_t>(j), i),
                proposed.begin() + static_cast<std::ptrdiff_t>(j));
      ASSERT_LE(std::abs(gains[i] - gains[expected[j]]), 1e-9L) << "proposal " << j;
      expect_first_of_its_copies(proposed, j, places);
      if (!places.empty()) --places[groups_[i]];
    }
  }

  void take(std::uint32_t i) {
    oracle_.take(i);
    close(i);
  }
  void take(std::uint32_t i, const Block& measured) {
    oracle_.take(i, measured);
    close(i);
  }
  void reject(std::uint32_t i) { is_open_[i] = false; }
  double log_det() const { return static_cast<double>(oracle_.log_det()); }

 private:
  bool has_place(std::size_t i, const std::vector<std::uint32_t>& places) const {
    return places.empty() || places[groups_[i]] > 0;
  }

  void close(std::uint32_t i) {
    is_open_[i] = false;
    --left_;
    if (!places_.empty()) --places_[groups_[i]];
  }

  void find_copies(const BlockStore& blocks) {
    std::vector<Block> all;
    for (std::size_t i = 0; i < size(); ++i) {
      all.push_back(stored_block(blocks, i));
      first_copy_.push_back(static_cast<std::size_t>(std::find(all.begin(), all.end(), all[i]) - all.begin()));
    }
  }

  void expect_first_of_its_copies(const std::vector<std::uint32_t>& proposed, std::size_t j,
                                  const std::vector<std::uint32_t>& places) const {
    const auto end = proposed.begin() + static_cast<std::ptrdiff_t>(j);
    for (std::uint32_t i = 0; i < proposed[j]; ++i) {
      if (!is_open_[i] || !has_place(i, places) || first_copy_[i] != first_copy_[proposed[j]]) continue;
      ASSERT_NE(std::find(proposed.begin(), end, i), end) << proposed[j] << " before its copy " << i;
    }
  }

  std::vector<long double> gains_of_open() const {
    std::vector<long double> gains(size(), -1);
    for (std::size_t i = 0; i < size(); ++i) {
      if (is_open(i)) gains[i] = oracle_.gain(i);
    }
    return gains;
  }

  std::vector<std::uint32_t> best(const std::vector<long double>& gains, std::size_t wanted) const {
    std::vector<std::uint32_t> order;
    for (std::uint32_t i = 0; i < size(); ++i) {
      if (is_open(i)) order.push_back(i);
    }
    std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return gains[a] > gains[b]; });
    std::vector<std::uint32_t> places = places_;
    std::vector<std::uint32_t> found;
    for (const std::uint32_t i : order) {
      if (found.size() == std::min(wanted, left_)) break;
      if (!has_place(i, places)) continue;
      if (!places.empty()) --places[groups_[i]];
      found.push_back(i);
    }
    return found;
  }

  GreedyOracle<long double> oracle_;
  std::vector<std::uint32_t> groups_, places_;
  std::size_t left_;
  std::vector<bool> is_open_;
  std::vector<std::size_t> first_copy_;
};

// An active selection and its model, asked and answered in every way.
class Batches {
 public:
  Batches(Random& random, const Request& request)
      : random_(random), options_(request.options()), model_(request), active_(request.capacity()) {
    EXPECT_EQ(active_.start(request.blocks, options_), Status::ok);
    for (const std::uint32_t i : active_.selection()) accepted_.push_back(i);
    begin_round();
  }

  void run(std::size_t most, double rejected_share) {
    rejected_share_ = rejected_share;
    while (propose(static_cast<std::size_t>(random_.integer(1, static_cast<int>(most))))) {
      while (!unanswered_.empty() && !::testing::Test::HasFatalFailure()) answer();
      if (::testing::Test::HasFatalFailure()) return;
    }
    expect_end();
  }

 private:
  // False at the end.
  bool propose(std::size_t wanted) {
    std::vector<std::uint32_t> proposed(wanted + 1, none);
    proposed.resize(active_.next(proposed.data(), wanted));
    model_.expect_best(proposed, wanted);
    unanswered_ = proposed;
    if (!::testing::Test::HasFatalFailure()) expect_evaluated_once();
    return !proposed.empty() && !::testing::Test::HasFatalFailure();
  }

  void expect_evaluated_once() {
    EXPECT_LE(active_.selection().evaluations - evaluations_, open_) << "twice since the last acceptance";
  }

  void begin_round() {
    evaluations_ = active_.selection().evaluations;
    open_ = model_.open_count();
  }

  void expect_asked_again() {
    const auto wanted = static_cast<std::size_t>(random_.integer(1, 20));
    std::vector<std::uint32_t> again(wanted, none);
    again.resize(active_.next(again.data(), wanted));
    const std::size_t count = std::min(wanted, unanswered_.size());
    EXPECT_EQ(again, std::vector<std::uint32_t>(unanswered_.begin(),
                                                unanswered_.begin() + static_cast<std::ptrdiff_t>(count)));
    EXPECT_EQ(active_.next(), unanswered_.front());
  }

  // Answers to what is not proposed, and questions that are none.
  void expect_no_effect() {
    const auto any = static_cast<std::uint32_t>(random_.integer(0, static_cast<int>(model_.size()) + 3));
    const Block block = random_block(random_, 2);
    if (std::find(unanswered_.begin(), unanswered_.end(), any) == unanswered_.end()) {
      EXPECT_EQ(active_.accept(any), Status::nothing_proposed);
      EXPECT_EQ(active_.accept(any, block.data(), 2), Status::nothing_proposed);
      EXPECT_EQ(active_.accept(any, nullptr, 2), Status::nothing_proposed);
      EXPECT_EQ(active_.reject(any), Status::nothing_proposed);
    }
    EXPECT_EQ(active_.accept(none), Status::nothing_proposed);
    const std::vector<unsigned char> matched(unanswered_.size() + 1, 1);
    EXPECT_EQ(active_.answer(matched.data(), unanswered_.size() + 1), Status::nothing_proposed);
    EXPECT_EQ(active_.answer(matched.data(), unanswered_.size() - 1), Status::nothing_proposed);
    EXPECT_EQ(active_.answer(matched.data(), 0), Status::nothing_proposed);
    EXPECT_EQ(active_.answer(nullptr, unanswered_.size()), Status::nothing_proposed);
    std::uint32_t untouched = 123;
    EXPECT_EQ(active_.next(nullptr, 5), 0U);
    EXPECT_EQ(active_.next(&untouched, 0), 0U);
    EXPECT_EQ(untouched, 123U);
    EXPECT_EQ(active_.accept(unanswered_.back(), nullptr, 2), Status::invalid_block);
    EXPECT_EQ(active_.accept(unanswered_.front(), block.data(), 4), Status::invalid_block);
    EXPECT_EQ(active_.accept(block.data(), 0), Status::invalid_block);
    expect_accepted();
  }

  void expect_accepted() { ASSERT_EQ(indices_of(active_.selection()), accepted_); }

  void answer() {
    if (random_.chance(0.3)) expect_asked_again();
    if (random_.chance(0.3)) expect_no_effect();
    switch (random_.integer(0, 4)) {
      case 0: answer_all(); break;
      case 1: answer_first(); break;
      default: answer_by_index();
    }
    expect_accepted();
  }

  void answer_all() {
    std::vector<unsigned char> matched;
    for (std::size_t j = 0; j < unanswered_.size(); ++j) matched.push_back(is_matched() ? 255 : 0);
    ASSERT_EQ(active_.answer(matched.data(), matched.size()), Status::ok);
    const std::vector<std::uint32_t> answered = unanswered_;
    for (std::size_t j = 0; j < answered.size(); ++j) note(answered[j], matched[j] != 0);
  }

  void answer_first() {
    const std::uint32_t i = unanswered_.front();
    const bool accepts = is_matched();
    ASSERT_EQ(accepts ? active_.accept() : active_.reject(), Status::ok);
    note(i, accepts);
  }

  void answer_by_index() {
    const std::uint32_t i =
        unanswered_[static_cast<std::size_t>(random_.integer(0, static_cast<int>(unanswered_.size()) - 1))];
    if (!is_matched()) {
      ASSERT_EQ(active_.reject(i), Status::ok);
      note(i, false);
    } else if (random_.chance(0.3)) {
      const Block measured = rounded(random_block(random_, random_.integer(1, 3)));
      ASSERT_EQ(active_.accept(i, measured.data(), static_cast<int>(measured.rows())), Status::ok);
      note(i, true, &measured);
    } else {
      ASSERT_EQ(active_.accept(i), Status::ok);
      note(i, true);
    }
    ASSERT_EQ(active_.reject(i), Status::nothing_proposed) << "answered already";
  }

  bool is_matched() { return !random_.chance(rejected_share_); }

  void note(std::uint32_t i, bool is_accepted, const Block* measured = nullptr) {
    unanswered_.erase(std::find(unanswered_.begin(), unanswered_.end(), i));
    if (!is_accepted) return model_.reject(i);
    measured == nullptr ? model_.take(i) : model_.take(i, *measured);
    accepted_.push_back(i);
    begin_round();
  }

  void expect_end() {
    EXPECT_TRUE(model_.left() == 0 || model_.open_count() == 0) << "ended early";
    EXPECT_EQ(active_.next(), none);
    const std::vector<unsigned char> matched(1, 1);
    EXPECT_EQ(active_.answer(matched.data(), 0), Status::nothing_proposed);
    EXPECT_EQ(active_.answer(matched.data(), 1), Status::nothing_proposed);
    const Selection selection = active_.selection();
    EXPECT_EQ(selection.status, model_.open_count() == 0 ? Status::all_selected : Status::ok);
    EXPECT_NEAR(selection.log_det, model_.log_det(), 1e-7);
  }

  Random& random_;
  Options options_;
  Model model_;
  ActiveSelection active_;
  double rejected_share_ = 0;
  std::vector<std::uint32_t> unanswered_, accepted_;
  std::size_t evaluations_ = 0;  // when the last one was accepted
  std::size_t open_ = 0;         // candidates then
};

// On one instruction set after the other.
sim::ForcedIsa isa_of(std::uint64_t variation) {
  const std::vector<std::string> isas = sim::supported_isas();
  return sim::ForcedIsa(isas[variation % isas.size()].c_str());
}

template <class Answer, class = void>
struct Accepts : std::false_type {};
template <class Answer>
struct Accepts<Answer, decltype(std::declval<ActiveSelection&>().accept(std::declval<Answer>()), void())>
    : std::true_type {};
static_assert(Accepts<std::uint32_t>::value && Accepts<int>::value, "an index");
static_assert(!Accepts<bool>::value, "whether it was matched is no index");

TEST(ActiveSelection, batches_are_the_best_of_what_is_left) {
  for (std::uint64_t variation = 0; variation < trials(400); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const sim::ForcedIsa forced = isa_of(variation);
    const auto n = static_cast<std::size_t>(random.integer(1, 150));
    const Request request = any_request(random, n);
    Batches(random, request).run(static_cast<std::size_t>(random.integer(1, 30)), random.uniform(0, 0.95));
    if (HasFailure()) return;
  }
}

TEST(ActiveSelection, batches_keep_to_constraints) {
  for (std::uint64_t variation = 0; variation < trials(400); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const sim::ForcedIsa forced = isa_of(variation);
    const auto n = static_cast<std::size_t>(random.integer(1, 150));
    const Request request = any_constrained_request(random, n);
    Batches(random, request).run(static_cast<std::size_t>(random.integer(1, 30)), random.uniform(0, 0.95));
    if (HasFailure()) return;
  }
}

TEST(ActiveSelection, batches_are_the_best_of_many) {
  for (std::uint64_t variation = 0; variation < trials(20); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const sim::ForcedIsa forced = isa_of(variation);
    Request request = any_constrained_request(random, 1000);
    request.budget = std::max<std::size_t>(
        60, static_cast<std::size_t>(std::count(request.required.begin(), request.required.end(), 1)) + 30);
    Batches(random, request).run(40, random.uniform(0, 0.8));
    if (HasFailure()) return;
  }
}

// Next to nothing is learnt, so that bounds of rounding errors stay wide: what is selected no longer counts for them.
TEST(ActiveSelection, what_is_taken_out_takes_nothing_else_with_it) {
  for (const BlockKind& kind : block_kinds) {
    Random random;
    SCOPED_TRACE(random.name() + " " + kind.name);
    const BlockStore blocks = blocks_of(make_scene(sim::Scene::euroc_like, 100, random.seed()), kind);
    GreedyOracle<long double> oracle(blocks);
    const Block measured = rounded(random_block(random, 1, 1e-3));
    ActiveSelection active(100);
    ASSERT_EQ(active.start(blocks, with_budget(100)), Status::ok);
    for (std::uint32_t i = active.next(); i != none; i = active.next()) {
      ASSERT_LE(oracle.gain(oracle.best()) - oracle.gain(i), 1e-9L);
      ASSERT_EQ(active.accept(measured.data(), 1), Status::ok);
      oracle.take(i, measured);
    }
  }
}

// Whatever is rejected, and whether it is asked for by next() or by next(indices, 1).
TEST(ActiveSelection, one_at_a_time_it_is_greedy_without_what_is_rejected) {
  for (std::uint64_t variation = 0; variation < trials(400); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const sim::ForcedIsa forced = isa_of(variation);
    const auto n = static_cast<std::size_t>(random.integer(1, random.chance(0.1) ? 2000 : 300));
    Request request = any_constrained_request(random, n);
    const double rejected_share = random.uniform(0, 0.95);
    ActiveSelection active(request.capacity());
    const Options options = request.options();
    ASSERT_EQ(active.start(request.blocks, options), Status::ok);
    std::vector<unsigned char> excluded = request.excluded;
    excluded.resize(n);
    for (std::uint32_t i = none; active.next(&i, 1) == 1; i = none) {
      ASSERT_EQ(active.next(), i);
      const bool is_rejected = random.chance(rejected_share);
      ASSERT_EQ(is_rejected ? active.reject() : active.accept(), Status::ok);
      if (is_rejected) excluded[i] = 1;
    }
    request.excluded = excluded;
    Selector selector(request.capacity());
    const Selection expected = selector.select(request.blocks, request.options());
    const Selection selection = active.selection();
    EXPECT_EQ(selection.status, expected.status);
    ASSERT_EQ(indices_of(selection), indices_of(expected));
    EXPECT_TRUE(std::equal(selection.gains, selection.gains + selection.size, expected.gains));
    EXPECT_EQ(selection.log_det, expected.log_det);
  }
}

// Where proposals end does not depend on what a machine happens to have evaluated besides.
TEST(ActiveSelection, batches_are_the_same_on_every_instruction_set) {
  for (std::uint64_t variation = 0; variation < trials(100); ++variation) {
    std::vector<std::uint32_t> first;
    for (const std::string& isa : sim::supported_isas()) {
      Random random(variation);
      SCOPED_TRACE(random.name() + " on " + isa);
      const sim::ForcedIsa forced(isa.c_str());
      const Request request = any_constrained_request(random, static_cast<std::size_t>(random.integer(1, 300)));
      ActiveSelection active(request.capacity());
      ASSERT_EQ(active.start(request.blocks, request.options()), Status::ok);
      std::vector<std::uint32_t> proposed;
      std::uint32_t batch[10];
      while (const std::size_t count = active.next(batch, static_cast<std::size_t>(random.integer(1, 10)))) {
        proposed.insert(proposed.end(), batch, batch + count);
        proposed.push_back(none);
        for (std::size_t j = 0; j < count; ++j) random.chance(0.5) ? active.accept() : active.reject();
      }
      if (first.empty()) first = proposed;
      EXPECT_EQ(proposed, first);
    }
  }
}

// What is known of a round is known after a rejection, too.
TEST(ActiveSelection, a_rejection_evaluates_nothing_again) {
  for_every_family(600, [&](const BlockStore& blocks) {
    const std::size_t n = blocks.size() - blocks.invalid_count();
    ActiveSelection active(600);
    ASSERT_EQ(active.start(blocks, with_budget(100)), Status::ok);
    std::uint32_t batch[7];
    for (std::size_t round = 0, left = n; round < 2; ++round) {  // all are evaluated, once
      const std::size_t before = active.selection().evaluations;
      const std::size_t expected = before + left;
      for (std::size_t wanted : {1U, 7U, 1U, 1U, 3U, 1U}) {
        const std::size_t count = active.next(batch, wanted);
        ASSERT_EQ(count, wanted);
        EXPECT_EQ(active.selection().evaluations, expected);
        for (std::size_t j = 0; j < count; ++j) ASSERT_EQ(active.reject(batch[j]), Status::ok);
        left -= count;
      }
      ASSERT_NE(active.next(), none);
      ASSERT_EQ(active.accept(), Status::ok);
      EXPECT_EQ(active.selection().evaluations, expected);
      --left;
    }
    for (std::size_t accepted = 2; accepted < 20; ++accepted) {
      active.next();
      active.accept();
    }
    std::size_t free_of_charge = 0, rejected = 0;  // of the next round, which is in order
    const std::size_t before = active.selection().evaluations;
    std::size_t evaluations = before;
    for (; active.next() != none; ++rejected) {
      const std::size_t now = active.selection().evaluations;
      free_of_charge += now == evaluations ? 1 : 0;
      evaluations = now;
      ASSERT_EQ(active.reject(), Status::ok);
    }
    EXPECT_LE(evaluations - before, rejected) << "each of them once at most";
    EXPECT_GT(2 * free_of_charge, rejected);
  });
}

TEST(ActiveSelection, rejecting_everything_from_the_start_evaluates_everything_once) {
  Random random;
  SCOPED_TRACE(random.name());
  for (const std::size_t wanted : {1U, 2U, 16U, 99U, 1000U}) {
    const BlockStore blocks = any_blocks(random, 300);
    const std::size_t n = blocks.size() - blocks.invalid_count();
    ActiveSelection active(300);
    ASSERT_EQ(active.start(blocks, with_budget(300)), Status::ok);
    std::vector<std::uint32_t> batch(wanted);
    std::set<std::uint32_t> proposed;
    while (const std::size_t count = active.next(batch.data(), wanted)) {
      const std::vector<unsigned char> matched(count);
      for (std::size_t j = 0; j < count; ++j) EXPECT_TRUE(proposed.insert(batch[j]).second) << batch[j];
      ASSERT_EQ(active.answer(matched.data(), count), Status::ok);
    }
    EXPECT_EQ(proposed.size(), n);
    EXPECT_EQ(active.selection().evaluations, n);
    EXPECT_EQ(active.selection().size, 0U);
    EXPECT_EQ(active.selection().status, Status::all_selected);
  }
}

// A budget of everything, in one batch: by gains against the prior, all of them.
TEST(ActiveSelection, a_batch_may_be_everything) {
  Random random;
  SCOPED_TRACE(random.name());
  const BlockStore blocks = awkward_blocks(random, 70);
  ActiveSelection active(200);
  for (const std::size_t budget : {70U, 200U}) {
    ASSERT_EQ(active.start(blocks, with_budget(budget)), Status::ok);
    std::vector<std::uint32_t> batch(200, none);
    ASSERT_EQ(active.next(batch.data(), 200), 70U);
    EXPECT_EQ(batch[70], none) << "nothing is written behind them";
    const std::vector<unsigned char> matched(70, 1);
    EXPECT_EQ(active.answer(matched.data(), 70), Status::ok);
    EXPECT_EQ(active.next(batch.data(), 200), 0U);
    batch.resize(70);
    EXPECT_EQ(indices_of(active.selection()), batch);
    EXPECT_EQ(active.selection().status, Status::all_selected);
    EXPECT_NEAR(active.selection().log_det, static_cast<double>(log_det_of(blocks, batch)), 1e-7);
  }
}

TEST(ActiveSelection, begins_anew_in_the_middle_of_a_batch) {
  Random random;
  SCOPED_TRACE(random.name());
  const BlockStore first = awkward_blocks(random, 80), second = awkward_blocks(random, 50);
  ActiveSelection active(80);
  for (int left = 0; left < 4; ++left) {
    for (const BlockStore* const blocks : {&first, &second}) {
      std::uint32_t batch[9];
      ASSERT_EQ(active.start(*blocks, with_budget(20)), Status::ok);
      ASSERT_EQ(active.next(batch, 9), 9U);
      for (int answered = 0; answered < 3 * left; ++answered) {
        ASSERT_EQ(answered % 2 == 0 ? active.accept(batch[8 - answered]) : active.reject(batch[8 - answered]),
                  Status::ok);
      }
      ASSERT_EQ(active.start(*blocks, with_budget(20)), Status::ok);
      EXPECT_EQ(active.accept(batch[0]), Status::nothing_proposed) << "it was, before";
      EXPECT_EQ(active.selection().size, 0U);
      while (active.next() != none) active.accept();
      EXPECT_EQ(indices_of(active.selection()), select_indices(*blocks, with_budget(20)));
    }
  }
}

// All answers to a selection that has not begun, or is in error.
void expect_nothing_to_answer(ActiveSelection& active) {
  const double block[6] = {1, 2, 3, 4, 5, 6};
  const unsigned char matched[] = {1};
  std::uint32_t index = 7;
  EXPECT_EQ(active.next(), none);
  EXPECT_EQ(active.next(&index, 1), 0U);
  EXPECT_EQ(index, 7U);
  EXPECT_EQ(active.accept(0), Status::nothing_proposed);
  EXPECT_EQ(active.accept(0, block, 1), Status::nothing_proposed);
  EXPECT_EQ(active.reject(0), Status::nothing_proposed);
  EXPECT_EQ(active.answer(matched, 1), Status::nothing_proposed);
  EXPECT_EQ(active.answer(matched, 0), Status::nothing_proposed);
  EXPECT_EQ(active.answer(nullptr, 0), Status::nothing_proposed);
  EXPECT_EQ(active.selection().size, 0U);
}

TEST(ActiveSelection, answers_by_index_need_a_proposal) {
  Random random;
  const BlockStore blocks = awkward_blocks(random, 20);
  ActiveSelection active(20);
  expect_nothing_to_answer(active);
  ASSERT_EQ(active.start(blocks, with_budget(5)), Status::ok);
  EXPECT_EQ(active.accept(0), Status::nothing_proposed) << "nobody asked for a proposal";
  std::uint32_t batch[5];
  ASSERT_EQ(active.next(batch, 5), 5U);
  ASSERT_EQ(active.start(blocks, with_budget(21)), Status::invalid_budget);
  expect_nothing_to_answer(active);
  ASSERT_EQ(active.start(blocks, with_budget(5)), Status::ok);
  ASSERT_EQ(active.next(batch, 5), 5U);
  ActiveSelection other(std::move(active));
  expect_nothing_to_answer(active);  // NOLINT(bugprone-use-after-move,clang-analyzer-cplusplus.Move)
  EXPECT_EQ(other.accept(batch[3]), Status::ok);
  EXPECT_EQ(other.next(), batch[0]);
}

TEST(ActiveSelection, what_is_proposed_at_the_time_limit_may_still_be_answered) {
  Random random;
  const BlockStore blocks = awkward_blocks(random, 20);
  ActiveSelection active(20);
  Options options = with_budget(20);
  std::uint32_t batch[6];
  std::size_t count = 0;
  for (options.time_limit = 0.05; count == 0; options.time_limit *= 2) {  // a busy machine may need more
    ASSERT_EQ(active.start(blocks, options), Status::ok);
    count = active.next(batch, 6);
    std::this_thread::sleep_for(std::chrono::duration<double>(1.1 * options.time_limit));
  }
  ASSERT_EQ(count, 6U);
  EXPECT_EQ(active.next(), batch[0]);
  EXPECT_EQ(active.reject(batch[0]), Status::ok);
  EXPECT_EQ(active.accept(batch[5]), Status::ok);
  const unsigned char matched[] = {1, 0, 1, 1};
  EXPECT_EQ(active.answer(matched, 4), Status::ok);
  EXPECT_EQ(active.next(batch, 6), 0U);
  EXPECT_EQ(active.next(), none);
  EXPECT_EQ(active.selection().status, Status::deadline_reached);
  EXPECT_EQ(indices_of(active.selection()), (std::vector<std::uint32_t>{batch[5], batch[1], batch[3], batch[4]}));
}

}  // namespace
}  // namespace maxlogdet::test
