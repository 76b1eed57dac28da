// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/robustness_report.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <tuple>

namespace maxlogdet::sim {
namespace {

using Error = double RobustnessOutcome::*;
using Key = std::tuple<Disturbance, SelectorKind, std::size_t>;

Key key_of(const RobustnessCase& which) { return {which.disturbance, which.selector, which.budget}; }

// Errors of a case over the runs.
class Errors {
 public:
  Errors(const RobustnessOptions& options, const RobustnessRuns& runs) : runs_(runs), matches_(options.matches) {
    const std::vector<RobustnessCase> cases = robustness_cases(options);
    for (std::size_t c = 0; c < cases.size(); ++c) place_[key_of(cases[c])] = c;
  }

  std::vector<double> of(const RobustnessCase& which, Error error) const {
    const std::size_t budget = which.selector == SelectorKind::all ? matches_ : which.budget;
    const std::size_t c = place_.at({which.disturbance, which.selector, budget});
    std::vector<double> errors;
    for (const auto& run : runs_) errors.push_back(run.at(c).*error);
    return errors;
  }

  // md's difference in percent of this selector's error.
  Estimate difference(Disturbance disturbance, SelectorKind other, std::size_t budget, Error error) const {
    return rms_change_percent(of({disturbance, SelectorKind::md, budget}, error),
                              of({disturbance, other, budget}, error));
  }

 private:
  const RobustnessRuns& runs_;
  std::size_t matches_;
  std::map<Key, std::size_t> place_;
};

std::map<Key, const RobustnessRow*> by_case(const std::vector<RobustnessRow>& rows) {
  std::map<Key, const RobustnessRow*> result;
  for (const RobustnessRow& row : rows) result[key_of(row.which)] = &row;
  return result;
}

std::string with_verdict(const Estimate& difference) {
  return fixed(difference, 1) + (std::isnan(difference.ci95) ? "" : std::string(" ") + verdict(difference));
}

std::vector<std::size_t> sorted(std::vector<std::size_t> budgets) {
  std::sort(budgets.begin(), budgets.end());
  return budgets;
}

}  // namespace

std::vector<RobustnessRow> summarize(const RobustnessOptions& options, const RobustnessRuns& runs) {
  if (runs.empty()) return {};
  const Errors errors(options, runs);
  std::vector<RobustnessRow> rows;
  for (const RobustnessCase& which : robustness_cases(options)) {
    const std::size_t budget = which.selector == SelectorKind::all ? sorted(options.budgets).back() : which.budget;
    const auto difference = [&](Error error) {
      return errors.difference(which.disturbance, which.selector, budget, error);
    };
    rows.push_back({which, rms_of(errors.of(which, &RobustnessOutcome::translation_m)),
                    rms_of(errors.of(which, &RobustnessOutcome::rotation_deg)),
                    difference(&RobustnessOutcome::translation_m), difference(&RobustnessOutcome::rotation_deg)});
  }
  return rows;
}

Table robustness_table(const std::vector<RobustnessRow>& rows, std::size_t runs) {
  Table table;
  table.header = {"disturbance",
                  "selector",
                  "budget",
                  "rms_translation_m",
                  "ci95_translation_m",
                  "rms_rotation_deg",
                  "ci95_rotation_deg",
                  "md_translation_percent",
                  "ci95_md_translation_percent",
                  "md_rotation_percent",
                  "ci95_md_rotation_percent",
                  "runs"};
  for (const RobustnessRow& row : rows) {
    table.rows.push_back(
        {to_string(row.which.disturbance), to_string(row.which.selector), std::to_string(row.which.budget)});
    for (const Estimate& one :
         {row.translation_m, row.rotation_deg, row.md_translation_percent, row.md_rotation_percent}) {
      table.rows.back().push_back(exact(one.value));
      table.rows.back().push_back(exact(one.ci95));
    }
    table.rows.back().push_back(std::to_string(runs));
  }
  return table;
}

Table robustness_levels(const RobustnessOptions& options, const std::vector<RobustnessRow>& rows, std::size_t budget) {
  const auto found = by_case(rows);
  Table table;
  table.header = {"disturbance"};
  const SelectorKind shown[] = {SelectorKind::md, SelectorKind::random, SelectorKind::all};
  for (const char* const unit : {" (m)", " (deg)"}) {
    for (const SelectorKind kind : shown) table.header.push_back(to_string(kind) + std::string(unit));
  }
  for (const Disturbance disturbance : options.disturbances) {
    table.rows.push_back({to_string(disturbance)});
    for (const auto error : {&RobustnessRow::translation_m, &RobustnessRow::rotation_deg}) {
      for (const SelectorKind kind : shown) {
        const std::size_t of_kind = kind == SelectorKind::all ? options.matches : budget;
        table.rows.back().push_back(fixed(found.at({disturbance, kind, of_kind})->*error, 4));
      }
    }
  }
  return table;
}

Table robustness_differences(const RobustnessOptions& options, const RobustnessRuns& runs, std::size_t budget) {
  const Errors errors(options, runs);
  Table table;
  table.header = {"md against"};
  for (const SelectorKind kind : robustness_kinds) {
    if (kind != SelectorKind::md) table.header.emplace_back(to_string(kind));
  }
  for (const Disturbance disturbance : options.disturbances) {
    table.rows.push_back({to_string(disturbance)});
    for (const SelectorKind kind : robustness_kinds) {
      if (kind == SelectorKind::md) continue;
      const auto cell = [&](Error error) { return with_verdict(errors.difference(disturbance, kind, budget, error)); };
      table.rows.back().push_back(cell(&RobustnessOutcome::translation_m) + ", " +
                                  cell(&RobustnessOutcome::rotation_deg));
    }
  }
  return table;
}

}  // namespace maxlogdet::sim
