// SPDX-License-Identifier: MIT
#include "bench/does_it_help/verdict.hpp"

#include "bench/world/table.hpp"

#include <cmath>
#include <cstdlib>

namespace maxlogdet::sim {
namespace {

constexpr std::size_t usual_budget = 100;
constexpr std::size_t enough_frames = 10;  // with fewer an interval means nothing
constexpr double most_of_all = 0.8;        // of the inliers: a larger budget leaves nothing to choose

std::size_t budget_next_to_usual(const Evaluation& evaluation) {
  std::size_t best = 0;
  const auto distance = [](std::size_t budget) {
    return std::abs(static_cast<double>(budget) - static_cast<double>(usual_budget));
  };
  for (const EvaluationRow& row : evaluation.rows) {
    if (row.selector == "md" && row.frames > 0 && (best == 0 || distance(row.budget) < distance(best)))
      best = row.budget;
  }
  return best;
}

bool pays(const EvaluationRow& row) { return row.worth_random->interval.low > static_cast<double>(row.budget); }
bool loses(const EvaluationRow& row) { return row.worth_random->interval.high < static_cast<double>(row.budget); }

std::string worth_text(const EvaluationRow& row) {
  const auto count = [](double matches) { return std::to_string(std::lround(matches)); };
  const Worth& random = *row.worth_random;
  return std::to_string(row.budget) + " of your matches give the pose that " + count(random.matches) +
         " random ones give (95 % interval " + count(random.interval.low) + " to " + count(random.interval.high) +
         "), or " + count(row.worth_bucket->matches) + " spread over image cells";
}

// The pose of all inliers is no truth where matches share errors.
std::string caution_of(const Evaluation& evaluation, const EvaluationRow& best) {
  const EvaluationRow* const random = evaluation.row("random", best.budget);
  if (!best.truth || random == nullptr || !random->truth) {
    return ". The pose of all inliers shares these errors: this tells how near a selection is to it, not to the truth";
  }
  return ". Against the true poses the error in translation is " + fixed(best.truth->translation_ratio, 2) +
         " times that of all inliers, with as many random matches " + fixed(random->truth->translation_ratio, 2) +
         " times";
}

}  // namespace

Verdict verdict_of(const Evaluation& evaluation) {
  Verdict verdict;
  const Correlation& all = evaluation.cell_correlation;
  verdict.shares_errors = all.value > shared_from && all.interval.low > shared_from / 2;
  verdict.recommended = verdict.shares_errors ? "md_spread" : "md";
  const std::size_t budget = budget_next_to_usual(evaluation);
  const EvaluationRow* const row = evaluation.row(verdict.recommended, budget);
  if (row == nullptr || row->frames == 0) {
    verdict.text = "These frames cannot tell: none has more matches than the smallest budget.";
    return verdict;
  }
  const EvaluationRow& best = *row;
  if (static_cast<double>(budget) > most_of_all * evaluation.inliers) {
    verdict.text = "These frames cannot tell: " + std::to_string(budget) + " matches are nearly all of some " +
                   std::to_string(std::lround(evaluation.inliers)) + " inliers; choose smaller --budgets.";
    return verdict;
  }
  if (best.frames < enough_frames) {
    verdict.text = "These frames cannot tell: only " + std::to_string(best.frames) + " have more than " +
                   std::to_string(budget) + " matches; record at least " + std::to_string(enough_frames) +
                   ", better a hundred.";
    return verdict;
  }
  if (verdict.shares_errors) {
    verdict.text = "Your matches share errors: neighbours are correlated by " + fixed(all.value, 2) +
                   ", those that Max-logDet selects by " + fixed(evaluation.cell_correlation_selected.value, 2) + ". ";
    verdict.text += pays(best) ? "Spread the selection over the image (md_spread), which still pays: "
                               : "Spread the selection over the image (md_spread), or do not select: ";
    verdict.text += worth_text(best) + caution_of(evaluation, best);
  } else if (pays(best)) {
    verdict.text = "Max-logDet pays: " + worth_text(best);
  } else if (loses(best)) {
    verdict.text = "Max-logDet does not help here: " + worth_text(best);
    verdict.recommended = "random";
  } else {
    verdict.text = "These frames cannot tell whether Max-logDet helps: " + worth_text(best) + "; record more of them";
  }
  verdict.text += ".";
  return verdict;
}

}  // namespace maxlogdet::sim
