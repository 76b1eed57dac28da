// SPDX-License-Identifier: MIT
// A fixed list of selections on every instruction set of this machine; a line each: instruction set, what was selected
// from and how, how many, a hash of their indices, and one of the bits of gains, log det and bound. ci/check_compilers
// compares the lines of differently compiled programs.
#include "bench/world/hash.hpp"
#include "kernel/base/counter_random.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <cinttypes>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

namespace maxlogdet {
namespace {

void add_bits(sim::Hash& hash, double number) {
  std::uint64_t bits = 0;
  std::memcpy(&bits, &number, sizeof bits);
  hash.add(bits);
}

// Where the points are; the numbers come by + - * alone, so that they are the same everywhere.
constexpr const char* families[] = {"room", "far_away", "clustered", "copies"};

// n points, n x 3, m, in front of a camera that looks along z.
std::vector<double> points_of(const std::string& family, std::size_t n) {
  CounterRandom random(n + family.size());
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * (static_cast<double>(random.bits() >> 11) * 0x1p-53);
  };
  std::vector<double> points;
  for (std::size_t i = 0; i < n; ++i) {
    const double z = family == "far_away" ? uniform(40, 400) : uniform(1, 12);
    double x = uniform(-0.6, 0.6) * z;
    double y = uniform(-0.4, 0.4) * z;
    if (family == "clustered" && i % 10 != 0) {
      x = 1 + uniform(0, 0.05);
      y = 0.5 + uniform(0, 0.05);
    }
    if (family == "copies" && i >= 20) {
      for (std::size_t c = 0; c < 3; ++c) points.push_back(points[3 * (i % 20) + c]);
    } else {
      points.insert(points.end(), {x, y, z});
    }
  }
  return points;
}

BlockStore blocks_of(const std::vector<double>& points, DepthCue cue, bool has_covariances) {
  PinholeCamera camera;
  camera.fx = camera.fy = 450;
  camera.bf = 50;
  const double T_cw[12] = {0.8, 0, 0.6, 0.1, 0, 1, 0, -0.2, -0.6, 0, 0.8, 0.3};
  const double covariance[9] = {2e-3, 1e-4, 0, 1e-4, 3e-3, 0, 0, 0, 4e-3};
  std::vector<FeatureMatch> matches;
  for (std::size_t i = 0; i < points.size(); i += 3) {
    matches.emplace_back(&points[i], 1 + 0.01 * static_cast<double>(i % 100));
    if (cue == DepthCue::stereo) matches.back().u_right = 1;
    if (cue == DepthCue::depth) matches.back().depth = 1;
    if (has_covariances && i % 2 == 0) matches.back().covariance = covariance;
  }
  BlockStore blocks;
  const Camera pinhole = camera;
  append_blocks(&pinhole, 1, RigidTransform::row_major(T_cw), matches.data(), matches.size(), BlockOptions(), blocks);
  return blocks;
}

constexpr const char* ways[] = {"plain", "required", "groups", "certificate", "efficiency"};

void select_every_way(const std::string& from, const BlockStore& blocks) {
  std::vector<unsigned char> required;
  std::vector<std::uint32_t> groups;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    required.push_back(i % 50 == 0 && blocks.is_valid(i) ? 1 : 0);
    groups.push_back(static_cast<std::uint32_t>(i % 30));
  }
  Selector selector(blocks.size());
  for (const Strategy strategy : strategies) {
    for (const std::string way : ways) {
      Options options;
      options.strategy = strategy;
      options.budget = blocks.size() < 300 ? blocks.size() * 3 / 4 : 60;
      options.stochastic.seed = blocks.size();
      if (way == "required") options.required = required.data();
      if (way == "groups") {
        options.groups.ids = groups.data();
        options.groups.count = 30;
        options.groups.maximum = 3;
      }
      options.certificate = way == "certificate";
      options.target_efficiency = way == "efficiency" ? 0.15 : 0;
      const Selection selection = selector.select(blocks, options);
      sim::Hash indices, gains;
      for (const std::uint32_t index : selection) indices.add(std::uint64_t{index});
      for (std::size_t i = 0; i < selection.size; ++i) add_bits(gains, selection.gains[i]);
      add_bits(gains, selection.has_answer() ? selection.log_det : 0);
      add_bits(gains, options.certificate ? selection.upper_bound : 0);
      std::printf("%s %s %s %s %s %zu %016" PRIx64 " %016" PRIx64 "\n", active_isa(), from.c_str(), to_string(strategy),
                  way.c_str(), to_string(selection.status), selection.size, indices.value(), gains.value());
    }
  }
}

void select_on_this_isa() {
  for (const std::size_t n : {std::size_t{120}, std::size_t{1500}}) {
    for (const std::string family : families) {
      const std::vector<double> points = points_of(family, n);
      for (const bool has_covariances : {false, true}) {
        const std::string from = family + ' ' + std::to_string(n) + (has_covariances ? " covariances" : " plain");
        select_every_way(from, blocks_of(points, DepthCue::none, has_covariances));
        select_every_way(from + "_stereo", blocks_of(points, DepthCue::stereo, has_covariances));
        select_every_way(from + "_depth", blocks_of(points, DepthCue::depth, has_covariances));
      }
    }
  }
}

}  // namespace
}  // namespace maxlogdet

int main() {
  for (int i = 0; maxlogdet::built_in_isa(i) != nullptr; ++i) {
    const char* const isa = maxlogdet::built_in_isa(i);
    if (!maxlogdet::isa_is_supported(isa)) continue;
    setenv("MAXLOGDET_ISA", isa, 1);
    maxlogdet::select_on_this_isa();
  }
  return 0;
}
