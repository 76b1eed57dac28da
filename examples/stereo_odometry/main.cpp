// SPDX-License-Identifier: MIT
#include "examples/stereo_odometry/report.hpp"
#include "sim/command_line.hpp"
#include "sim/draws.hpp"
#include "sim/input_error.hpp"
#include "sim/json_file.hpp"
#include "sim/names.hpp"
#include "sim/progress.hpp"
#include "sim/stopwatch.hpp"
#include "sim/text.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <iostream>
#include <numeric>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgcodecs.hpp>

namespace sim = maxlogdet::sim;
using namespace stereo_odometry;

namespace {

constexpr const char* active_name = "active";
constexpr std::size_t largest_budget = 100'000;
constexpr int min_side = 64;  // px; smaller ones have no pyramid to find corners in

struct Arguments {
  std::string dataset;
  std::string output;
  std::vector<std::string> selectors = sim::names_of(sim::selector_kinds);
  std::vector<std::size_t> budgets = {100};
  std::vector<double> targets;
  std::size_t runs = 10;
  std::size_t frames = 0;
  int features = 2000;
  int threads = 1;
  std::size_t overlays = 10;
  std::uint64_t seed = 0;
  std::string strategy = "lazy_greedy";
  std::string weighting = "measurement_and_map";
  std::string weights = "measurement_and_map";
  std::string residuals = "stereo";
  std::string noise = "motion";
  bool writes_residuals = false;
  TrackerOptions options;

  void add_to(CLI::App& program);
};

void Arguments::add_to(CLI::App& program) {
  selectors.emplace_back(active_name);
  std::vector<std::string> names = selectors;
  program.add_option("--dataset", dataset, "Folder in the layout of KITTI odometry, EuRoC (ASL) or TUM RGB-D")
      ->required();
  program.add_option("--output", output, "Folder for trajectories, tables and pictures")->required();
  program.add_option("--selectors", selectors, "What is compared; active matches in the order of information")
      ->delimiter(',')
      ->check(CLI::IsMember(names))
      ->capture_default_str();
  program.add_option("--budget", budgets, "Matches that a selector may use; several are compared")
      ->delimiter(',')
      ->check(CLI::Range(std::size_t{20}, largest_budget))
      ->capture_default_str();
  program
      .add_option("--target-efficiency", targets,
                  "md also without a budget: until its D-efficiency against all inliers is that")
      ->delimiter(',')
      ->check(CLI::Range(1e-6, 1.0));
  program.add_option("--tau", options.selection.tau, "shared_cells, shared_keyframes: what a group shares, px")
      ->check(CLI::Range(0.0, 1000.0))
      ->capture_default_str();
  program.add_option("--slack", options.selection.slack, "md_cells, md_keyframes: over an even share of the budget")
      ->check(CLI::Range(1.0, 1000.0))
      ->capture_default_str();
  program.add_option("--runs", runs, "Repetitions: other random numbers, times once more")
      ->check(CLI::Range(std::size_t{1}, std::size_t{10'000}))
      ->capture_default_str();
  const auto count = CLI::Range(std::int64_t{0}, std::int64_t{1'000'000'000});  // -1 would be read as the most there is
  program.add_option("--frames", frames, "Only so many of the first; 0: all")->check(count)->capture_default_str();
  program.add_option("--features", features, "Keypoints an image")
      ->check(CLI::Range(100, 20'000))
      ->capture_default_str();
  program.add_option("--threads", threads, "Of selection and of OpenCV; the result does not depend on it")
      ->check(CLI::Range(1, 16))
      ->capture_default_str();
  program.add_option("--overlays", overlays, "Draw the features of every so manyth frame; 0: none")
      ->check(count)
      ->capture_default_str();
  program.add_option("--seed", seed, "Of the random selectors")->capture_default_str();
  program.add_option("--strategy", strategy, "Search of md, quality_md")
      ->check(CLI::IsMember(sim::names_of(sim::strategies)))
      ->capture_default_str();
  program.add_option("--epsilon", options.selection.search.epsilon, "Of stochastic_greedy")
      ->check(CLI::Range(1e-6, 1 - 1e-6))
      ->capture_default_str();
  program.add_option("--weighting", weighting, "Blocks of md, quality_md, active")
      ->check(CLI::IsMember(sim::names_of(sim::weightings)))
      ->capture_default_str();
  program.add_option("--weights", weights, "What residuals are whitened by, whatever selects")
      ->check(CLI::IsMember({"measurement", "measurement_and_map"}))
      ->capture_default_str();
  program.add_option("--noise", noise, "Of matches: the same for all, by image motion, or that estimated as it goes")
      ->check(CLI::IsMember({"constant", "motion", "online"}))
      ->capture_default_str();
  program.add_option("--noise-base", options.noise.base, "Deviation without motion, px (constant: 0.5, unless given)")
      ->check(CLI::Range(0.01, 10.0))
      ->capture_default_str();
  program.add_option("--noise-growth", options.noise.growth, "Variance is base^2 + growth^2 motion, px^(1/2)")
      ->check(CLI::Range(0.0, 10.0))
      ->capture_default_str();
  program.add_flag("--write-residuals", writes_residuals, "Write residuals.csv of the first run: a line a match");
  program.add_option("--batch", options.batch, "active: points that are searched for at once")
      ->check(CLI::Range(std::size_t{1}, std::size_t{100'000}))
      ->capture_default_str();
  program.add_option("--residuals", residuals, "Rows of a match: with its right-image column, or without")
      ->check(CLI::IsMember({"stereo", "monocular"}))
      ->capture_default_str();
  program.add_option("--pool", options.selection.pool, "quality_md: candidates by quality")
      ->check(count)
      ->capture_default_str();
}

// Options that would change nothing are mistakes.
void check_used(const CLI::App& program, const Arguments& arguments) {
  bool has_budget = false, has_strategy = false, has_blocks = false, has_pool = false, is_active = false;
  bool has_target = false, shares = false, has_slack = false;
  for (const std::string& name : arguments.selectors) {
    const std::optional<sim::SelectorKind> kind = sim::find_named(sim::selector_kinds, name);
    has_target = has_target || kind == sim::SelectorKind::md;
    shares = shares || (kind && sim::shares_errors(*kind));
    has_slack = has_slack || kind == sim::SelectorKind::md_cells || kind == sim::SelectorKind::md_keyframes;
    is_active = is_active || name == active_name;
    has_pool = has_pool || kind == sim::SelectorKind::quality_md;
    has_strategy = has_strategy || (kind && sim::uses_strategy(*kind));
    has_blocks = has_blocks || (kind && sim::uses_blocks(*kind)) || name == active_name;
    has_budget = has_budget || name == active_name || (kind && sim::has_budget(*kind));
  }
  const bool is_stochastic = has_strategy && arguments.strategy == "stochastic_greedy";
  sim::refuse_idle(program, "--budget", has_budget, "a selector that has one");
  if (!arguments.targets.empty() && (arguments.strategy == "relaxed" || arguments.strategy == "backward_greedy")) {
    throw sim::InputError("--target-efficiency with --strategy " + arguments.strategy +
                          ": expected one that selects one match after the other");
  }
  if (shares && arguments.weighting.rfind("map_bias", 0) == 0) {
    throw sim::InputError("shared_cells, shared_keyframes with --weighting " + arguments.weighting +
                          ": expected --selectors without them, or blocks in pixels");
  }
  sim::refuse_idle(program, "--target-efficiency", has_target, "--selectors md");
  sim::refuse_idle(program, "--tau", shares, "--selectors shared_cells or shared_keyframes");
  sim::refuse_idle(program, "--slack", has_slack, "--selectors md_cells or md_keyframes");
  sim::refuse_idle(program, "--strategy", has_strategy, "a selector that searches");
  sim::refuse_idle(program, "--epsilon", is_stochastic, "--strategy stochastic_greedy");
  sim::refuse_idle(program, "--weighting", has_blocks, "a selector that has blocks");
  sim::refuse_idle(program, "--noise-growth", arguments.noise != "constant", "--noise motion or online");
  sim::refuse_idle(program, "--batch", is_active, "--selectors active");
  sim::refuse_idle(program, "--pool", has_pool, "--selectors quality_md");
}

std::vector<Contestant> contestants_of(const Arguments& arguments) {
  TrackerOptions options = arguments.options;
  options.optimization.stereo = arguments.residuals == "stereo";
  options.optimization.step_tolerance = 1e-6;
  options.selection.search.threads = arguments.threads;
  options.estimates_noise = arguments.noise == "online";
  options.keeps_residuals = arguments.writes_residuals;
  options.selection.blocks.weighting = *sim::find_named(sim::weightings, arguments.weighting);
  options.selection.weights = *sim::find_named(sim::weightings, arguments.weights);
  options.selection.blocks.third =
      options.optimization.stereo ? maxlogdet::ThirdMeasurement::stereo : maxlogdet::ThirdMeasurement::none;
  options.selection.blocks.threads = 1;
  std::vector<Contestant> contestants;
  for (const std::string& name : arguments.selectors) {
    options.active = name == active_name;
    options.selection.search.strategy =  // one after the other, it can only be greedy
        options.active ? maxlogdet::Strategy::automatic : *sim::find_named(sim::strategies, arguments.strategy);
    options.selection.kind = options.active ? sim::SelectorKind::md : *sim::find_named(sim::selector_kinds, name);
    if (!has_budget(options.selection.kind)) {
      contestants.push_back({name, name, std::nullopt, std::nullopt, options});
      continue;
    }
    for (const std::size_t budget : arguments.budgets) {
      options.selection.budget = budget;
      options.selection.pool = std::max(arguments.options.selection.pool, budget);
      const std::string suffix = arguments.budgets.size() > 1 ? "_" + std::to_string(budget) : "";
      contestants.push_back({name + suffix, name, budget, std::nullopt, options});
    }
    if (options.selection.kind != sim::SelectorKind::md || options.active) continue;
    for (const double target : arguments.targets) {
      TrackerOptions until = options;
      until.selection.budget = largest_budget;
      until.selection.search.target_efficiency = target;
      contestants.push_back({name + "_efficiency_" + sim::exact(target), name, std::nullopt, target, until});
    }
  }
  return contestants;
}

template <class Item>
void refuse_doubles(const std::vector<Item>& items, const std::string& option) {
  for (auto item = items.begin(); item != items.end(); ++item) {
    if (std::find(items.begin(), item, *item) != item) {
      throw sim::InputError(option + ": the same twice; expected each once");
    }
  }
}

// One pass over the dataset with a tracker for each contestant. All get the same features of a frame, one after the
// other, in an order drawn for every frame: what the machine does meanwhile hits all alike.
std::vector<Run> track(const StereoDataset& dataset, const Arguments& arguments,
                       const std::vector<Contestant>& contestants, std::size_t run, sim::Progress& progress) {
  const std::size_t frames = arguments.frames == 0 ? dataset.size() : std::min(arguments.frames, dataset.size());
  FeatureExtractor extractor(dataset.camera(), arguments.features);
  std::vector<StereoTracker> trackers;
  for (const Contestant& one : contestants) {
    TrackerOptions options = one.options;
    options.selection.seed = options.selection.search.seed = arguments.seed + run;
    const sim::Pose T_wc = dataset.truth(0).value_or(sim::Pose::Identity());
    trackers.emplace_back(dataset.camera(), dataset.width(), dataset.height(), options, T_wc.inverse());
  }
  std::vector<Run> runs(contestants.size());
  std::vector<std::uint32_t> order(contestants.size());
  std::iota(order.begin(), order.end(), 0U);
  sim::Draws draws(arguments.seed + run);
  for (std::size_t i = 0; i < frames; ++i) {
    const StereoImages images = dataset.load(i);
    double ms_extraction = 0;
    sim::Stopwatch watch;
    const StereoFeatures features = extractor.extract(images);
    watch.lap(ms_extraction);
    draws.shuffle_front(order, order.size());
    for (const std::uint32_t c : order) {
      const FrameResult& result = trackers[c].track(features);
      if (run == 0 && arguments.overlays > 0 && i % arguments.overlays == 0) {
        const std::string number = std::to_string(i);
        const std::string file = arguments.output + "/" + contestants[c].name + "/overlay_" +
                                 std::string(number.size() < 6 ? 6 - number.size() : 0, '0') + number + ".png";
        if (!cv::imwrite(file, overlay(images.left, result, contestants[c].name))) {
          throw sim::InputError(file + ": cannot be written; expected a folder with room for pictures");
        }
      }
      if (run == 0 && result.status != FrameStatus::tracked && i > 0) {
        std::cerr << "stereo_odometry: " << contestants[c].name << ": frame " << i
                  << ": too few matches; goes on where constant velocity leads"
                  << (result.status == FrameStatus::initialized ? ", with a new map\n" : "\n");
      }
      if (run == 0 && arguments.writes_residuals) runs[c].residuals += residual_lines(i, result);
      runs[c].frames.push_back({dataset.time(i), ms_extraction, features.size(), result});
      runs[c].frames.back().drop_lists();
    }
    progress.update(run * frames + i + 1, arguments.runs * frames);
  }
  return runs;
}

void write(const Arguments& arguments, const StereoDataset& dataset, const std::vector<Contestant>& contestants,
           const std::vector<Run>& runs) {
  for (std::size_t c = 0; c < runs.size(); ++c) {
    const std::string folder = arguments.output + "/" + contestants[c].name;
    sim::write_tum({contestants[c].name, runs[c].trajectory()}, folder + "/trajectory_tum.txt");
    sim::write_file(folder + "/trajectory_kitti.txt", to_kitti(runs[c]));
    sim::write_file(folder + "/frames.csv", to_csv(frame_table(runs[c])));
    if (arguments.writes_residuals) sim::write_file(folder + "/residuals.csv", residual_header() + runs[c].residuals);
  }
  sim::write_json(arguments.output + "/trajectories.json", trajectories_to_json(contestants, runs, dataset));
}

void run(const Arguments& arguments) {
  refuse_doubles(arguments.selectors, "--selectors");
  refuse_doubles(arguments.budgets, "--budget");
  refuse_doubles(arguments.targets, "--target-efficiency");
  const std::unique_ptr<StereoDataset> dataset = open_dataset(arguments.dataset);
  if (dataset->width() < min_side || dataset->height() < min_side) {
    throw sim::InputError(arguments.dataset + ": images of " + std::to_string(dataset->width()) + " x " +
                          std::to_string(dataset->height()) + " px; expected at least " + std::to_string(min_side) +
                          " x " + std::to_string(min_side));
  }
  const std::vector<Contestant> contestants = contestants_of(arguments);
  cv::setNumThreads(arguments.threads);
  for (const Contestant& one : contestants) {
    std::error_code error;
    std::filesystem::create_directories(arguments.output + "/" + one.name, error);
    if (error) throw sim::InputError(arguments.output + ": cannot be made; expected a folder that can be written to");
  }
  std::size_t known = 0;
  for (std::size_t i = 0; i < dataset->size(); ++i) known += dataset->truth(i) ? 1 : 0;
  if (known > 0 && known < dataset->size()) {
    std::cerr << "stereo_odometry: ground truth is known for " << known << " of " << dataset->size()
              << " frames: errors are of these\n";
  }
  std::vector<Summary> summaries;
  for (const Contestant& one : contestants) summaries.push_back({one, {}});
  sim::Progress progress("stereo_odometry " + dataset->name(), "frame");
  for (std::size_t r = 0; r < arguments.runs; ++r) {
    const std::vector<Run> runs = track(*dataset, arguments, contestants, r, progress);
    for (std::size_t c = 0; c < runs.size(); ++c) summaries[c].runs.push_back(outcome_of(runs[c], *dataset));
    if (r == 0) write(arguments, *dataset, contestants, runs);
  }
  std::string report = to_markdown(summary_table(summaries));
  const sim::Table comparison = comparison_table(summaries, "inl");
  if (!comparison.rows.empty()) report += '\n' + to_markdown(comparison);
  std::cout << report;
  sim::write_file(arguments.output + "/summary.md", report);
  sim::write_json(arguments.output + "/summary.json", to_json(summaries), 1);
}

int fail(const std::string& message) {
  std::cerr << "stereo_odometry: " << sim::one_line(message) << '\n';
  return 2;
}

int flush() { return std::cout.flush() ? 0 : fail("standard output could not be written"); }

}  // namespace

int main(int argc, char** argv) {
  std::signal(SIGXFSZ, SIG_IGN);  // beyond a limit of file size writing fails, as on a full disk
  try {
    CLI::App program("Stereo visual odometry that optimises its pose with selected matches, once with every selector.");
    program.name("stereo_odometry");
    Arguments arguments;
    arguments.add_to(program);
    sim::refuse_empty_values(program);
    try {
      program.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
      if (error.get_exit_code() == 0) {  // --help
        program.exit(error);
        return flush();
      }
      return fail(std::string(error.what()) + " (see --help)");
    }
    check_used(program, arguments);
    if (arguments.noise == "constant") {
      if (program.count("--noise-base") == 0) arguments.options.noise.base = aligned_sigma;
      arguments.options.noise.growth = 0;
    }
    run(arguments);
    return flush();
  } catch (const std::exception& error) {  // sim::InputError among them
    return fail(error.what());
  }
}
