// SPDX-License-Identifier: MIT
#include "experiments/epsilon_report.hpp"

#include "sim/plot_style.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <sstream>

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

double least(const std::vector<double>& values) {
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
          fixed(least(values_where(runs, holds, [](const auto& o) { return o.share_of_greedy; })), 4),
          fixed(least(values_where(runs, holds, [](const auto& o) { return o.share_of_bound; })), 4),
          fixed(mean_value([](const auto& o) { return o.gap_nats; }), 3),
          fixed(mean_value(differing_percent), 1),
          fixed(mean_value([](const auto& o) { return o.gains_greedy / o.gains; }), 1),
          fixed(mean_value([](const auto& o) { return o.us_greedy / o.us; }), 1),
          fixed(mean_value([](const auto& o) { return o.us_lazy / o.us; }), 1)};
}

const std::vector<std::string> columns = {"ε",
                                          "1 − 1/e − ε",
                                          "least f / f(greedy)",
                                          "least f / bound",
                                          "mean gap (nats)",
                                          "features differing (%)",
                                          "× fewer gains",
                                          "× faster than greedy",
                                          "× faster than lazy greedy"};

}  // namespace

Table epsilon_table(const Runs& runs, const std::vector<std::string>& numbers) {
  Table table;
  table.header = {"run",           "n",        "k",         "epsilon", "us",           "us_greedy",
                  "us_lazy",       "gap_nats", "differing", "gains",   "gains_greedy", "share_of_greedy",
                  "share_of_bound"};
  for (std::size_t run = 0; run < runs.size(); ++run) {
    for (const EpsilonOutcome& o : runs[run]) {
      table.rows.push_back({numbers.at(run), std::to_string(o.n), std::to_string(o.k), exact(o.epsilon), exact(o.us),
                            exact(o.us_greedy), exact(o.us_lazy), exact(o.gap_nats), std::to_string(o.differing),
                            exact(o.gains), exact(o.gains_greedy), exact(o.share_of_greedy), exact(o.share_of_bound)});
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

std::string epsilon_plot(const EpsilonOptions& options, const Runs& runs, EpsilonMap map) {
  const auto value = [&](const EpsilonOutcome& o) {
    if (map == EpsilonMap::time_us) return o.us;
    return map == EpsilonMap::gap_nats ? o.gap_nats : differing_percent(o);
  };
  const char* const title = map == EpsilonMap::time_us    ? "time of a selection (us)"
                            : map == EpsilonMap::gap_nats ? "log det below greedy (nats)"
                                                          : "features that greedy does not select (%)";
  std::ostringstream script;
  std::ostringstream panels;
  const auto count_of_shares = options.shares.size(), count_of_epsilons = options.epsilons.size();
  for (std::size_t i = 0; i < options.sizes.size(); ++i) {
    const std::size_t n = options.sizes[i];
    script << "$map" << i << " << EOD\n";
    // Outcomes of a run come a size each, in order of shares and epsilons.
    for (std::size_t cell = 0; cell < count_of_shares * count_of_epsilons; ++cell) {
      std::vector<double> values;
      for (const auto& run : runs) {
        if (!run.empty() && run.front().n == n) values.push_back(value(run.at(cell)));
      }
      if (!values.empty()) {
        const double shown = mean(values);
        script << cell / count_of_epsilons << ' ' << cell % count_of_epsilons << ' ' << exact(shown) << ' '
               << fixed(shown, map == EpsilonMap::gap_nats ? 3
                               : shown < 10                ? 1
                                                           : 0)
               << '\n';
      }
    }
    script << "EOD\n";
    panels << "set title 'n = " << n << "'\nplot $map" << i << " using 1:2:3 with image, $map" << i
           << " using 1:2:4 with labels font ',9' notitle\n";
  }
  script << plot_style()
         << "unset key\nunset colorbox\nunset grid\nset tics scale 0\nset palette defined (0 '#f7fbff', 1 "
         << (map == EpsilonMap::time_us ? "'#6baed6'" : "'#fc8d59'")
         << ")\nset xlabel 'k / n (%)'\nset ylabel 'ε'\nset xtics (";
  for (std::size_t i = 0; i < count_of_shares; ++i) {
    script << (i == 0 ? "" : ", ") << "'" << fixed(100 * options.shares[i], 0) << "' " << i;
  }
  script << ")\nset ytics (";
  for (std::size_t i = 0; i < count_of_epsilons; ++i) {
    script << (i == 0 ? "" : ", ") << "'" << exact(options.epsilons[i]) << "' " << i;
  }
  const std::size_t panel_columns = std::min<std::size_t>(3, options.sizes.size());
  const std::size_t panel_rows = (options.sizes.size() + panel_columns - 1) / panel_columns;
  script << ")\nset xrange [-0.5:" << count_of_shares - 1 << ".5]\nset yrange [-0.5:" << count_of_epsilons - 1
         << ".5]\nset multiplot layout " << panel_rows << ',' << panel_columns << " title 'stochastic greedy: " << title
         << "'\n"
         << panels.str() << "unset multiplot\n";
  return script.str();
}

}  // namespace maxlogdet::sim
