// SPDX-License-Identifier: MIT
#include "profiles/full_round.hpp"

#include "kernel/information_factor.hpp"
#include "sim/scene.hpp"
#include "simd/kernel.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <stdexcept>
#include <vector>

namespace maxlogdet::profiles {

struct FullRound::State {
  const simd::Kernel* kernel = nullptr;
  int rows = 0;
  BlockStore blocks = BlockStore(candidates);
  InformationFactor factor;
  std::vector<double> growths = std::vector<double>(candidates);
};

FullRound::FullRound(const std::string& isa, int rows) : state_(std::make_unique<State>()) {
  state_->rows = rows;
  for (const simd::Kernel* const* kernel = simd::built_in(); *kernel != nullptr; ++kernel) {
    if (isa == (*kernel)->isa && simd::is_supported(**kernel)) state_->kernel = *kernel;
  }
  if (state_->kernel == nullptr) throw std::invalid_argument(isa + " is not supported here");

  BlockOptions options;
  if (rows == 3) options.third = ThirdMeasurement::stereo;
  build_blocks(make_scene(sim::Scene::euroc_like, candidates, 1), options, state_->blocks);
  state_->factor.reset(nullptr);
  for (std::size_t selected = 0; selected < 50; ++selected) {
    for (int row = 0; row < rows; ++row) {
      double h[state_dimension];
      for (int column = 0; column < state_dimension; ++column) h[column] = state_->blocks.plane(row, column)[selected];
      state_->factor.add_row(h);
    }
  }
}

FullRound::FullRound(FullRound&&) noexcept = default;
FullRound& FullRound::operator=(FullRound&&) noexcept = default;
FullRound::~FullRound() = default;

void FullRound::operator()() noexcept {
  State& state = *state_;
  state.kernel->evaluate_range[state.rows - 1]({state.blocks.plane(0, 0), state.blocks.stride()},
                                               state.factor.inverse(), 0, candidates, state.growths.data());
}

}  // namespace maxlogdet::profiles
