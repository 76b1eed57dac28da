// SPDX-License-Identifier: MIT
#include "profiles/full_round.hpp"

#include "kernel/information_factor.hpp"
#include "simd/kernel.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <random>
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

  // Any blocks of ordinary size will do: no operation takes longer for one value than for another.
  std::mt19937 random(1);
  const auto entry = [&] { return static_cast<double>(random() % 2001) - 1000; };
  for (std::size_t i = 0; i < candidates; ++i) {
    double block[3 * state_dimension];
    for (double& value : block) value = entry();
    state_->blocks.push_back(block, rows);
  }
  state_->factor.reset(nullptr);
  for (int selected = 0; selected < 50; ++selected) {
    double row[state_dimension];
    for (double& value : row) value = entry();
    state_->factor.add_row(row);
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
