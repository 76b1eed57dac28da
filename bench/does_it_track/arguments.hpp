// SPDX-License-Identifier: MIT
#pragma once

#include "bench/does_it_track/report.hpp"
#include "bench/world/names.hpp"

#include <CLI/CLI.hpp>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace stereo_odometry {

constexpr const char* active_name = "active";          ///< the contestant that matches in the order of information
constexpr const char* random_order = "active_random";  ///< the one that matches as many in random order

/// The command line of the program.
struct Arguments {
  std::string dataset;
  std::string output;
  std::string record;  ///< folder for the frames that selectors are compared on; empty: none
  std::vector<std::string> selectors = {"md", active_name, random_order, "random", "inl", "all"};
  std::vector<std::size_t> budgets = {100};
  std::size_t runs = 3;
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

  /// Completes the arguments after parsing. Throws InputError if options repeat a value or have no effect.
  void finish(const CLI::App& program);

 private:
  void add_data(CLI::App& program);
  void add_contestants(CLI::App& program);
  void add_selection(CLI::App& program);
  void add_noise(CLI::App& program);
};

/// The contestants that the arguments ask for, and `inl`, on whose frames all selectors are compared.
std::vector<Contestant> contestants_of(const Arguments& arguments);

}  // namespace stereo_odometry
