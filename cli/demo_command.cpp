// SPDX-License-Identifier: MIT
#include "bench/world/draws.hpp"
#include "bench/world/latency.hpp"
#include "bench/world/names.hpp"
#include "bench/world/output_file.hpp"
#include "bench/world/pose_optimizer.hpp"
#include "bench/world/progress.hpp"
#include "bench/world/text_file.hpp"
#include "bench/world/tracker_frames.hpp"
#include "cli/commands.hpp"

#include <maxlogdet/eigen.hpp>
#include <maxlogdet/maxlogdet.hpp>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>
#include <string>
#include <vector>

namespace maxlogdet::cli {
namespace {

constexpr std::size_t frame_count = 200, match_count = 465, budget = 100;

using Indices = std::vector<std::uint32_t>;

// Matches to compute a pose from, and where the optimisation starts.
struct Chosen {
  Indices matches;
  sim::Pose start;
  bool is_final = false;  // no optimisation follows
};

// A frame, as a tracker has it before it knows its pose.
class DemoFrame {
 public:
  explicit DemoFrame(std::uint64_t seed)
      : made_(sim::monocular_tracker, match_count, seed), matches_(made_.frame.matches) {
    for (std::size_t i = 0; i < match_count; ++i) {
      matches_[i].u = made_.measured[i].measured[0];
      matches_[i].v = made_.measured[i].measured[1];
    }
  }

  const sim::Frame& frame() const { return made_.frame; }
  const std::vector<sim::Match>& matches() const { return matches_; }
  bool is_wrong(std::size_t i) const { return made_.is_wrong[i] != 0; }
  sim::Pose true_pose() const { return sim::pose_of(made_.frame.T_cw_prior); }

  void pass_to(GoodFeatures& good) const {
    good.start(made_.frame.camera, made_.T_predicted);
    for (const FeatureMatch& match : made_.measured) good.add(match);
  }

  Chosen all() const {
    Indices every(match_count);
    std::iota(every.begin(), every.end(), 0U);
    return {every, made_.T_predicted};
  }

  // As ORB-SLAM2 does it.
  sim::Pose optimized(const Chosen& chosen) const {
    sim::RejectionOptions options;
    options.stereo = false;
    return sim::reject_outliers(made_.frame.camera, matches_, chosen.matches, chosen.start, options).estimate.T_cw;
  }

 private:
  sim::TrackerFrame made_;  // its own matches are without noise
  std::vector<sim::Match> matches_;
};

// One way of choosing, and what it brings: sums over frames.
struct Contestant {
  std::string name;
  std::function<Chosen(const DemoFrame&)> choose;
  Indices of_first_frame = {};
  std::size_t matches = 0, wrong = 0;
  double square_distance = 0, square_angle = 0;  // errors of the pose, m^2 and deg^2
  std::vector<double> choosing_us = {}, optimizing_us = {};

  void add(const DemoFrame& frame) {
    Chosen chosen;
    choosing_us.push_back(sim::microseconds_of([&] { chosen = choose(frame); }));
    sim::Pose pose = chosen.start;
    optimizing_us.push_back(sim::microseconds_of([&] {
      if (!chosen.is_final) pose = frame.optimized(chosen);
    }));
    if (matches == 0) of_first_frame = chosen.matches;
    matches += chosen.matches.size();
    for (const std::uint32_t i : chosen.matches) wrong += frame.is_wrong(i) ? 1 : 0;
    square_distance += std::pow(sim::camera_distance(pose, frame.true_pose()), 2);
    square_angle += std::pow(sim::camera_angle_deg(pose, frame.true_pose()), 2);
  }
};

class Demonstration {
 public:
  Demonstration() {
    sim::Progress progress("demo", "frame");
    for (std::size_t i = 0; i < frame_count; ++i) {
      const DemoFrame frame(i + 1);
      for (Contestant& contestant : contestants_) contestant.add(frame);
      progress.update(i + 1, frame_count);
    }
  }

  void print() const {
    std::cout << "maxlogdet " << version() << ", " << active_isa() << "\n\n"
              << frame_count << " simulated frames of a tracker. Each has " << match_count
              << " matches, of which 12 % are wrong, and a predicted pose, which is\n"
                 "off by 2 cm and 0.1 degrees. From which matches is the pose to be optimised?\n\n"
                 "                     matches  of these   position   rotation   time to choose   time to optimise\n"
                 "                     a frame     wrong      error      error      the matches           the pose\n"
                 "                                        (all = 1)  (all = 1)             (us)               (us)\n";
    for (const Contestant& contestant : contestants_) print(contestant);
    std::cout << "\nErrors are root mean squares over that of all matches, times are medians. Optimising, by code of\n"
                 "ours, rejects wrong matches as ORB-SLAM2 does. The last row needs no optimisation: maxlogdet itself\n"
                 "computes this pose, from all matches that it takes for correct.\n";
  }

  // The first frame, as tools/draw draws it.
  nlohmann::ordered_json picture() const {
    const DemoFrame frame(1);
    nlohmann::ordered_json data = {{"width_px", frame.frame().width}, {"height_px", frame.frame().height}};
    for (std::size_t i = 0; i < match_count; ++i) {
      data["u_px"].push_back(frame.matches()[i].u);
      data["v_px"].push_back(frame.matches()[i].v);
      data["is_wrong"].push_back(frame.is_wrong(i));
    }
    for (const Contestant& contestant : contestants_) {
      data["choices"].push_back({{"name", contestant.name},
                                 {"matches", contestant.of_first_frame},
                                 {"position_error", distance_over_all(contestant)}});
    }
    return data;
  }

 private:
  void print(const Contestant& contestant) const {
    const auto mean = [](std::size_t sum) { return static_cast<double>(sum) / frame_count; };
    char row[128];
    std::snprintf(row, sizeof row, "%-20s %7.0f %9.1f %10.2f %10.2f %16.0f %18.0f\n", contestant.name.c_str(),
                  mean(contestant.matches), mean(contestant.wrong), distance_over_all(contestant),
                  std::sqrt(contestant.square_angle / contestants_[0].square_angle),
                  sim::latency_of(contestant.choosing_us).median, sim::latency_of(contestant.optimizing_us).median);
    std::cout << row;
  }

  double distance_over_all(const Contestant& contestant) const {
    return std::sqrt(contestant.square_distance / contestants_[0].square_distance);
  }

  Chosen random(const DemoFrame& frame) {
    Chosen chosen = frame.all();
    draws_.shuffle_front(chosen.matches, budget);
    chosen.matches.resize(budget);
    return chosen;
  }

  Chosen selected(const DemoFrame& frame) {
    frame.pass_to(good_);
    const Selection selection = good_.select(budget);
    return {{selection.begin(), selection.end()}, good_.pose()};
  }

  Chosen aligned(const DemoFrame& frame) {
    frame.pass_to(good_);
    good_.align();
    Chosen chosen{{}, good_.pose(), true};
    for (std::uint32_t i = 0; i < match_count; ++i) {
      if (good_.is_inlier(i)) chosen.matches.push_back(i);
    }
    return chosen;
  }

  GoodFeatures good_{match_count};
  sim::Draws draws_{0};
  std::array<Contestant, 4> contestants_ = {
      Contestant{"all", [](const DemoFrame& frame) { return frame.all(); }},
      {"100 random", [this](const DemoFrame& frame) { return random(frame); }},
      {"100 selected", [this](const DemoFrame& frame) { return selected(frame); }},
      {"maxlogdet's pose()", [this](const DemoFrame& frame) { return aligned(frame); }}};
};

void check_plot_data(const std::string& file) {
  if (file.empty()) return;
  sim::require_input(std::filesystem::path(file).extension() == ".json",
                     "--plot-data '" + file + "'; expected a file that ends in .json");
  sim::check_output_file(file);
}

}  // namespace

void add_demo_command(CLI::App& program) {
  CLI::App* const command =
      program.add_subcommand("demo", "Compare poses from all, random and selected matches of simulated frames");
  const auto plot_data = std::make_shared<std::string>();
  command->add_option("--plot-data", *plot_data,
                      "Write the data of a picture into this .json file; tools/draw of the sources draws it");
  command->callback([plot_data] {
    sim::require_input(isa_is_supported(active_isa()), sim::unsupported_isa_message());
    check_plot_data(*plot_data);
    const Demonstration demonstration;
    if (!plot_data->empty()) sim::write_file(*plot_data, sim::to_text(demonstration.picture()));
    demonstration.print();
  });
}

}  // namespace maxlogdet::cli
