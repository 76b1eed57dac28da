// SPDX-License-Identifier: MIT
#include "bench/world/problem.hpp"

#include "bench/world/data_folder.hpp"
#include "bench/world/frame_reader.hpp"
#include "bench/world/scene.hpp"

#include <cmath>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <tuple>

namespace maxlogdet::bench {
namespace {

constexpr const char* equal_gains = "equal_gains";
constexpr const char* nearly_equal_gains = "nearly_equal_gains";

using Key = std::tuple<std::string, std::size_t, Blocks>;

BlockStore blocks_of(const sim::Frame& frame, Blocks kind) {
  BlockOptions options;
  const bool is_measurement = kind == Blocks::two_rows_measurement || kind == Blocks::three_rows_measurement;
  options.weighting = is_measurement ? Weighting::measurement : Weighting::map_bias;
  if (kind == Blocks::three_rows || kind == Blocks::three_rows_measurement) options.depth_cue = DepthCue::stereo;
  BlockStore blocks(frame.matches.size());
  build_blocks(frame, options, blocks);
  return blocks;
}

// n copies of the first candidate: in each round all gains are equal and all bounds stale, and laziness saves nothing.
// `steps`: changes one entry of each copy by one float32 ulp, so that only float64 can tell the copies apart.
BlockStore copies_of_first(const BlockStore& blocks, std::size_t n, bool steps) {
  double block[max_block_entries];
  blocks.block(0, block);
  BlockStore copies(n);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t entry = i % static_cast<std::size_t>(blocks.rows() * state_dimension);
    const double exact = block[entry];
    if (steps) block[entry] = static_cast<double>(std::nextafter(static_cast<float>(exact), i % 2 == 0 ? 1e9F : -1e9F));
    copies.push_back(block, blocks.rows());
    block[entry] = exact;
  }
  return copies;
}

std::vector<BlockStore> make_stores(const std::string& family, std::size_t n, Blocks blocks) {
  if (family != real_frames) return {synthetic_store(family, n, blocks, scene_seed)};
  std::vector<BlockStore> stores;
  for (const sim::Frame& frame : sim::read_frames(real_frames_folder())) stores.push_back(blocks_of(frame, blocks));
  return stores;
}

}  // namespace

const char* to_string(Blocks blocks) noexcept {
  switch (blocks) {
    case Blocks::two_rows: return "2_rows";
    case Blocks::three_rows: return "3_rows";
    case Blocks::two_rows_measurement: return "2_rows_measurement";
    case Blocks::three_rows_measurement: return "3_rows_measurement";
  }
  return "unknown";
}

std::vector<std::string> scene_families() {
  std::vector<std::string> names;
  for (const sim::Scene scene : sim::scenes) names.push_back(to_string(scene));
  return names;
}

std::vector<std::string> synthetic_families() {
  std::vector<std::string> names = scene_families();
  names.emplace_back(equal_gains);
  names.emplace_back(nearly_equal_gains);
  return names;
}

std::string real_frames_folder() {
  const std::string folder = sim::data_folder() + "/orb_slam2_frames";
  std::error_code error;
  return std::filesystem::is_directory(folder, error) ? folder : "";
}

BlockStore synthetic_store(const std::string& family, std::size_t n, Blocks blocks, std::uint64_t seed) {
  if (family == equal_gains || family == nearly_equal_gains) {
    const sim::Frame frame = make_scene(sim::Scene::euroc_like, 1, seed);
    return copies_of_first(blocks_of(frame, blocks), n, family == nearly_equal_gains);
  }
  for (const sim::Scene scene : sim::scenes) {
    if (to_string(scene) == family) return blocks_of(make_scene(scene, n, seed), blocks);
  }
  throw std::invalid_argument("expected the name of a family of synthetic frames, not " + family);
}

const std::vector<BlockStore>& stores_of(const std::string& family, std::size_t n, Blocks blocks) {
  static std::map<Key, std::vector<BlockStore>> kept;
  const Key key(family, n, blocks);
  auto found = kept.find(key);
  if (found == kept.end()) found = kept.emplace(key, make_stores(family, n, blocks)).first;
  return found->second;
}

}  // namespace maxlogdet::bench
