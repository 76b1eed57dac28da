// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/experiment_commands.hpp"
#include "bench/does_the_paper_hold/greedy_metric.hpp"
#include "bench/does_the_paper_hold/pnp_report.hpp"
#include "bench/does_the_paper_hold/simulation.hpp"
#include "bench/world/command_line.hpp"
#include "bench/world/names.hpp"
#include "bench/world/selection_data.hpp"

#include <memory>

namespace maxlogdet::sim {
namespace {

struct Arguments {
  SimulationArguments common;
  PnpOptions options;
  std::vector<std::string> weightings;
  std::string depths = "uniform";
};

// Figure 2 of the paper: the scene, with the selection of Max-logDet.
void write_scene(const Simulation& simulation, const PnpOptions& options) {
  const Frame frame = pnp_frame(options, 0);
  BlockOptions block_options;
  block_options.weighting = options.weightings.front();
  block_options.map_sigma = options.map_deviation;
  BlockStore blocks;
  build_blocks(frame, block_options, blocks);
  const auto selected =
      select_greedily(GreedyMetric::max_log_det, blocks, options.sizes.front(), options.prior * Matrix6::Identity());
  simulation.write_json("metrics_scene", selection_data(frame, selected));
}

void report(Simulation& simulation, const PnpOptions& options, const std::vector<std::vector<PnpOutcome>>& outcomes,
            const std::vector<PnpRow>& rows) {
  for (const Weighting weighting : options.weightings) {
    const std::string blocks = std::string("`") + to_string(weighting) + "` blocks";
    simulation.print("Mean over subset sizes below that of all points of the RMS error, " + blocks +
                         "; ▲ max_log_det is better, ▼ worse, · not significant:",
                     comparison_table(options, outcomes, weighting));
    simulation.print("The size from which on the RMS error stays within 5 % of `all`'s / below it, " + blocks + ":",
                     crossing_table(options, rows, weighting));
    simulation.print("Theory (section II) and measurement at " + std::to_string(options.sizes.front()) + " points, " +
                         blocks + ", the first noise:",
                     expectation_table(options, rows, weighting, options.sizes.front()));
  }
  write_scene(simulation, options);
}

void run(const Arguments& arguments) {
  const PnpOptions& options = arguments.options;
  check(options);
  Simulation simulation("metrics", arguments.common);
  const auto outcomes = simulation.run_all<PnpOutcome>(arguments.common.runs,
                                                       [&](std::size_t number) { return run_pnp(options, number); });
  const std::vector<PnpRow> rows = summarize(options, outcomes);
  const Table table = metrics_table(rows, false);
  simulation.write_csv("metrics", table);
  simulation.write_csv("metrics_aligned", metrics_table(rows, true));
  report(simulation, options, outcomes, rows);
  simulation.finish(to_json(options), table);
}

}  // namespace

void add_metrics_experiment(CLI::App& program) {
  CLI::App* const command =
      program.add_subcommand("metrics", "Section III: metrics of greedy selection, pose from points of a biased map");
  const auto arguments = std::make_shared<Arguments>();
  PnpOptions& options = arguments->options;
  arguments->common.runs = 300;
  arguments->common.add_to(*command);
  arguments->weightings = names_of(options.weightings);
  command->add_option("--points", options.points, "Points of a scene")->capture_default_str();
  command->add_option("--sizes", options.sizes, "Subset sizes")->delimiter(',')->capture_default_str();
  command->add_option("--noise", options.noises, "Measurement noise, px")->delimiter(',')->capture_default_str();
  command->add_option("--weightings", arguments->weightings, "Which blocks the metrics use")
      ->delimiter(',')
      ->check(CLI::IsMember(names_of(weightings)))
      ->capture_default_str();
  command->add_option("--map-bias", options.map_bias, "Mean of the map error in x, y and z, m")->capture_default_str();
  command->add_option("--map-deviation", options.map_deviation, "Deviation of the map error, m")->capture_default_str();
  command->add_option("--depths", arguments->depths, "Distribution of the depths of points")
      ->check(CLI::IsMember(names_of(depth_laws)))
      ->capture_default_str();
  command->add_option("--nearest", options.nearest, "Minimum depth, m")->capture_default_str();
  command->add_option("--farthest", options.farthest, "Maximum depth, m")->capture_default_str();
  command->add_option("--prior", options.prior, "M0 is this times I")->capture_default_str();
  command->callback([arguments] {
    arguments->options.seed = seed_of(arguments->common.seed);
    arguments->options.weightings = values_named(weightings, arguments->weightings);
    arguments->options.depths = find_named(depth_laws, arguments->depths).value();
    run(*arguments);
  });
}

}  // namespace maxlogdet::sim
