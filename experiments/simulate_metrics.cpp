// SPDX-License-Identifier: MIT
#include "experiments/greedy_metric.hpp"
#include "experiments/pnp_report.hpp"
#include "experiments/simulation.hpp"
#include "sim/names.hpp"
#include "sim/selection_data.hpp"

#include <memory>

namespace maxlogdet::cli {
namespace {

struct Arguments {
  SimulationArguments common;
  sim::PnpOptions options;
  std::vector<std::string> weightings;
  std::string depths = "uniform";
};

// Figure 2 of the paper: the scene, with what Max-logDet selects.
void write_scene(const Simulation& simulation, const sim::PnpOptions& options) {
  const sim::Frame frame = sim::pnp_frame(options, 0);
  BlockOptions block_options;
  block_options.weighting = options.weightings.front();
  block_options.map_sigma = options.map_deviation;
  BlockStore blocks;
  build_blocks(frame, block_options, blocks);
  const auto selected = select_greedily(sim::GreedyMetric::max_log_det, blocks, options.sizes.front(),
                                        options.prior * sim::Matrix6::Identity());
  simulation.write_json("metrics_scene", selection_data(frame, selected));
}

void run(const Arguments& arguments) {
  const sim::PnpOptions& options = arguments.options;
  sim::check(options);
  Simulation simulation("metrics", arguments.common);
  std::vector<std::string> keys;
  for (std::int64_t run = 0; run < arguments.common.runs; ++run) keys.push_back(std::to_string(run));
  simulation.run(to_json(options), keys,
                 [&](const std::string& key) { return to_json(run_pnp(options, std::stoull(key))); });

  std::vector<std::vector<sim::PnpOutcome>> runs;
  std::vector<std::string> numbers;
  for (const std::string& key : keys) {
    if (!simulation.has(key)) continue;
    runs.push_back(simulation.finished(key, sim::pnp_outcomes_of, pnp_cases(options).size()));
    numbers.push_back(key);
  }
  const std::vector<sim::PnpRow> rows = summarize(options, runs);
  const sim::Table table = metrics_table(rows, false);
  simulation.write_csv("metrics", table);
  simulation.write_csv("metrics_aligned", metrics_table(rows, true));
  simulation.write_csv("metrics_runs", metrics_runs_table(options, runs, numbers));
  if (!rows.empty()) {
    for (const Weighting weighting : options.weightings) {
      const std::string name = to_string(weighting);
      simulation.print("Mean over subset sizes below that of all points of the RMS error, `" + name +
                           "` blocks; ▲ max_log_det is better, ▼ worse, · cannot be told:",
                       comparison_table(options, runs, weighting));
      simulation.print(
          "The size from which on the RMS error stays within 5 % of `all`'s / below it, `" + name + "` blocks:",
          crossing_table(options, rows, weighting));
      simulation.print("Theory (section II) and measurement at " + std::to_string(options.sizes.front()) +
                           " points, `" + name + "` blocks, the first noise:",
                       expectation_table(options, rows, weighting, options.sizes.front()));
    }
    write_scene(simulation, options);
  }
  simulation.finish(table);
}

}  // namespace

void add_metrics_experiment(CLI::App& simulate) {
  CLI::App* const command =
      simulate.add_subcommand("metrics", "Section III: metrics of greedy selection, pose from points of a biased map");
  const auto arguments = std::make_shared<Arguments>();
  sim::PnpOptions& options = arguments->options;
  arguments->common.runs = 300;
  arguments->common.add_to(*command);
  for (const Weighting weighting : options.weightings) arguments->weightings.emplace_back(to_string(weighting));
  command->add_option("--points", options.points, "Points of a scene")->capture_default_str();
  command->add_option("--sizes", options.sizes, "Subset sizes")->delimiter(',')->capture_default_str();
  command->add_option("--noise", options.noises, "Measurement noise, px")->delimiter(',')->capture_default_str();
  command->add_option("--weightings", arguments->weightings, "Which blocks the metrics look at")
      ->delimiter(',')
      ->check(CLI::IsMember(sim::names_of(sim::weightings)))
      ->capture_default_str();
  command->add_option("--map-bias", options.map_bias, "Mean of the map error in x, y and z, m")->capture_default_str();
  command->add_option("--map-deviation", options.map_deviation, "Deviation of the map error, m")->capture_default_str();
  command->add_option("--depths", arguments->depths, "How depths of points are spread")
      ->check(CLI::IsMember(sim::names_of(sim::depth_laws)))
      ->capture_default_str();
  command->add_option("--nearest", options.nearest, "Least depth, m")->capture_default_str();
  command->add_option("--farthest", options.farthest, "Largest depth, m")->capture_default_str();
  command->add_option("--prior", options.prior, "M0 = this times I")->capture_default_str();
  command->callback([arguments] {
    arguments->options.seed = seed_of(arguments->common.seed);
    arguments->options.weightings.clear();
    for (const std::string& name : arguments->weightings) {
      arguments->options.weightings.push_back(sim::find_named(sim::weightings, name).value());
    }
    arguments->options.depths = sim::find_named(sim::depth_laws, arguments->depths).value();
    run(*arguments);
  });
}

}  // namespace maxlogdet::cli
