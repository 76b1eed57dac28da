// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/frame.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>

namespace maxlogdet::cli {

/// Options of `select`.
struct SelectArguments {
  std::string input;  ///< empty: the embedded synthetic frame
  Options options;    ///< except budget and groups
  BlockOptions block_options;
  std::int64_t budget = 200;
  std::string strategy = "lazy_greedy";
  bool ignores_covariances = false;
  std::string seed = "0";
  bool stereo = false;
  std::int64_t repeat = 100;
  bool as_json = false;
  std::int64_t threads = 0;
  double time_limit_ms = 0;
  std::string grid;  ///< empty: no groups
  std::int64_t max_per_cell = 1;

  void add_to(CLI::App& command);

  /// Checks combinations, and sets `options` and `block_options` by the other members, once the command line has been
  /// parsed. Throws sim::InputError.
  void complete(const CLI::App& command);

  /// Returns the cells of --grid; nothing without it. Throws sim::InputError.
  std::optional<sim::ImageGrid> image_grid() const;
};

}  // namespace maxlogdet::cli
