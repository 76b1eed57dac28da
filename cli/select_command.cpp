// SPDX-License-Identifier: MIT
#include "bench/world/executor.hpp"
#include "bench/world/frame_reader.hpp"
#include "bench/world/latency.hpp"
#include "bench/world/scene.hpp"
#include "cli/commands.hpp"
#include "cli/select_arguments.hpp"
#include "cli/select_output.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <algorithm>
#include <iostream>
#include <memory>
#include <optional>
#include <vector>

namespace maxlogdet::cli {
namespace {

constexpr std::size_t embedded_candidates = 2000;
constexpr std::uint64_t embedded_seed = 1;

void warn(const sim::Frame& frame, const SelectArguments& arguments) {
  for (const std::string& column : frame.unknown_columns) {
    std::cerr << "maxlogdet: frame " << frame.name << ": unknown column '" << column << "' is ignored\n";
  }
  const bool has_depth_cue =
      std::any_of(frame.matches.begin(), frame.matches.end(), [](const sim::Match& m) { return m.has_depth_cue(); });
  if (arguments.stereo && !has_depth_cue) {
    std::cerr << "maxlogdet: frame " << frame.name
              << ": --stereo, but no match has a right-image column (u_right) or a depth of known depth_sigma\n";
  }
}

std::vector<sim::Frame> frames_of(const std::string& input) {
  if (!input.empty()) return sim::read_frames(input);
  return {sim::make_scene(sim::Scene::euroc_like, embedded_candidates, embedded_seed)};
}

// A frame's third measurement is a right-image column, or a depth where the file says how uncertain it is.
std::vector<FeatureMatch> matches_of(const sim::Frame& frame, bool has_third_rows) {
  const DepthCue measured = frame.camera.depth_sigma > 0 ? DepthCue::depth : DepthCue::stereo;
  return feature_matches(frame, has_third_rows ? measured : DepthCue::none);
}

std::size_t max_matches(const std::vector<sim::Frame>& frames) {
  std::size_t maximum = 0;
  for (const sim::Frame& frame : frames) maximum = std::max(maximum, frame.matches.size());
  return maximum;
}

// One call of `select`.
class SelectCommand {
 public:
  explicit SelectCommand(const SelectArguments& arguments)
      : arguments_(arguments),
        frames_(frames_of(arguments.input)),
        grid_(arguments.image_grid()),
        options_(arguments.options),
        selector_(max_matches(frames_), sim::executor()),
        blocks_(max_matches(frames_)) {
    for (sim::Frame& frame : frames_) {
      if (arguments.ignores_covariances) frame.map_covariances.clear();
    }
    // A budget above every frame's size selects everything.
    options_.budget = std::min(static_cast<std::size_t>(arguments.budget), selector_.capacity());
    options_.groups.count = grid_ ? grid_->cells() : 0;
  }

  // Prints nothing unless every frame is usable.
  void run() {
    for (const sim::Frame& frame : frames_) try_out(frame);
    for (const sim::Frame& frame : frames_) select(frame);
  }

 private:
  bool is_alone() const { return frames_.size() == 1; }

  void use_cells_of(const sim::Frame& frame) {
    if (!grid_) return;
    cells_.clear();
    for (const sim::Match& match : frame.matches) cells_.push_back(grid_->cell_of(frame, match));
    options_.groups.ids = cells_.data();
  }

  Error build(const sim::Frame& frame, const std::vector<FeatureMatch>& matches) {
    BlockOptions options = arguments_.block_options;
    if (frame.camera.depth_sigma > 0) options.depth_sigma = frame.camera.depth_sigma;
    return build_blocks(frame, matches, options, blocks_).error;
  }

  void try_out(const sim::Frame& frame) {
    warn(frame, arguments_);
    const Error error = build(frame, matches_of(frame, arguments_.stereo));
    if (error != Error::none) throw sim::InputError("frame " + frame.name + ": " + explained(error, Options()));
    use_cells_of(frame);
    Options trial = options_;
    trial.budget = 0;
    const Selection selection = selector_.select(blocks_, trial);
    if (!selection.has_answer()) throw sim::InputError(explained(selection.error, options_));
  }

  void select(const sim::Frame& frame) {
    use_cells_of(frame);
    const std::vector<FeatureMatch> matches = matches_of(frame, arguments_.stereo);
    const auto repeat = static_cast<std::size_t>(arguments_.repeat);
    Timing timing;
    timing.blocks = sim::measure_latency(frame.name + ", blocks", repeat, [&] { build(frame, matches); });
    Selection selection{};
    timing.select =
        sim::measure_latency(frame.name + ", select", repeat, [&] { selection = selector_.select(blocks_, options_); });
    print(frame, selection, timing);
  }

  void print(const sim::Frame& frame, const Selection& selection, const Timing& timing) const {
    if (arguments_.as_json) return print_json(frame, arguments_, selection, timing);
    if (&frame == &frames_.front()) print_table_header(arguments_);
    print_table_row(frame, selection, timing);
    if (!is_alone()) return;
    print_reached(options_, selection);
    print_selected(frame, selection);
  }

  const SelectArguments& arguments_;
  std::vector<sim::Frame> frames_;
  std::optional<sim::ImageGrid> grid_;
  Options options_;
  Selector selector_;
  BlockStore blocks_;
  std::vector<std::uint32_t> cells_;
};

}  // namespace

void add_select_command(CLI::App& program) {
  CLI::App* const command =
      program.add_subcommand("select", "Select from all matches of frames, rejecting none, and time it");
  const auto arguments = std::make_shared<SelectArguments>();
  arguments->add_to(*command);
  command->callback([command, arguments] {
    arguments->complete(*command);
    SelectCommand(*arguments).run();
  });
}

}  // namespace maxlogdet::cli
