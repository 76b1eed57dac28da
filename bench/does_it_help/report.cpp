// SPDX-License-Identifier: MIT
#include "bench/does_it_help/report.hpp"

#include "bench/does_it_help/verdict.hpp"

#include <cmath>
#include <utility>
#include <vector>

namespace maxlogdet::sim {
namespace {

constexpr double milli = 1e3;

nlohmann::ordered_json to_json(const Interval& interval) { return {{"low", interval.low}, {"high", interval.high}}; }

nlohmann::ordered_json to_json(const DeviationSummary& deviation) {
  return {{"median", milli * deviation.median},
          {"low", milli * deviation.of_median.low},
          {"high", milli * deviation.of_median.high},
          {"p90", milli * deviation.p90},
          {"predicted", milli * deviation.predicted},
          {"predicted_p90", milli * deviation.predicted_p90},
          {"ratio", deviation.median / deviation.predicted},
          {"ratio_low", deviation.of_median.low / deviation.predicted},
          {"ratio_high", deviation.of_median.high / deviation.predicted}};
}

void add_worth(const std::string& name, const std::optional<Worth>& worth, nlohmann::ordered_json& row) {
  if (!worth) return;
  row[name] = worth->matches;
  row[name + "_low"] = worth->interval.low;
  row[name + "_high"] = worth->interval.high;
}

nlohmann::ordered_json to_json(const EvaluationRow& from) {
  nlohmann::ordered_json row = {{"selector", from.selector},
                                {"budget", from.budget},
                                {"frames", from.frames},
                                {"translation_mm", to_json(from.translation)},
                                {"rotation_mrad", to_json(from.rotation)}};
  add_worth("worth_random", from.worth_random, row);
  add_worth("worth_bucket", from.worth_bucket, row);
  if (!from.truth) return row;
  const TruthSummary& truth = *from.truth;
  row["truth"] = {{"steps", truth.steps},
                  {"translation_mm", milli * truth.median_m},
                  {"translation_of_all", truth.translation_ratio},
                  {"translation_of_all_low", truth.of_translation_ratio.low},
                  {"translation_of_all_high", truth.of_translation_ratio.high},
                  {"rotation_mrad", milli * truth.median_rad},
                  {"rotation_of_all", truth.rotation_ratio},
                  {"rotation_of_all_low", truth.of_rotation_ratio.low},
                  {"rotation_of_all_high", truth.of_rotation_ratio.high}};
  return row;
}

// "3.48 (2.71 to 3.97)"
std::string with_interval(double value, const Interval& interval, int decimals) {
  return fixed(value, decimals) + " (" + fixed(interval.low, decimals) + " to " + fixed(interval.high, decimals) + ")";
}

std::string with_interval(const std::optional<Worth>& worth) {
  return worth ? with_interval(worth->matches, worth->interval, 0) : "";
}

std::vector<std::string> cells_of(const DeviationSummary& deviation, int decimals) {
  const Interval interval = {milli * deviation.of_median.low, milli * deviation.of_median.high};
  return {with_interval(milli * deviation.median, interval, decimals), fixed(milli * deviation.predicted, decimals)};
}

Table shown_table(const Evaluation& evaluation) {
  Table table;
  table.header = {"selector",        "matches",   "translation (mm)", "predicted",
                  "rotation (mrad)", "predicted", "worth random",     "worth bucket"};
  for (const EvaluationRow& row : evaluation.rows) {
    std::vector<std::string> cells = {row.selector, std::to_string(row.budget)};
    for (std::string& cell : cells_of(row.translation, 2)) cells.push_back(std::move(cell));
    for (std::string& cell : cells_of(row.rotation, 3)) cells.push_back(std::move(cell));
    cells.push_back(with_interval(row.worth_random));
    cells.push_back(with_interval(row.worth_bucket));
    table.rows.push_back(std::move(cells));
  }
  return table;
}

Table truth_table(const Evaluation& evaluation) {
  Table table;
  table.header = {"selector", "matches", "translation, of all's", "rotation, of all's", "steps"};
  for (const EvaluationRow& row : evaluation.rows) {
    if (!row.truth) continue;
    table.rows.push_back({row.selector, std::to_string(row.budget),
                          with_interval(row.truth->translation_ratio, row.truth->of_translation_ratio, 2),
                          with_interval(row.truth->rotation_ratio, row.truth->of_rotation_ratio, 2),
                          std::to_string(row.truth->steps)});
  }
  return table;
}

std::string noise_text(const Evaluation& evaluation) {
  std::string text =
      "Chi-squared by leverage, lowest to highest tenth of the matches (1: noise as large as modelled):\n ";
  for (const double chi2 : evaluation.chi2_by_leverage) text += " " + fixed(chi2, 2);
  const Correlation& all = evaluation.cell_correlation;
  const Correlation& selected = evaluation.cell_correlation_selected;
  text +=
      "\nCorrelation of whitened residuals of neighbours, in a cell of 8 x 6 (0: independent errors):\n  all inliers " +
      with_interval(all.value, all.interval, 3) + ", those that md selects " +
      with_interval(selected.value, selected.interval, 3);
  if (!std::isnan(evaluation.static_correlation)) {
    text += ";\n  the part that stays at a place of the image (calibration) " + fixed(evaluation.static_correlation, 3);
  }
  return text + "\n";
}

}  // namespace

nlohmann::ordered_json to_json(const Evaluation& evaluation) {
  const Verdict verdict = verdict_of(evaluation);
  nlohmann::ordered_json json = {{"frames", evaluation.frames},
                                 {"frames_unusable", evaluation.unusable},
                                 {"matches", evaluation.matches},
                                 {"inliers", evaluation.inliers},
                                 {"verdict", verdict.text},
                                 {"recommended", verdict.recommended},
                                 {"shares_errors", verdict.shares_errors},
                                 {"chi2_by_leverage", evaluation.chi2_by_leverage}};
  json["chi2_by_leverage_intervals"] = nlohmann::ordered_json::array();
  for (const Interval& interval : evaluation.of_chi2) json["chi2_by_leverage_intervals"].push_back(to_json(interval));
  json["cell_correlation"] = evaluation.cell_correlation.value;
  json["cell_correlation_interval"] = to_json(evaluation.cell_correlation.interval);
  json["cell_correlation_selected"] = evaluation.cell_correlation_selected.value;
  json["cell_correlation_selected_interval"] = to_json(evaluation.cell_correlation_selected.interval);
  json["cell_correlation_static"] = evaluation.static_correlation;
  json["selectors"] = nlohmann::ordered_json::array();
  for (const EvaluationRow& row : evaluation.rows) json["selectors"].push_back(to_json(row));
  return json;
}

std::string to_text(const Evaluation& evaluation) {
  std::string text = verdict_of(evaluation).text + "\n\n" + std::to_string(evaluation.frames) + " frames, " +
                     std::to_string(std::lround(evaluation.matches)) + " matches, of which " +
                     std::to_string(std::lround(evaluation.inliers)) + " inliers";
  if (evaluation.unusable > 0) text += " (" + std::to_string(evaluation.unusable) + " frames without a pose left out)";
  text += "\n\n" + noise_text(evaluation);
  text +=
      "\nDeviation of the pose of the selected from the pose of all inliers, from the same start: median over frames\n"
      "(95 % interval), what independent noise of the modelled size predicts, and how many random matches, or random\n"
      "ones spread over image cells (bucket), give the same pose.\n\n" +
      to_markdown(shown_table(evaluation));
  const Table truth = truth_table(evaluation);
  if (truth.rows.empty()) return text;
  return text +
         "\nMedian error of the motion between frames against the true one, in multiples of that with all "
         "inliers.\n\n" +
         to_markdown(truth);
}

Table deviation_table(const Evaluation& evaluation) {
  Table table;
  table.header = {"selector",
                  "budget",
                  "frames",
                  "translation_mm",
                  "translation_low_mm",
                  "translation_high_mm",
                  "translation_p90_mm",
                  "translation_predicted_mm",
                  "rotation_mrad",
                  "rotation_low_mrad",
                  "rotation_high_mrad",
                  "rotation_p90_mrad",
                  "rotation_predicted_mrad",
                  "worth_random",
                  "worth_bucket"};
  for (const EvaluationRow& row : evaluation.rows) {
    table.rows.push_back({row.selector, std::to_string(row.budget), std::to_string(row.frames)});
    std::vector<std::string>& cells = table.rows.back();
    for (const DeviationSummary* const part : {&row.translation, &row.rotation}) {
      for (const double value : {part->median, part->of_median.low, part->of_median.high, part->p90, part->predicted}) {
        cells.push_back(exact(milli * value));
      }
    }
    for (const auto& worth : {row.worth_random, row.worth_bucket}) cells.push_back(worth ? exact(worth->matches) : "");
  }
  return table;
}

Table leverage_table(const Evaluation& evaluation) {
  Table table;
  table.header = {"decile", "chi2", "low", "high"};
  for (std::size_t d = 0; d < leverage_classes; ++d) {
    table.rows.push_back({std::to_string(d + 1), exact(evaluation.chi2_by_leverage[d]),
                          exact(evaluation.of_chi2[d].low), exact(evaluation.of_chi2[d].high)});
  }
  return table;
}

}  // namespace maxlogdet::sim
