// SPDX-License-Identifier: MIT
// Batches of proposals against the model of the fuzz target, which recomputes every gain, with requests and answers of
// every kind.
#include "tests/fuzz/active_model.hpp"
#include "tests/fuzz/require.hpp"
#include "tests/support/request.hpp"
#include "tests/support/sweeps.hpp"

#include <algorithm>
#include <type_traits>
#include <utility>

namespace maxlogdet::test {
namespace {

constexpr std::uint32_t none = ActiveSelection::none;

// An active selection and its model.
class Batches {
 public:
  Batches(Random& random, const Problem& problem)
      : random_(random),
        options_(problem.options()),
        model_(problem.blocks, options_, 1e-9L),
        active_(problem.capacity()),
        size_(problem.blocks.size()) {
    EXPECT_EQ(active_.start(problem.blocks, options_), Error::none);
    begin_round();
  }

  void run(int max_batch, double rejected_share) {
    rejected_share_ = rejected_share;
    while (propose(max_batch)) {
      while (!model_.pending().empty()) answer();
    }
    EXPECT_FALSE(propose(1));
    answer_all(0);
    answer_all(1);
    expect_accepted();
  }

 private:
  // Asks for up to `max_wanted`; returns false if nothing is proposed.
  bool propose(int max_wanted) {
    const auto wanted = static_cast<std::size_t>(random_.integer(1, max_wanted));
    std::vector<std::uint32_t> proposed(wanted + 1, none);
    proposed.resize(active_.next(proposed.data(), wanted));
    model_.check_next(proposed, wanted);
    EXPECT_LE(active_.selection().evaluations - evaluations_, open_) << "twice since the last acceptance";
    EXPECT_EQ(active_.next(), proposed.empty() ? none : proposed.front());
    return !proposed.empty();
  }

  void begin_round() {
    accepted_ = model_.accepted_count();
    evaluations_ = active_.selection().evaluations;
    open_ = model_.open_count();
  }

  void expect_accepted() {
    model_.check_selection(active_.selection());
    if (model_.accepted_count() != accepted_) begin_round();
  }

  void answer() {
    if (random_.chance(0.3)) propose(20);  // the same again
    if (random_.chance(0.3)) answer_wrongly();
    const std::size_t count = model_.pending().size();
    switch (random_.integer(0, 4)) {
      case 0: answer_all(count); break;
      case 1: is_matched() ? note(none, true, active_.accept()) : note(none, false, active_.reject()); break;
      default: answer_by_index(model_.pending()[random_.index(count)]);
    }
    expect_accepted();
  }

  bool is_matched() { return !random_.chance(rejected_share_); }

  void note(std::uint32_t index, bool is_accepted, Error error, const Block* measured = nullptr) {
    model_.answer(error, index, is_accepted, measured);
  }

  void answer_all(std::size_t count) {
    std::vector<unsigned char> matched;
    for (std::size_t j = 0; j < count; ++j) matched.push_back(is_matched() ? 255 : 0);
    matched.reserve(1);  // not null
    model_.answer_all(active_.answer(matched.data(), count), matched);
  }

  void answer_by_index(std::uint32_t i) {
    if (!is_matched()) {
      note(i, false, active_.reject(i));
    } else if (random_.chance(0.3)) {
      const Block measured = rounded(random_block(random_, random_.integer(1, 3)));
      note(i, true, active_.accept(i, measured.data(), static_cast<int>(measured.rows())), &measured);
    } else {
      note(i, true, active_.accept(i));
    }
    note(i, false, active_.reject(i));  // answered already
  }

  // Answers to candidates that are not proposed and with what is no block, and requests for no proposal.
  void answer_wrongly() {
    const auto any = static_cast<std::uint32_t>(random_.index(size_ + 4));
    const Block block = random_block(random_, 2);
    const std::vector<std::uint32_t>& pending = model_.pending();
    if (std::find(pending.begin(), pending.end(), any) == pending.end()) {
      note(any, true, active_.accept(any));
      note(any, true, active_.accept(any, block.data(), 2), &block);
      note(any, false, active_.reject(any));
    }
    model_.refuse(active_.accept(any, nullptr, 2), any);
    model_.refuse(active_.accept(pending.front(), block.data(), 4), pending.front());
    model_.refuse(active_.accept(block.data(), 0), none);
    EXPECT_EQ(active_.accept(none), Error::nothing_proposed);
    for (const std::size_t count : {pending.size() + 1, pending.size() - 1, std::size_t{0}}) answer_all(count);
    EXPECT_EQ(active_.answer(nullptr, pending.size()), Error::nothing_proposed);
    std::uint32_t untouched = 123;
    EXPECT_EQ(active_.next(nullptr, 5), 0U);
    EXPECT_EQ(active_.next(&untouched, 0), 0U);
    EXPECT_EQ(untouched, 123U);
    expect_accepted();
  }

  Random& random_;
  Options options_;
  fuzz::ActiveModel model_;
  ActiveSelection active_;
  std::size_t size_;
  double rejected_share_ = 0;
  std::size_t accepted_ = 0, evaluations_ = 0, open_ = 0;  // at the last acceptance
};

// Mostly few candidates, and now and then a thousand.
TEST(ActiveSelection, batches_are_the_best_of_what_is_left_and_keep_to_constraints) {
  for_each_trial(820, [](Random& random) {
    const ForcedIsa forced = any_isa(random);
    const bool are_many = random.chance(1.0 / 40);
    Problem problem = any_problem(random, are_many ? 1000 : static_cast<std::size_t>(random.integer(1, 150)));
    if (are_many) problem.plain.budget = std::max<std::size_t>(60, problem.required_count() + 30);
    try {
      Batches(random, problem).run(random.integer(1, 40), random.uniform(0, 0.95));
    } catch (const fuzz::Violation& violation) {
      ADD_FAILURE() << violation.what();
    }
  });
}

// Where proposals end must not depend on what else an instruction set has evaluated.
TEST(ActiveSelection, batches_are_the_same_on_every_instruction_set) {
  for_each_trial(100, [](Random& random) {
    const Problem problem = any_problem(random, static_cast<std::size_t>(random.integer(1, 300)));
    same_on_every_isa([&] {
      Random answers = random;
      ActiveSelection active(problem.capacity());
      EXPECT_EQ(active.start(problem.blocks, problem.options()), Error::none);
      std::vector<std::uint32_t> proposed;
      std::uint32_t batch[10];
      while (const std::size_t count = active.next(batch, static_cast<std::size_t>(answers.integer(1, 10)))) {
        proposed.insert(proposed.end(), batch, batch + count);
        proposed.push_back(none);
        for (std::size_t j = 0; j < count; ++j) answers.chance(0.5) ? active.accept() : active.reject();
      }
      return proposed;
    });
  });
}

template <class Answer, class = void>
struct Accepts : std::false_type {};
template <class Answer>
struct Accepts<Answer, decltype(std::declval<ActiveSelection&>().accept(std::declval<Answer>()), void())>
    : std::true_type {};
static_assert(Accepts<std::uint32_t>::value && Accepts<int>::value, "an index");
static_assert(!Accepts<bool>::value, "whether it was matched is no index");

}  // namespace
}  // namespace maxlogdet::test
