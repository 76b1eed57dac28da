// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/tracking_report.hpp"

#include "bench/does_the_paper_hold/estimate.hpp"

#include <algorithm>

namespace maxlogdet::sim {
namespace {

struct Error {
  const char* name;
  const char* column;
  double TrajectoryErrors::*member;
  int decimals;
};
constexpr Error errors[] = {{"RPE", "rpe_m_per_s", &TrajectoryErrors::rpe_m_per_s, 4},
                            {"ROE", "roe_deg_per_s", &TrajectoryErrors::roe_deg_per_s, 3},
                            {"ATE", "ate_m", &TrajectoryErrors::ate_m, 4}};

std::size_t number_of(const TrackingRuns& runs, const std::string& selector) {
  const auto found = std::find(runs.selectors.begin(), runs.selectors.end(), selector);
  return static_cast<std::size_t>(found - runs.selectors.begin());
}

// Of a selector on a sequence.
double mean_over_runs(const TrackingRuns& runs, std::size_t sequence, std::size_t selector, const Error& error) {
  std::vector<double> values;
  for (const auto& run : runs.outcomes[sequence]) values.push_back(run[selector].errors.*error.member);
  return mean_of(values).value;
}

// A mean over sequences for each run.
std::vector<double> means_of_runs(const TrackingRuns& runs, std::size_t selector, const Error& error) {
  std::vector<double> means(runs.outcomes.front().size(), 0.0);
  for (const auto& sequence : runs.outcomes) {
    for (std::size_t run = 0; run < means.size(); ++run) {
      means[run] += sequence[run][selector].errors.*error.member / static_cast<double>(runs.sequences.size());
    }
  }
  return means;
}

}  // namespace

Table sequences_table(const TrackingRuns& runs) {
  Table table;
  table.header = {"sequence", "selector"};
  for (const Error& error : errors) table.header.emplace_back(error.column);
  for (std::size_t s = 0; s < runs.sequences.size(); ++s) {
    for (std::size_t c = 0; c < runs.selectors.size(); ++c) {
      table.rows.push_back({runs.sequences[s], runs.selectors[c]});
      for (const Error& error : errors) {
        table.rows.back().push_back(fixed(mean_over_runs(runs, s, c, error), error.decimals));
      }
    }
  }
  return table;
}

Table means_table(const TrackingRuns& runs) {
  Table table;
  table.header = {"selector"};
  for (const Error& error : errors) {
    table.header.insert(table.header.end(), {error.column, std::string(error.column) + "_ci95"});
  }
  for (const char* const error : {"rpe", "roe"}) {
    for (const char* const what :
         {"_sequences_worse_than_all", "_sequences_better_than_all", "_mean_loss_there", "_mean_gain_there"}) {
      table.header.push_back(std::string(error) + what);
    }
  }
  const std::size_t all = number_of(runs, "all");
  for (std::size_t c = 0; c < runs.selectors.size(); ++c) {
    table.rows.push_back({runs.selectors[c]});
    auto& row = table.rows.back();
    for (const Error& error : errors) {
      const Estimate mean = mean_of(means_of_runs(runs, c, error));
      row.insert(row.end(), {fixed(mean.value, 5), fixed(mean.ci95, 5)});
    }
    for (const Error& error : {errors[0], errors[1]}) {
      std::vector<double> losses, gains;
      for (std::size_t s = 0; s < runs.sequences.size(); ++s) {
        const double difference = mean_over_runs(runs, s, c, error) - mean_over_runs(runs, s, all, error);
        if (difference != 0) (difference > 0 ? losses : gains).push_back(difference);
      }
      const auto mean = [&](const std::vector<double>& some) {
        return some.empty() ? "" : fixed(mean_of(some).value, error.decimals);
      };
      row.insert(row.end(), {std::to_string(losses.size()), std::to_string(gains.size()), mean(losses), mean(gains)});
    }
  }
  return table;
}

Table differences_table(const TrackingRuns& runs, const std::vector<std::string>& ours,
                        const std::vector<std::string>& theirs) {
  Table table;
  table.header = {"selector", "against", "error", "difference_percent", "ci95", "verdict"};
  for (const std::string& one : ours) {
    for (const std::string& other : theirs) {
      if (one == other) continue;
      for (const Error& error : errors) {
        const Estimate difference = difference_percent(means_of_runs(runs, number_of(runs, one), error),
                                                       means_of_runs(runs, number_of(runs, other), error));
        table.rows.push_back(
            {one, other, error.name, fixed(difference.value, 1), fixed(difference.ci95, 1), verdict(difference)});
      }
    }
  }
  return table;
}

Table times_table(const TrackingRuns& runs) {
  Table table;
  table.header = {"ms_a_frame", "outlier_rejection", "selection", "pose_optimisation",
                  "total",      "matches",           "used",      "frames_lost"};
  for (std::size_t c = 0; c < runs.selectors.size(); ++c) {
    TrackingOutcome sum;
    double count = 0;
    for (const auto& sequence : runs.outcomes) {
      for (const auto& run : sequence) {
        sum.ms_outliers += run[c].ms_outliers;
        sum.ms_selection += run[c].ms_selection;
        sum.ms_pose += run[c].ms_pose;
        sum.matches += run[c].matches;
        sum.used += run[c].used;
        sum.lost += run[c].lost;
        ++count;
      }
    }
    const double total = sum.ms_outliers + sum.ms_selection + sum.ms_pose;
    table.rows.push_back({runs.selectors[c], fixed(sum.ms_outliers / count, 3), fixed(sum.ms_selection / count, 3),
                          fixed(sum.ms_pose / count, 3), fixed(total / count, 3), fixed(sum.matches / count, 0),
                          fixed(sum.used / count, 0), std::to_string(sum.lost)});
  }
  return table;
}

}  // namespace maxlogdet::sim
