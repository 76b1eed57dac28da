// SPDX-License-Identifier: MIT
#include "bench/does_it_help/report.hpp"
#include "bench/does_it_track/arguments.hpp"
#include "bench/does_it_track/matching_comparison.hpp"
#include "bench/does_it_track/same_frame.hpp"
#include "bench/world/command_line.hpp"
#include "bench/world/draws.hpp"
#include "bench/world/input_error.hpp"
#include "bench/world/json_file.hpp"
#include "bench/world/progress.hpp"
#include "bench/world/stopwatch.hpp"
#include "bench/world/text.hpp"

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
#include <string>
#include <vector>

namespace sim = maxlogdet::sim;
using namespace stereo_odometry;

namespace {

constexpr int min_side = 64;  // px; the pyramid of a smaller image has no level to find corners in

std::vector<StereoTracker> make_trackers(const StereoDataset& dataset, const std::vector<Contestant>& contestants,
                                         std::uint64_t seed) {
  const sim::Pose T_wc = dataset.truth(0).value_or(sim::Pose::Identity());
  std::vector<StereoTracker> trackers;
  for (const Contestant& one : contestants) {
    TrackerOptions options = one.options;
    options.selection.seed = options.selection.search.stochastic.seed = seed;
    trackers.emplace_back(dataset.camera(), dataset.width(), dataset.height(), options, T_wc.inverse());
  }
  return trackers;
}

std::size_t index_of_inl(const std::vector<Contestant>& contestants) {
  const auto is_inl = [](const Contestant& one) { return one.name == "inl"; };
  return static_cast<std::size_t>(std::find_if(contestants.begin(), contestants.end(), is_inl) - contestants.begin());
}

void write_overlay(const Arguments& arguments, const std::string& name, std::size_t frame, const cv::Mat& image,
                   const FrameResult& result) {
  const std::string number = std::to_string(frame);
  const std::string file = arguments.output + "/" + name + "/overlay_" +
                           std::string(number.size() < 6 ? 6 - number.size() : 0, '0') + number + ".png";
  if (!cv::imwrite(file, overlay(image, result), {cv::IMWRITE_PNG_COMPRESSION, 9})) {
    throw sim::InputError(file + ": cannot be written; expected a folder with room for pictures");
  }
}

void warn_if_lost(const std::string& name, std::size_t frame, FrameStatus status) {
  if (status == FrameStatus::tracked || frame == 0) return;
  std::cerr << "stereo_odometry: " << name << ": frame " << frame
            << ": too few matches; continues with the pose that constant velocity predicts"
            << (status == FrameStatus::initialized ? ", and a new map\n" : "\n");
}

// The frames of the first run of inl, on which everything is compared.
struct SameFrames {
  explicit SameFrames(const StereoDataset& from, const TrackerOptions& of_inl)
      : dataset(from),
        options(of_inl),
        matching(from.camera(), from.width(), from.height(), of_inl, sim::EvaluationOptions().budgets) {}

  void add(const TrackedFrame& tracked, std::size_t number) {
    frames.push_back(frame_of(tracked, options.optimization.stereo));
    frames.back().name = "frame " + std::to_string(number);
    if (const auto& T_wc = dataset.truth(number)) frames.back().T_cw_true = sim::to_rows(T_wc->inverse());
    matching.add(tracked);
  }

  const StereoDataset& dataset;
  const TrackerOptions& options;
  std::vector<sim::Frame> frames;
  MatchingComparison matching;
};

// One pass over the dataset with a tracker for each contestant. All get the same features of a frame, one after the
// other, in an order drawn for each frame, so that a transient load slows all of them down. Later runs have more
// keypoints: errors of whole runs move with any setting, and their spread tells how much.
std::vector<Run> track(const StereoDataset& dataset, const Arguments& arguments,
                       const std::vector<Contestant>& contestants, std::size_t run, SameFrames& same,
                       sim::Progress& progress) {
  const std::size_t frames = arguments.frames == 0 ? dataset.size() : std::min(arguments.frames, dataset.size());
  const bool is_first = run == 0;
  FeatureExtractor extractor(dataset.camera(), arguments.features + static_cast<int>(run) * arguments.features / 50);
  std::vector<StereoTracker> trackers = make_trackers(dataset, contestants, arguments.seed + run);
  std::size_t i = 0;
  if (is_first) {
    trackers[index_of_inl(contestants)].observe([&](const TrackedFrame& tracked) { same.add(tracked, i); });
  }
  std::vector<Run> runs(contestants.size());
  std::vector<std::uint32_t> order(contestants.size());
  std::iota(order.begin(), order.end(), 0U);
  sim::Draws draws(arguments.seed + run);
  for (; i < frames; ++i) {
    const StereoImages images = dataset.load(i);
    const bool has_overlay = is_first && arguments.overlays > 0 && i % arguments.overlays == 0;
    double ms_extraction = 0;
    sim::Stopwatch watch;
    const StereoFeatures features = extractor.extract(images);
    watch.lap(ms_extraction);
    draws.shuffle_front(order, order.size());
    for (const std::uint32_t c : order) {
      const std::string& name = contestants[c].name;
      const FrameResult& result = trackers[c].track(features);
      if (has_overlay) write_overlay(arguments, name, i, images.left, result);
      if (is_first) warn_if_lost(name, i, result.status);
      if (is_first && arguments.writes_residuals) runs[c].residuals += residual_lines(i, result);
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

void check_size(const Arguments& arguments, const StereoDataset& dataset) {
  if (dataset.width() >= min_side && dataset.height() >= min_side) return;
  const std::string side = std::to_string(min_side);
  throw sim::InputError(arguments.dataset + ": images of " + std::to_string(dataset.width()) + " x " +
                        std::to_string(dataset.height()) + " px; expected at least " + side + " x " + side);
}

void make_folders(const Arguments& arguments, const std::vector<Contestant>& contestants) {
  for (const Contestant& one : contestants) {
    std::error_code error;
    std::filesystem::create_directories(arguments.output + "/" + one.name, error);
    if (error) throw sim::InputError(arguments.output + ": cannot be made; expected a folder that can be written to");
  }
}

void warn_of_partial_truth(const StereoDataset& dataset) {
  std::size_t known = 0;
  for (std::size_t i = 0; i < dataset.size(); ++i) known += dataset.truth(i) ? 1 : 0;
  if (known == 0 || known == dataset.size()) return;
  std::cerr << "stereo_odometry: ground truth is known for " << known << " of " << dataset.size()
            << " frames: errors are of these\n";
}

// What all selectors show on the same frames, as text.
std::string compare(const Arguments& arguments, SameFrames& same) {
  if (same.frames.empty()) {
    std::cerr << "stereo_odometry: inl tracks no frame, so that nothing is compared on the same frames\n";
    return "";
  }
  if (!arguments.record.empty()) record(same.frames, arguments.record);
  const sim::Evaluation evaluation = evaluate(same.frames, same.options, arguments.threads);
  sim::write_json(arguments.output + "/same_frame.json", to_json(evaluation));
  const nlohmann::ordered_json matching = same.matching.to_json();
  sim::write_json(arguments.output + "/matching.json", matching, 1);
  return to_text(evaluation) +
         "\nThe same with the tracker's own optimiser, and how many points were searched for: matching in the order "
         "of\n"
         "information or in random order until as many are found, or selecting among the inliers of all matches.\n\n" +
         to_markdown(matching_table(matching)) + '\n';
}

void report(const Arguments& arguments, const std::vector<Summary>& summaries, SameFrames& same) {
  const std::string text = compare(arguments, same) +
                           "Whole runs: errors against the ground truth, from frame to frame, and as multiples of "
                           "those of inl, the mean over\n"
                           "runs and their range.\n\n" +
                           to_markdown(summary_table(summaries));
  std::cout << text;
  sim::write_file(arguments.output + "/summary.md", text);
  sim::write_json(arguments.output + "/summary.json", to_json(summaries), 1);
}

void run(const Arguments& arguments) {
  const std::unique_ptr<StereoDataset> dataset = open_dataset(arguments.dataset);
  check_size(arguments, *dataset);
  const std::vector<Contestant> contestants = contestants_of(arguments);
  cv::setNumThreads(arguments.threads);
  make_folders(arguments, contestants);
  warn_of_partial_truth(*dataset);
  std::vector<Summary> summaries;
  for (const Contestant& one : contestants) summaries.push_back({one, {}});
  SameFrames same(*dataset, contestants[index_of_inl(contestants)].options);
  sim::Progress progress("stereo_odometry " + dataset->name(), "frame");
  for (std::size_t r = 0; r < arguments.runs; ++r) {
    const std::vector<Run> runs = track(*dataset, arguments, contestants, r, same, progress);
    for (std::size_t c = 0; c < runs.size(); ++c) summaries[c].runs.push_back(outcome_of(runs[c], *dataset));
    if (r == 0) write(arguments, *dataset, contestants, runs);
  }
  report(arguments, summaries, same);
}

int fail(const std::string& message) {
  std::cerr << "stereo_odometry: " << sim::one_line(message) << '\n';
  return 2;
}

int flush() { return std::cout.flush() ? 0 : fail("standard output could not be written"); }

}  // namespace

int main(int argc, char** argv) {
  std::signal(SIGXFSZ, SIG_IGN);  // then writing beyond a limit of file size fails, as on a full disk
  try {
    CLI::App program("Stereo visual odometry that optimises its pose with selected matches, once per selector.");
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
    arguments.finish(program);
    run(arguments);
    return flush();
  } catch (const std::exception& error) {  // sim::InputError among them
    return fail(error.what());
  }
}
