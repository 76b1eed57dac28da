// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/epsilon_report.hpp"

#include "bench/does_the_paper_hold/estimate.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

namespace maxlogdet::sim {
namespace {

using Runs = std::vector<std::vector<EpsilonOutcome>>;
using Holds = std::function<bool(const EpsilonOutcome&)>;
using Value = std::function<double(const EpsilonOutcome&)>;

std::vector<double> values_where(const Runs& runs, const Holds& holds, const Value& value) {
  std::vector<double> values;
  for (const auto& run : runs) {
    for (const EpsilonOutcome& outcome : run) {
      if (holds(outcome)) values.push_back(value(outcome));
    }
  }
  return values;
}

double mean(const std::vector<double>& values) { return values.empty() ? std::nan("") : mean_of(values).value; }

double minimum(const std::vector<double>& values) {
  return values.empty() ? std::nan("") : *std::min_element(values.begin(), values.end());
}

double differing_percent(const EpsilonOutcome& o) {
  return 100 * static_cast<double>(o.differing) / static_cast<double>(o.k);
}

std::string guarantee(double epsilon) {
  const double share = 1 - std::exp(-1.0) - epsilon;
  return share > 0 ? fixed(share, 3) : "none";
}

std::vector<std::string> row_of(const Runs& runs, double epsilon, const Holds& holds) {
  const auto mean_value = [&](const Value& value) { return mean(values_where(runs, holds, value)); };
  return {exact(epsilon),
          guarantee(epsilon),
          fixed(minimum(values_where(runs, holds, [](const auto& o) { return o.share_of_greedy; })), 4),
          fixed(mean_value([](const auto& o) { return o.gap_nats; }), 3),
          fixed(mean_value(differing_percent), 1),
          fixed(mean_value([](const auto& o) { return o.gains_greedy / o.gains; }), 1),
          fixed(mean_value([](const auto& o) { return o.us_greedy / o.us; }), 1),
          fixed(mean_value([](const auto& o) { return o.us_lazy / o.us; }), 1)};
}

const std::vector<std::string> columns = {"ε",
                                          "1 − 1/e − ε",
                                          "minimum f / f(greedy)",
                                          "mean gap (nats)",
                                          "features differing (%)",
                                          "× fewer gains",
                                          "× faster than greedy",
                                          "× faster than lazy greedy"};

}  // namespace

Table epsilon_table(const EpsilonOptions& options, const Runs& runs) {
  Table table;
  table.header = {"run",     "n",        "k",         "epsilon", "us",           "us_greedy",
                  "us_lazy", "gap_nats", "differing", "gains",   "gains_greedy", "share_of_greedy"};
  for (std::size_t run = 0; run < runs.size(); ++run) {
    for (const EpsilonOutcome& o : runs[run]) {
      table.rows.push_back({std::to_string(run / options.sizes.size()), std::to_string(o.n), std::to_string(o.k),
                            exact(o.epsilon), exact(o.us), exact(o.us_greedy), exact(o.us_lazy), exact(o.gap_nats),
                            std::to_string(o.differing), exact(o.gains), exact(o.gains_greedy),
                            exact(o.share_of_greedy)});
    }
  }
  return table;
}

Table guarantee_table(const EpsilonOptions& options, const Runs& runs) {
  Table table{columns, {}};
  for (const double epsilon : options.epsilons) {
    table.rows.push_back(row_of(runs, epsilon, [&](const auto& o) { return o.epsilon == epsilon; }));
  }
  return table;
}

Table speedup_table(const EpsilonOptions& options, const Runs& runs, std::size_t n, std::size_t k) {
  Table table{columns, {}};
  for (const double epsilon : options.epsilons) {
    table.rows.push_back(
        row_of(runs, epsilon, [&](const auto& o) { return o.epsilon == epsilon && o.n == n && o.k == k; }));
  }
  return table;
}

}  // namespace maxlogdet::sim
