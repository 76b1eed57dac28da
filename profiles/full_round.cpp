// SPDX-License-Identifier: MIT
#include "profiles/full_round.hpp"

#include "bench/world/scene.hpp"
#include "kernel/blocks/stored_rows.hpp"
#include "kernel/information/information_factor.hpp"
#include "simd/kernel.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <algorithm>
#include <iterator>
#include <stdexcept>
#include <vector>

namespace maxlogdet::profiles {

struct FullRound::State {
  const simd::Kernel* kernel = nullptr;
  int rows = 0;
  BlockStore blocks = BlockStore(candidates);
  InformationFactor factor;
  float w[simd::dimension * simd::padded_dimension];
  std::vector<float> remaining = std::vector<float>(candidates, 1.0F);
  std::vector<float> relative_gains = std::vector<float>(candidates);
  std::vector<float> highest = std::vector<float>(candidates / simd::tile_size + simd::tile_size);
  std::vector<unsigned char> in_each = std::vector<unsigned char>(candidates / simd::tile_size, simd::tile_size);
  std::vector<Tile> tiles = std::vector<Tile>(candidates / simd::tile_size);
};

FullRound::FullRound(const std::string& isa, int rows) : state_(std::make_unique<State>()) {
  state_->rows = rows;
  for (const simd::Kernel* const* kernel = simd::built_in(); *kernel != nullptr; ++kernel) {
    if (isa == (*kernel)->isa && simd::is_supported(**kernel)) state_->kernel = *kernel;
  }
  if (state_->kernel == nullptr) throw std::invalid_argument("expected an instruction set of this machine, not " + isa);

  BlockOptions options;
  options.weighting = Weighting::map_bias;
  if (rows == 3) options.depth_cue = DepthCue::stereo;
  build_blocks(make_scene(sim::Scene::euroc_like, candidates, 1), options, state_->blocks);
  for (std::size_t i = 0; i < state_->tiles.size(); ++i) state_->tiles[i] = static_cast<Tile>(i);
  state_->factor.reset(nullptr);
  for (std::size_t selected = 0; selected < 50; ++selected) {
    double h[max_block_rows][state_dimension];
    read_rows(all_of(state_->blocks, *state_->kernel), static_cast<Candidate>(selected), h);
    state_->factor.add_block(*state_->kernel, h, rows);
  }
  for (std::size_t i = 0; i < std::size(state_->w); ++i) state_->w[i] = static_cast<float>(state_->factor.inverse()[i]);
}

FullRound::FullRound(FullRound&&) noexcept = default;
FullRound& FullRound::operator=(FullRound&&) noexcept = default;
FullRound::~FullRound() = default;

void FullRound::operator()() noexcept {
  State& state = *state_;
  const simd::Planes planes = all_of(state.blocks, *state.kernel).planes;
  const simd::Tiles tiles{planes.data,          simd::tile_size,        planes.stride,
                          state.in_each.size(), state.remaining.data(), state.in_each.data()};
  const simd::RoundArrays arrays{nullptr, state.highest.data(), state.relative_gains.data(), nullptr};
  state.kernel->rounds[state.rows - 1].evaluate(tiles, state.w, state.tiles.data(), state.tiles.size(), arrays);
}

}  // namespace maxlogdet::profiles
