// SPDX-License-Identifier: MIT
#include "cli/report.hpp"

#include "bench/world/table.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>
#include <vector>

namespace maxlogdet::sim {
namespace {

constexpr double hundred = 100;  // percent
constexpr double milli = 1e3;
constexpr const char* parts[] = {"translation", "rotation"};

nlohmann::ordered_json to_json(const Statistic& estimate, double unit) {
  return {
      {"value", unit * estimate.value}, {"low", unit * estimate.interval.low}, {"high", unit * estimate.interval.high}};
}

nlohmann::ordered_json to_json(const EvaluationRow& from) {
  nlohmann::ordered_json row = {{"selector", from.selector},
                                {"budget", from.budget},
                                {"has_budget", from.has_budget},
                                {"frames", from.frames},
                                {"wrong_percent", to_json(from.wrong, hundred)}};
  for (std::size_t part = 0; part < 2; ++part) {
    const Cost& cost = from.costs[part];
    nlohmann::ordered_json growth = to_json(cost.growth, hundred);
    growth["predicted"] = hundred * cost.predicted;
    row[parts[part] + std::string("_growth_percent")] = growth;
    row[parts[part] + std::string("_of_random")] = to_json(cost.of_random, 1);
    if (from.steps > 0) row[parts[part] + std::string("_true_growth_percent")] = to_json(cost.true_growth, hundred);
  }
  if (from.steps > 0) row["true_steps"] = from.steps;
  return row;
}

// "12 (9 to 15)", and below ten with one decimal.
std::string percent(const Statistic& share) {
  if (std::isnan(share.value)) return "";
  const auto number = [](double value) { return fixed(hundred * value, std::abs(value) < 0.0995 ? 1 : 0); };
  return number(share.value) + " (" + number(share.interval.low) + " to " + number(share.interval.high) + ")";
}

// A row for each selector, and a column for each budget; the last is of selectors that have their own number.
template <class Cell>
std::string table_text(const Evaluation& evaluation, const std::string& title, const Cell& cell) {
  std::set<std::size_t> budgets;
  for (const EvaluationRow& row : evaluation.rows) {
    if (row.has_budget) budgets.insert(row.budget);
  }
  Table table;
  table.header = {"selector"};
  for (const std::size_t budget : budgets) table.header.push_back(std::to_string(budget));
  table.header.emplace_back("own number");
  for (const EvaluationRow& row : evaluation.rows) {
    if (table.rows.empty() || table.rows.back()[0] != row.selector) {
      table.rows.emplace_back(table.header.size());
      table.rows.back()[0] = row.selector;
    }
    const auto column = row.has_budget ? std::distance(budgets.begin(), budgets.find(row.budget)) + 1
                                       : static_cast<std::ptrdiff_t>(table.header.size()) - 1;
    table.rows.back()[static_cast<std::size_t>(column)] =
        percent(cell(row)) + (row.has_budget ? "" : " of " + std::to_string(row.budget));
  }
  return "\n" + title + "\n\n" + to_markdown(table);
}

std::string noise_text(const Evaluation& evaluation) {
  std::string text =
      "\nChi-squared by leverage, lowest to highest tenth of the matches (1: noise as large as modelled):\n ";
  for (const Statistic& chi2 : evaluation.chi2_by_leverage) text += " " + fixed(chi2.value, 2);
  const Statistic& correlation = evaluation.cell_correlation;
  return text + "\nCorrelation of residuals of neighbours, in a cell of 8 x 6 (0: independent errors): " +
         fixed(correlation.value, 3) + " (" + fixed(correlation.interval.low, 3) + " to " +
         fixed(correlation.interval.high, 3) + ")\n";
}

std::string frames_text(const Evaluation& evaluation) {
  const auto count = [](double matches) { return std::to_string(std::lround(matches)); };
  std::string text = std::to_string(evaluation.frames) + " frames, " + count(evaluation.matches) +
                     " matches, of which " + count(evaluation.inliers) + " inliers";
  if (evaluation.unusable > 0) text += " (" + std::to_string(evaluation.unusable) + " without a pose left out)";
  if (evaluation.unaligned > 0) text += ", " + std::to_string(evaluation.unaligned) + " frames not aligned";
  return text + "\n";
}

}  // namespace

nlohmann::ordered_json to_json(const Evaluation& evaluation) {
  const Verdict verdict = verdict_of(evaluation);
  nlohmann::ordered_json json = {{"frames", evaluation.frames},
                                 {"frames_unusable", evaluation.unusable},
                                 {"frames_unaligned", evaluation.unaligned},
                                 {"matches", evaluation.matches},
                                 {"inliers", evaluation.inliers},
                                 {"translation_sigma_mm", milli * evaluation.sigmas(0)},
                                 {"rotation_sigma_mrad", milli * evaluation.sigmas(1)},
                                 {"verdict", verdict.text},
                                 {"advice", verdict.advice},
                                 {"recommended", verdict.recommended},
                                 {"shares_errors", verdict.shares_errors},
                                 {"chi2", evaluation.chi2}};
  json["chi2_by_leverage"] = nlohmann::ordered_json::array();
  for (const Statistic& chi2 : evaluation.chi2_by_leverage) json["chi2_by_leverage"].push_back(to_json(chi2, 1));
  json["cell_correlation"] = to_json(evaluation.cell_correlation, 1);
  json["selectors"] = nlohmann::ordered_json::array();
  for (const EvaluationRow& row : evaluation.rows) json["selectors"].push_back(to_json(row));
  return json;
}

std::string to_text(const Evaluation& evaluation) {
  const Verdict verdict = verdict_of(evaluation);
  std::string text = verdict.text + "\n\n";
  for (const std::string& advice : verdict.advice) text += "- " + advice + "\n";
  text += (verdict.advice.empty() ? "" : "\n") + frames_text(evaluation);
  if (!verdict.has_noise) return text;
  text += "The pose of all inliers has a standard deviation of " + fixed(milli * evaluation.sigmas(0), 1) + " mm and " +
          fixed(milli * evaluation.sigmas(1), 2) + " mrad. Columns are budgets; in parentheses are 95 % intervals.\n";
  text += table_text(evaluation, "Wrong matches among the selected, %", [](const auto& row) { return row.wrong; });
  for (std::size_t part = 0; part < 2; ++part) {
    text += table_text(evaluation, std::string("Growth of the standard deviation in ") + parts[part] + ", %",
                       [part](const auto& row) { return row.costs[part].growth; });
  }
  const bool has_truth = std::any_of(evaluation.rows.begin(), evaluation.rows.end(),
                                     [](const EvaluationRow& row) { return row.steps > 0; });
  for (std::size_t part = 0; has_truth && part < 2; ++part) {
    text += table_text(
        evaluation,
        std::string("Growth of the error of the motion between frames against the true one in ") + parts[part] + ", %",
        [part](const auto& row) { return row.costs[part].true_growth; });
  }
  return text + noise_text(evaluation);
}

}  // namespace maxlogdet::sim
