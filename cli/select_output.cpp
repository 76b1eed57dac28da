// SPDX-License-Identifier: MIT
#include "cli/select_output.hpp"

#include "bench/world/names.hpp"
#include "bench/world/output_file.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <nlohmann/json.hpp>
#include <vector>

namespace maxlogdet::cli {
namespace {

template <class... Values>
void print(const char* format, Values... values) {
  char text[512];
  std::snprintf(text, sizeof text, format, values...);
  std::cout << text;
}

nlohmann::ordered_json in_us(const sim::Latency& latency) {
  return {{"median", latency.median}, {"p99", latency.p99}, {"max", latency.max}};
}

// Adds the arguments.
void add_arguments(const SelectArguments& arguments, nlohmann::ordered_json& line) {
  const Options& options = arguments.options;
  line["budget"] = arguments.budget;
  line["strategy"] = to_string(options.strategy);
  if (options.strategy == Strategy::stochastic_greedy) {
    line["epsilon"] = options.stochastic.epsilon;
    line["seed"] = options.stochastic.seed;
  }
}

void add_answer(const sim::Frame& frame, const Options& options, const Selection& selection,
                nlohmann::ordered_json& line) {
  line["status"] = to_string(selection.status);
  line["indices"] = std::vector<std::uint32_t>(selection.begin(), selection.end());
  line["ids"] = nlohmann::ordered_json::array();
  for (const std::uint32_t index : selection) line["ids"].push_back(frame.matches[index].map_point_id);
  line["gains"] = std::vector<double>(selection.gains, selection.gains + selection.size);
  line["log_det"] = selection.log_det;
  if (options.certificate) {
    line["upper_bound"] = selection.upper_bound;
    line["certified_efficiency"] = selection.certified_efficiency();
  }
  if (options.target_efficiency > 0) line["efficiency"] = selection.efficiency;
}

}  // namespace

void print_json(const sim::Frame& frame, const SelectArguments& arguments, const Selection& selection,
                const Timing& timing) {
  nlohmann::ordered_json line;
  line["frame"] = frame.name;
  line["candidates"] = frame.matches.size();
  line["invalid_candidates"] = selection.invalid_candidates;
  add_arguments(arguments, line);
  add_answer(frame, arguments.options, selection, line);
  line["evaluations"] = selection.evaluations;
  line["float64_decisions"] = selection.float64_decisions;
  line["latency_us"] = in_us(timing.select);
  line["blocks_latency_us"] = in_us(timing.blocks);
  line["threads"] = selection.threads;
  line["repeat"] = arguments.repeat;
  line["isa"] = active_isa();
  line["version"] = version();
  std::cout << sim::to_text(line) << std::flush;
}

void print_table_header(const SelectArguments& arguments) {
  std::cout << "maxlogdet " << version() << ", " << active_isa() << ": " << to_string(arguments.options.strategy)
            << ", budget " << arguments.budget << (arguments.stereo ? ", with stereo rows" : "") << ", "
            << arguments.repeat << " calls a frame\n\n";
  std::cout
      << "frame            candidates selected  status              log det evaluations    select us   blocks us\n"
         "                                                           (nats)              median    p99    median\n";
}

void print_table_row(const sim::Frame& frame, const Selection& selection, const Timing& timing) {
  print("%-16.255s %10zu %8zu  %-16s %10.4f %11zu %7.1f %6.1f %9.1f\n", frame.name.c_str(), frame.matches.size(),
        selection.size, to_string(selection.status), selection.log_det, selection.evaluations, timing.select.median,
        timing.select.p99, timing.blocks.median);
  std::cout << std::flush;
}

void print_reached(const Options& options, const Selection& selection) {
  if (options.target_efficiency > 0) {
    print("\nD-efficiency against all candidates %.3f %%\n", 100 * selection.efficiency);
  }
}

void print_selected(const sim::Frame& frame, const Selection& selection) {
  if (selection.size == 0) return;
  if (!std::isnan(selection.upper_bound)) {  // with --certify
    print("\nproved: no selection within the budget has a log det above %.4f; D-efficiency %.3f %%\n",
          selection.upper_bound, 100 * selection.certified_efficiency());
  }
  std::cout << "\nselected, in this order (match: gain in nats, pixel, depth)\n";
  constexpr std::size_t shown = 10;
  for (std::size_t i = 0; i < std::min(selection.size, shown); ++i) {
    const auto& match = frame.matches[selection.indices[i]];
    print("%8u: %8.4f   (%6.1f, %6.1f)   %7.2f m\n", selection.indices[i], selection.gains[i], match.u, match.v,
          in_camera(frame, match)[2]);
  }
  if (selection.size <= shown) return;
  std::cout << "  and";
  for (std::size_t i = shown; i < selection.size; ++i) std::cout << ' ' << selection.indices[i];
  std::cout << '\n';
}

std::string explained(Error error, const Options& options) {
  switch (error) {
    case Error::invalid_epsilon:
      return "epsilon " + std::to_string(options.stochastic.epsilon) + "; expected 0 < epsilon < 1 (--epsilon)";
    case Error::unsupported_isa: return sim::unsupported_isa_message();
    case Error::invalid_time_limit:
      return "--time-limit-ms " + std::to_string(1e3 * options.time_limit) + "; expected 0 (none) or more";
    case Error::invalid_target:
      return "--target-efficiency " + std::to_string(options.target_efficiency) + "; expected 0 (none) to 1";
    case Error::invalid_camera: return "expected fx,fy > 0, and bf > 0 for --stereo";
    case Error::invalid_block_options: return "expected a finite --map-sigma of 0 or more";
    default: return explain(error);
  }
}

}  // namespace maxlogdet::cli
