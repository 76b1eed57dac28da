// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/pnp_report.hpp"

#include "bench/does_the_paper_hold/greedy_metric.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

namespace maxlogdet::sim {
namespace {

using Error = double PnpOutcome::*;
using RowError = Estimate PnpRow::*;

constexpr Error panels_of_outcome[] = {&PnpOutcome::translation_m, &PnpOutcome::rotation_deg};

std::vector<std::string> selector_names() {
  std::vector<std::string> names;
  for (const GreedyMetric metric : greedy_metrics) names.emplace_back(to_string(metric));
  names.insert(names.end(), {"random", "all", "all_weighted"});
  return names;
}

std::string px(double noise) { return exact(noise) + " px"; }

// Rows by noise, size and selector.
class Rows {
 public:
  Rows(const std::vector<PnpRow>& rows, Weighting weighting) {
    for (const PnpRow& row : rows) {
      if (row.which.weighting == to_string(weighting)) {
        rows_[{row.which.noise_px, row.which.size, row.which.selector}] = &row;
      }
    }
  }
  const PnpRow& at(double noise, std::size_t size, const std::string& selector) const {
    return *rows_.at({noise, size, selector});
  }

 private:
  std::map<std::tuple<double, std::size_t, std::string>, const PnpRow*> rows_;
};

// Subset sizes below that of all points, ascending.
std::vector<std::size_t> proper_sizes(const PnpOptions& options) {
  std::vector<std::size_t> sizes = options.sizes;
  std::sort(sizes.begin(), sizes.end());
  sizes.erase(std::remove(sizes.begin(), sizes.end(), options.points), sizes.end());
  return sizes;
}

// For one selector, noise and error: squared errors by size (outer) and run.
using Squares = std::vector<std::vector<double>>;

class SquaredErrors {
 public:
  SquaredErrors(const PnpOptions& options, const std::vector<std::vector<PnpOutcome>>& runs)
      : cases_(pnp_cases(options)), runs_(runs), sizes_(proper_sizes(options)), points_(options.points) {}

  Squares of(double noise, const std::string& weighting, const std::string& selector, Error error) const {
    const bool uses_all = selector == "all" || selector == "all_weighted";
    const std::string of_case = uses_all || selector == "random" ? "-" : weighting;
    Squares squares;
    for (const std::size_t size : sizes_) {
      const std::size_t size_of_case = uses_all ? points_ : size;
      const auto found = std::find_if(cases_.begin(), cases_.end(), [&](const PnpCase& one) {
        return one.noise_px == noise && one.size == size_of_case && one.weighting == of_case &&
               one.selector == selector;
      });
      squares.emplace_back();
      for (const auto& run : runs_) {
        const double e = run.at(static_cast<std::size_t>(found - cases_.begin())).*error;
        squares.back().push_back(e * e);
      }
    }
    return squares;
  }

 private:
  std::vector<PnpCase> cases_;
  const std::vector<std::vector<PnpOutcome>>& runs_;
  std::vector<std::size_t> sizes_;
  std::size_t points_;
};

// The mean over sizes of the RMS over runs, of all runs and with each run left out.
struct Score {
  double value = 0;
  std::vector<double> without;
};

Score score_of(const Squares& squares) {
  if (squares.empty()) return {std::nan(""), {}};  // no size below that of all points
  const std::size_t n = squares.front().size();
  Score score;
  score.without.resize(n);
  const double share = 1 / static_cast<double>(squares.size());
  for (const auto& of_runs : squares) {
    double sum = 0;
    for (const double square : of_runs) sum += square;
    score.value += share * std::sqrt(sum / static_cast<double>(n));
    for (std::size_t i = 0; i < n; ++i) {
      score.without[i] += share * std::sqrt(std::max(sum - of_runs[i], 0.0) / static_cast<double>(n - 1));
    }
  }
  return score;
}

Estimate difference(const Score& ours, const Score& theirs) {
  std::vector<double> without;
  for (std::size_t i = 0; i < ours.without.size(); ++i) without.push_back(ours.without[i] - theirs.without[i]);
  return {ours.value - theirs.value, jackknife_ci95(without)};
}

// Returns the first of the ascending sizes from which on `holds` is true; "-" if it is false at the last.
template <class Holds>
std::string from_size(const std::vector<std::size_t>& sizes, const Holds& holds) {
  std::string first = "-";
  for (auto size = sizes.rbegin(); size != sizes.rend() && holds(*size); ++size) first = std::to_string(*size);
  return first;
}

template <class Member>
Estimate rms_over(const std::vector<PnpOutcome>& outcomes, Member member) {
  std::vector<double> values;
  for (const PnpOutcome& outcome : outcomes) values.push_back(outcome.*member);
  return rms_of(values);
}

PnpRow row_of(const PnpCase& which, const std::vector<PnpOutcome>& outcomes) {
  PnpRow row;
  row.which = which;
  row.translation_m = rms_over(outcomes, &PnpOutcome::translation_m);
  row.rotation_deg = rms_over(outcomes, &PnpOutcome::rotation_deg);
  row.aligned_translation_m = rms_over(outcomes, &PnpOutcome::aligned_translation_m);
  row.aligned_rotation_deg = rms_over(outcomes, &PnpOutcome::aligned_rotation_deg);
  row.expected_translation_m = rms_over(outcomes, &PnpOutcome::expected_translation_m);
  row.expected_rotation_deg = rms_over(outcomes, &PnpOutcome::expected_rotation_deg);
  for (const PnpOutcome& outcome : outcomes) row.bias_amplification += outcome.bias_amplification;
  row.bias_amplification /= static_cast<double>(outcomes.size());
  row.runs = outcomes.size();
  return row;
}

}  // namespace

std::vector<PnpRow> summarize(const PnpOptions& options, const std::vector<std::vector<PnpOutcome>>& runs) {
  if (runs.empty()) return {};
  const std::vector<PnpCase> cases = pnp_cases(options);
  std::map<std::tuple<double, std::size_t, std::string, std::string>, PnpRow> rows;
  for (std::size_t c = 0; c < cases.size(); ++c) {
    std::vector<PnpOutcome> outcomes;
    for (const auto& run : runs) outcomes.push_back(run.at(c));
    const PnpCase& which = cases[c];
    rows[{which.noise_px, which.size, which.weighting, which.selector}] = row_of(which, outcomes);
  }
  std::vector<PnpRow> table;
  const auto add = [&](double noise, std::size_t size, std::size_t size_of_case, const std::string& weighting,
                       const std::string& weighting_of_case, const std::string& selector) {
    table.push_back(rows.at({noise, size_of_case, weighting_of_case, selector}));
    table.back().which = {noise, size, weighting, selector};
  };
  for (const double noise : options.noises) {
    for (const Weighting weighting : options.weightings) {
      const std::string name = to_string(weighting);
      for (const std::size_t size : options.sizes) {
        for (const GreedyMetric metric : greedy_metrics) add(noise, size, size, name, name, to_string(metric));
        add(noise, size, size, name, no_weighting, "random");
        for (const char* const every : {"all", "all_weighted"}) {
          add(noise, size, options.points, name, no_weighting, every);
        }
      }
    }
  }
  return table;
}

Table metrics_table(const std::vector<PnpRow>& rows, bool aligned) {
  Table table;
  table.header = {"noise_px",
                  "size",
                  "weighting",
                  "selector",
                  "rms_translation_m",
                  "rms_rotation_deg",
                  "ci95_translation_m",
                  "ci95_rotation_deg",
                  "runs"};
  for (const PnpRow& row : rows) {
    const Estimate& t = aligned ? row.aligned_translation_m : row.translation_m;
    const Estimate& r = aligned ? row.aligned_rotation_deg : row.rotation_deg;
    table.rows.push_back({exact(row.which.noise_px), std::to_string(row.which.size), row.which.weighting,
                          row.which.selector, exact(t.value), exact(r.value), exact(t.ci95), exact(r.ci95),
                          std::to_string(row.runs)});
  }
  return table;
}

Table expectation_table(const PnpOptions& options, const std::vector<PnpRow>& rows, Weighting weighting,
                        std::size_t size) {
  const Rows found(rows, weighting);
  const double noise = options.noises.front();
  Table table;
  table.header = {"selector", "bias amplification", "expected (m)", "measured (m)", "expected (deg)", "measured (deg)"};
  for (const std::string& selector : selector_names()) {
    if (selector == "all_weighted") continue;  // the theory is that of ordinary least squares
    const PnpRow& row = found.at(noise, size, selector);
    table.rows.push_back({selector, fixed(row.bias_amplification, 3), fixed(row.expected_translation_m.value, 4),
                          fixed(row.translation_m, 4), fixed(row.expected_rotation_deg.value, 3),
                          fixed(row.rotation_deg, 3)});
  }
  return table;
}

Table comparison_table(const PnpOptions& options, const std::vector<std::vector<PnpOutcome>>& runs,
                       Weighting weighting) {
  const SquaredErrors errors(options, runs);
  const std::string log_det = to_string(GreedyMetric::max_log_det);
  Table table;
  table.header = {"selector"};
  for (const double noise : options.noises) {
    table.header.push_back("translation, " + px(noise) + " (m)");
    table.header.push_back("rotation, " + px(noise) + " (deg)");
  }
  for (const std::string& selector : selector_names()) {
    std::vector<std::string> row = {selector};
    for (const double noise : options.noises) {
      for (const Error error : panels_of_outcome) {
        const Score score = score_of(errors.of(noise, to_string(weighting), selector, error));
        const Score reference = score_of(errors.of(noise, to_string(weighting), log_det, error));
        row.push_back(fixed({score.value, jackknife_ci95(score.without)}, 4));
        if (selector != log_det) row.back() += std::string(" ") + verdict(difference(reference, score));
      }
    }
    table.rows.push_back(row);
  }
  return table;
}

Table crossing_table(const PnpOptions& options, const std::vector<PnpRow>& rows, Weighting weighting) {
  const Rows found(rows, weighting);
  const std::vector<std::size_t> sizes = proper_sizes(options);
  Table table;
  table.header = {"selector"};
  for (const double noise : options.noises) {
    table.header.push_back("translation, " + px(noise) + ": within 5 % / below");
    table.header.push_back("rotation, " + px(noise) + ": within 5 % / below");
  }
  for (const std::string& selector : selector_names()) {
    if (selector == "all" || selector == "all_weighted") continue;
    std::vector<std::string> row = {selector};
    for (const double noise : options.noises) {
      for (const RowError error : {&PnpRow::translation_m, &PnpRow::rotation_deg}) {
        const auto ratio = [&](std::size_t size) {
          return (found.at(noise, size, selector).*error).value / (found.at(noise, size, "all").*error).value;
        };
        row.push_back(from_size(sizes, [&](std::size_t size) { return ratio(size) <= 1.05; }) + " / " +
                      from_size(sizes, [&](std::size_t size) { return ratio(size) < 1; }));
      }
    }
    table.rows.push_back(row);
  }
  return table;
}

}  // namespace maxlogdet::sim
