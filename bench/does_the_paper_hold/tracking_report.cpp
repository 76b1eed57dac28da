// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/tracking_report.hpp"

#include "bench/does_the_paper_hold/estimate.hpp"
#include "bench/world/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

namespace maxlogdet::sim {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

struct ErrorKind {
  const char* name;
  const char* unit;
  double TrajectoryErrors::*member;
};
constexpr ErrorKind ate = {"ATE", "m", &TrajectoryErrors::ate_m};
constexpr ErrorKind rpe = {"RPE", "m/s", &TrajectoryErrors::rpe_m_per_s};
constexpr ErrorKind roe = {"ROE", "deg/s", &TrajectoryErrors::roe_deg_per_s};

bool is_kind(const std::string& name, bool (*holds)(SelectorKind)) {
  return std::any_of(std::begin(selector_kinds), std::end(selector_kinds),
                     [&](SelectorKind kind) { return name == to_string(kind) && holds(kind); });
}

std::vector<double> errors_of(const TrackingRuns& runs, const std::string& sequence, std::size_t contestant,
                              const ErrorKind& kind) {
  std::vector<double> errors;
  for (const TrackingRun& run : runs.runs) {
    if (run.sequence == sequence) errors.push_back(run.outcomes.at(contestant).errors.*kind.member);
  }
  return errors;
}

double plain_mean(const std::vector<double>& values) { return values.empty() ? nan : mean_of(values).value; }

// Means over runs, sequences in rows, contestants in columns.
using Means = std::vector<std::vector<double>>;

Means means_of(const TrackingRuns& runs, const ErrorKind& kind) {
  Means means;
  for (const std::string& sequence : runs.sequences) {
    means.emplace_back();
    for (std::size_t c = 0; c < runs.contestants.size(); ++c) {
      means.back().push_back(plain_mean(errors_of(runs, sequence, c, kind)));
    }
  }
  return means;
}

std::vector<double> column_of(const Means& means, std::size_t c) {
  std::vector<double> column;
  for (const auto& row : means) column.push_back(row[c]);
  return column;
}

// Whether c has the lowest error of those with a budget, or of those without.
bool is_lowest(const TrackingRuns& runs, const std::vector<double>& row, std::size_t c) {
  const bool budget = is_kind(runs.contestants[c], has_budget);
  for (std::size_t other = 0; other < row.size(); ++other) {
    if (is_kind(runs.contestants[other], has_budget) == budget && row[other] < row[c]) return false;
  }
  return true;
}

// Missing numbers are never bold.
std::string bold_if(bool is_bold, const std::string& text) {
  return is_bold && text != "-" ? "**" + text + "**" : text;
}

// Gains and losses against `all`.
struct Against {
  std::vector<double> losses;
  std::vector<double> gains;  // negative
};

Against against_all(const TrackingRuns& runs, const Means& means, std::size_t c) {
  Against result;
  const auto all = std::find(runs.contestants.begin(), runs.contestants.end(), to_string(SelectorKind::all));
  if (all == runs.contestants.end()) return result;
  for (const auto& row : means) {
    const double difference = row[c] - row[static_cast<std::size_t>(all - runs.contestants.begin())];
    if (difference > 0) result.losses.push_back(difference);
    if (difference < 0) result.gains.push_back(difference);
  }
  return result;
}

// Means over sequences of each run that has all of them.
std::vector<double> run_averages(const TrackingRuns& runs, std::size_t c, const ErrorKind& kind) {
  std::map<std::size_t, std::vector<double>> by_run;
  for (const TrackingRun& run : runs.runs) by_run[run.run].push_back(run.outcomes.at(c).errors.*kind.member);
  std::vector<double> averages;
  for (const auto& [run, errors] : by_run) {
    if (errors.size() == runs.sequences.size()) averages.push_back(plain_mean(errors));
  }
  return averages;
}

struct Quartiles {
  double low, lower, median, upper, high;
};

Quartiles quartiles_of(const std::vector<double>& values) {
  return {quantile_of(values, 0), quantile_of(values, 0.25), quantile_of(values, 0.5), quantile_of(values, 0.75),
          quantile_of(values, 1)};
}

std::vector<double> all_errors_of(const TrackingRuns& runs, std::size_t c, const ErrorKind& kind) {
  std::vector<double> errors;
  for (const TrackingRun& run : runs.runs) errors.push_back(run.outcomes.at(c).errors.*kind.member);
  return errors;
}

std::string axis_label(const ErrorKind& kind) { return std::string(kind.name) + " (" + kind.unit + ")"; }

}  // namespace

Table euroc_table(const TrackingRuns& runs) {
  Table table;
  table.header = {"sequence",      "selector",    "run",          "ate_m",  "rpe_m_per_s",
                  "roe_deg_per_s", "ms_outliers", "ms_selection", "ms_pose"};
  for (const TrackingRun& run : runs.runs) {
    for (std::size_t c = 0; c < runs.contestants.size(); ++c) {
      const TrackingOutcome& o = run.outcomes.at(c);
      table.rows.push_back({run.sequence, runs.contestants[c], std::to_string(run.run), exact(o.errors.ate_m),
                            exact(o.errors.rpe_m_per_s), exact(o.errors.roe_deg_per_s), exact(o.ms_outliers),
                            exact(o.ms_selection), exact(o.ms_pose)});
    }
  }
  return table;
}

Table relative_error_table(const TrackingRuns& runs) {
  const Means rpes = means_of(runs, rpe), roes = means_of(runs, roe);
  const std::size_t contestants = runs.contestants.size();
  Table table;
  table.header = {"RPE (m/s), ROE (deg/s)"};
  table.header.insert(table.header.end(), runs.contestants.begin(), runs.contestants.end());
  for (std::size_t s = 0; s < runs.sequences.size(); ++s) {
    table.rows.push_back({runs.sequences[s]});
    for (std::size_t c = 0; c < contestants; ++c) {
      table.rows.back().push_back(bold_if(is_lowest(runs, rpes[s], c), fixed(rpes[s][c], 4)) + " " +
                                  bold_if(is_lowest(runs, roes[s], c), fixed(roes[s][c], 3)));
    }
  }
  std::vector<double> mean_rpes, mean_roes;
  for (std::size_t c = 0; c < contestants; ++c) {
    mean_rpes.push_back(plain_mean(column_of(rpes, c)));
    mean_roes.push_back(plain_mean(column_of(roes, c)));
  }
  std::vector<std::string> averages = {"average"}, worse = {"sequences worse than all"},
                           better = {"sequences better than all"}, loss = {"average loss there"},
                           gain = {"average gain there"};
  for (std::size_t c = 0; c < contestants; ++c) {
    averages.push_back(bold_if(is_lowest(runs, mean_rpes, c), fixed(mean_rpes[c], 4)) + " " +
                       bold_if(is_lowest(runs, mean_roes, c), fixed(mean_roes[c], 3)));
    const Against of_rpe = against_all(runs, rpes, c), of_roe = against_all(runs, roes, c);
    worse.push_back(std::to_string(of_rpe.losses.size()) + " " + std::to_string(of_roe.losses.size()));
    better.push_back(std::to_string(of_rpe.gains.size()) + " " + std::to_string(of_roe.gains.size()));
    loss.push_back(fixed(plain_mean(of_rpe.losses), 4) + " " + fixed(plain_mean(of_roe.losses), 3));
    gain.push_back(fixed(plain_mean(of_rpe.gains), 4) + " " + fixed(plain_mean(of_roe.gains), 3));
  }
  table.rows.insert(table.rows.end(), {averages, worse, better, loss, gain});
  return table;
}

Table average_table(const TrackingRuns& runs) {
  Table table;
  table.header = {"mean over sequences"};
  for (const ErrorKind& kind : {rpe, roe, ate}) table.header.push_back(axis_label(kind));
  for (std::size_t c = 0; c < runs.contestants.size(); ++c) {
    table.rows.push_back({runs.contestants[c]});
    for (const ErrorKind& kind : {rpe, roe, ate}) {
      const std::vector<double> averages = run_averages(runs, c, kind);
      table.rows.back().push_back(averages.empty() ? "-" : fixed(mean_of(averages), 5));
    }
  }
  return table;
}

Table absolute_error_table(const TrackingRuns& runs) {
  const Means means = means_of(runs, ate);
  Table table;
  table.header = {"ATE (m)"};
  table.header.insert(table.header.end(), runs.contestants.begin(), runs.contestants.end());
  for (std::size_t s = 0; s < runs.sequences.size(); ++s) {
    const double lowest = *std::min_element(means[s].begin(), means[s].end());
    table.rows.push_back({runs.sequences[s]});
    for (const double mean : means[s]) table.rows.back().push_back(bold_if(!(mean > lowest), fixed(mean, 4)));
  }
  std::vector<std::string> average = {"average"}, lowest = {"minimum"}, highest = {"maximum"};
  for (std::size_t c = 0; c < runs.contestants.size(); ++c) {
    const std::vector<double> column = column_of(means, c);
    average.push_back(fixed(plain_mean(column), 4));
    lowest.push_back(fixed(*std::min_element(column.begin(), column.end()), 4));
    highest.push_back(fixed(*std::max_element(column.begin(), column.end()), 4));
  }
  table.rows.insert(table.rows.end(), {average, lowest, highest});
  return table;
}

Table time_table(const TrackingRuns& runs) {
  Table table;
  table.header = {"ms a frame", "outlier rejection", "selection", "pose optimisation",
                  "total",      "matches",           "used",      "frames lost"};
  for (std::size_t c = 0; c < runs.contestants.size(); ++c) {
    const auto mean = [&](auto member) {
      std::vector<double> values;
      for (const TrackingRun& run : runs.runs) values.push_back(static_cast<double>(run.outcomes.at(c).*member));
      return plain_mean(values);
    };
    const double outliers = mean(&TrackingOutcome::ms_outliers), selection = mean(&TrackingOutcome::ms_selection),
                 pose = mean(&TrackingOutcome::ms_pose);
    std::size_t lost = 0;
    for (const TrackingRun& run : runs.runs) lost += run.outcomes.at(c).lost;
    table.rows.push_back({runs.contestants[c], fixed(outliers, 3), fixed(selection, 3), fixed(pose, 3),
                          fixed(outliers + selection + pose, 3), fixed(mean(&TrackingOutcome::matches), 0),
                          fixed(mean(&TrackingOutcome::used), 0), std::to_string(lost)});
  }
  return table;
}

Table claim_table(const TrackingRuns& runs, const std::string& name) {
  Table table;
  table.header = {name + " against", "RPE", "ROE", "ATE"};
  const auto found = std::find(runs.contestants.begin(), runs.contestants.end(), name);
  if (found == runs.contestants.end()) return table;
  const auto ours = static_cast<std::size_t>(found - runs.contestants.begin());
  for (std::size_t c = 0; c < runs.contestants.size(); ++c) {
    if (c == ours) continue;
    table.rows.push_back({runs.contestants[c]});
    for (const ErrorKind& kind : {rpe, roe, ate}) {
      table.rows.back().push_back(claim(run_averages(runs, ours, kind), run_averages(runs, c, kind)));
    }
  }
  return table;
}

Table budget_table(const TrackingRuns& runs, const std::vector<SelectorSettings>& contestants) {
  Table table;
  table.header = {"sequence", "selector", "budget", "run", "ate_m", "rpe_m_per_s", "roe_deg_per_s"};
  for (const TrackingRun& run : runs.runs) {
    for (std::size_t c = 0; c < contestants.size(); ++c) {
      const TrajectoryErrors& errors = run.outcomes.at(c).errors;
      const std::size_t budget = has_budget(contestants[c].kind) ? contestants[c].budget : 0;
      table.rows.push_back({run.sequence, to_string(contestants[c].kind), std::to_string(budget),
                            std::to_string(run.run), exact(errors.ate_m), exact(errors.rpe_m_per_s),
                            exact(errors.roe_deg_per_s)});
    }
  }
  return table;
}

Table budget_summary(const TrackingRuns& runs, const std::vector<SelectorSettings>& contestants) {
  Table table;
  table.header = {"features"};
  for (const ErrorKind& kind : {ate, rpe, roe}) table.header.push_back("median " + axis_label(kind) + " [quartiles]");
  for (const ErrorKind& kind : {ate, rpe, roe}) table.header.push_back(std::string(kind.name) + " against inl");
  const auto inl = std::find_if(contestants.begin(), contestants.end(),
                                [](const SelectorSettings& one) { return one.kind == SelectorKind::inl; });
  const auto reference = static_cast<std::size_t>(inl - contestants.begin());
  for (std::size_t c = 0; c < contestants.size(); ++c) {
    table.rows.push_back(
        {has_budget(contestants[c].kind) ? std::to_string(contestants[c].budget) : to_string(contestants[c].kind)});
    for (const ErrorKind& kind : {ate, rpe, roe}) {
      const Quartiles q = quartiles_of(all_errors_of(runs, c, kind));
      table.rows.back().push_back(fixed(q.median, 4) + " [" + fixed(q.lower, 4) + ", " + fixed(q.upper, 4) + "]");
    }
    for (const ErrorKind& kind : {ate, rpe, roe}) {
      const bool is_compared = c != reference && inl != contestants.end();
      table.rows.back().push_back(
          is_compared ? claim(all_errors_of(runs, c, kind), all_errors_of(runs, reference, kind)) : "-");
    }
  }
  return table;
}

}  // namespace maxlogdet::sim
