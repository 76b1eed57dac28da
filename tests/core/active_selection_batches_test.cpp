// SPDX-License-Identifier: MIT
// Batches of proposals against a model that recomputes every gain, with requests and answers of every kind.
#include "tests/core/active_selection_model.hpp"
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
      : random_(random), options_(problem.options()), model_(problem), active_(problem.capacity()) {
    EXPECT_EQ(active_.start(problem.blocks, options_), Error::none);
    for (const std::uint32_t i : active_.selection()) accepted_.push_back(i);
    begin_round();
  }

  void run(std::size_t max_batch, double rejected_share) {
    rejected_share_ = rejected_share;
    while (propose(static_cast<std::size_t>(random_.integer(1, static_cast<int>(max_batch))))) {
      while (!unanswered_.empty() && !::testing::Test::HasFatalFailure()) answer();
      if (::testing::Test::HasFatalFailure()) return;
    }
    expect_end();
  }

 private:
  // Returns false at the end.
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

  // Answers to candidates that are not proposed, and requests for no proposal.
  void expect_no_effect() {
    const auto any = static_cast<std::uint32_t>(random_.integer(0, static_cast<int>(model_.size()) + 3));
    const Block block = random_block(random_, 2);
    if (std::find(unanswered_.begin(), unanswered_.end(), any) == unanswered_.end()) {
      EXPECT_EQ(active_.accept(any), Error::nothing_proposed);
      EXPECT_EQ(active_.accept(any, block.data(), 2), Error::nothing_proposed);
      EXPECT_EQ(active_.accept(any, nullptr, 2), Error::nothing_proposed);
      EXPECT_EQ(active_.reject(any), Error::nothing_proposed);
    }
    EXPECT_EQ(active_.accept(none), Error::nothing_proposed);
    const std::vector<unsigned char> matched(unanswered_.size() + 1, 1);
    EXPECT_EQ(active_.answer(matched.data(), unanswered_.size() + 1), Error::nothing_proposed);
    EXPECT_EQ(active_.answer(matched.data(), unanswered_.size() - 1), Error::nothing_proposed);
    EXPECT_EQ(active_.answer(matched.data(), 0), Error::nothing_proposed);
    EXPECT_EQ(active_.answer(nullptr, unanswered_.size()), Error::nothing_proposed);
    std::uint32_t untouched = 123;
    EXPECT_EQ(active_.next(nullptr, 5), 0U);
    EXPECT_EQ(active_.next(&untouched, 0), 0U);
    EXPECT_EQ(untouched, 123U);
    EXPECT_EQ(active_.accept(unanswered_.back(), nullptr, 2), Error::invalid_block);
    EXPECT_EQ(active_.accept(unanswered_.front(), block.data(), 4), Error::invalid_block);
    EXPECT_EQ(active_.accept(block.data(), 0), Error::invalid_block);
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
    ASSERT_EQ(active_.answer(matched.data(), matched.size()), Error::none);
    const std::vector<std::uint32_t> answered = unanswered_;
    for (std::size_t j = 0; j < answered.size(); ++j) note(answered[j], matched[j] != 0);
  }

  void answer_first() {
    const std::uint32_t i = unanswered_.front();
    const bool accepts = is_matched();
    ASSERT_EQ(accepts ? active_.accept() : active_.reject(), Error::none);
    note(i, accepts);
  }

  void answer_by_index() {
    const std::uint32_t i = unanswered_[random_.index(unanswered_.size())];
    if (!is_matched()) {
      ASSERT_EQ(active_.reject(i), Error::none);
      note(i, false);
    } else if (random_.chance(0.3)) {
      const Block measured = rounded(random_block(random_, random_.integer(1, 3)));
      ASSERT_EQ(active_.accept(i, measured.data(), static_cast<int>(measured.rows())), Error::none);
      note(i, true, &measured);
    } else {
      ASSERT_EQ(active_.accept(i), Error::none);
      note(i, true);
    }
    ASSERT_EQ(active_.reject(i), Error::nothing_proposed) << "answered already";
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
    EXPECT_EQ(active_.answer(matched.data(), 0), Error::nothing_proposed);
    EXPECT_EQ(active_.answer(matched.data(), 1), Error::nothing_proposed);
    const Selection selection = active_.selection();
    EXPECT_EQ(selection.status, model_.open_count() == 0 ? Status::all_selected : Status::ok);
    EXPECT_NEAR(selection.log_det, model_.log_det(), 1e-7);
  }

  Random& random_;
  Options options_;
  ActiveModel model_;
  ActiveSelection active_;
  double rejected_share_ = 0;
  std::vector<std::uint32_t> unanswered_, accepted_;
  std::size_t evaluations_ = 0;  // at the last acceptance
  std::size_t open_ = 0;         // candidates at the last acceptance
};

// Mostly few candidates, and now and then a thousand.
TEST(ActiveSelection, batches_are_the_best_of_what_is_left_and_keep_to_constraints) {
  for_each_trial(820, [](Random& random) {
    const ForcedIsa forced = any_isa(random);
    const bool are_many = random.chance(1.0 / 40);
    Problem problem = any_problem(random, are_many ? 1000 : static_cast<std::size_t>(random.integer(1, 150)));
    if (are_many) problem.plain.budget = std::max<std::size_t>(60, problem.required_count() + 30);
    Batches(random, problem).run(static_cast<std::size_t>(random.integer(1, 40)), random.uniform(0, 0.95));
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
