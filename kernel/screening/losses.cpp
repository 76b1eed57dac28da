// SPDX-License-Identifier: MIT
#include "kernel/screening/losses.hpp"

#include "kernel/base/limits.hpp"
#include "kernel/blocks/candidates.hpp"
#include "simd/rounding.hpp"

#include <algorithm>

namespace maxlogdet {
namespace {

using simd::tile_size;

// A constant of the error analysis in docs/numerics.md, rounded up.
constexpr double rounding_errors = 256;
// Relative room for rounding a product to float32.
constexpr double float_room = 2e-7;

}  // namespace

LossesMemory::LossesMemory(std::size_t capacity)
    : losses(tile_size * tiles_of(capacity)), tile_loss(tiles_of(capacity)) {}

Losses::Losses(const Evaluator& evaluator, const double* column_max, ScreeningMemory& shared,
               LossesMemory& memory) noexcept
    : evaluator_(evaluator),
      kernel_(evaluator.kernel()),
      shared_(shared),
      memory_(memory),
      tiles_(evaluator, simd::form_of_rows(evaluator.rows()), shared.tiles),
      row_norm_(max_row_norm(column_max)) {}

void Losses::start(const unsigned char* is_left, std::size_t n, const InformationFactor& factor) noexcept {
  tiles_.use_store(is_left, n);
  evaluate_all(factor);
  float* const values = shared_.gains.data();
  float top = 0;
  for (std::size_t i = 0; i < tiles_.lanes(); ++i) {
    const auto lane = static_cast<Lane>(i);
    values[i] = tiles_.remains(lane) ? static_cast<float>(memory_.losses[lane]) : 0.0F;
    top = std::max(top, values[i]);
  }
  tiles_.order_by(values, top, [](Tile, std::uint32_t) {});
  evaluate_all(factor);
}

void Losses::evaluate(const InformationFactor& factor, std::size_t first, std::size_t last) noexcept {
  evaluator_.losses(tiles_.tiles(), factor.inverse(), shared_.list + first, last - first, memory_.losses.data(),
                    memory_.tile_loss.data());
  evaluations_ += tile_size * (last - first);
}

void Losses::evaluate_all(const InformationFactor& factor) noexcept {
  listed_ = tiles_.tiles().count;
  for (std::size_t tile = 0; tile < listed_; ++tile) shared_.list[tile] = static_cast<Tile>(tile);
  evaluate(factor, 0, listed_);
  keep_bounds();
}

void Losses::evaluate_between(const InformationFactor& factor, float min_bound, float max_bound) noexcept {
  const std::size_t first = listed_;
  listed_ += kernel_.arrays.list_tiles(shared_.bounds.data(), tiles_.tiles().count, min_bound, max_bound,
                                       shared_.list + first);
  if (listed_ > first) evaluate(factor, first, listed_);
}

// Evaluates the tile of the minimum stale bound, then every tile that may hold a loss as small as its minimum.
void Losses::evaluate_lazily(const InformationFactor& factor) noexcept {
  const float highest = kernel_.arrays.largest(shared_.bounds.data(), tiles_.tiles().count);
  evaluate_between(factor, highest, float_infinity);
  const double threshold = (min_listed() + 2 * rounding_error_) / (1 - drift_of_error * factor_error_);
  const auto lowest = -static_cast<float>(std::min(threshold, 1.0) * (1 + float_room));
  evaluate_between(factor, lowest, highest);
  keep_bounds();  // not earlier: a tile whose new bound is in the second range would be evaluated twice
}

void Losses::note_errors(const InformationFactor& factor) noexcept {
  factor_error_ = std::max(factor_error_, factor.relative_error());
  const double omega = factor.inverse_norm() * row_norm_;
  const double longest = std::min(1.0, omega);  // upper bound of the norm of a row of Y
  rounding_error_ =
      std::max(rounding_error_, rounding_errors * simd::double_unit_roundoff * longest * (longest + omega));
}

// Bounds are lower bounds of the minimum loss, negated, so that the search for the maximum finds the minimum loss.
void Losses::keep_bound(Tile tile) const noexcept {
  shared_.bounds[tile] = -static_cast<float>(memory_.tile_loss[tile] * (1 - float_room));
}

void Losses::keep_bounds() const noexcept {
  for (std::size_t j = 0; j < listed_; ++j) keep_bound(shared_.list[j]);
}

double Losses::min_listed() const noexcept {
  double smallest = simd::no_loss;
  for (std::size_t j = 0; j < listed_; ++j) smallest = std::min(smallest, memory_.tile_loss[shared_.list[j]]);
  return smallest;
}

Lane Losses::find_min(const InformationFactor& factor) noexcept {
  listed_ = 0;
  note_errors(factor);
  if (factor_error_ < hopeless_error) {
    evaluate_lazily(factor);
  } else {
    evaluate_all(factor);
  }
  const double smallest = min_listed();
  Lane found = no_lane;
  for (std::size_t j = 0; j < listed_; ++j) {
    const Tile tile = shared_.list[j];
    if (memory_.tile_loss[tile] > smallest) continue;
    for (std::size_t i = simd::first_lane(tile); i < simd::first_lane(tile) + tile_size; ++i) {
      const auto lane = static_cast<Lane>(i);
      if (memory_.losses[lane] > smallest) continue;
      if (found == no_lane || candidate(lane) > candidate(found)) found = lane;
    }
  }
  return found;
}

void Losses::remove(Lane lane) noexcept {
  const Tile tile = simd::tile_of(lane);
  tiles_.remove(lane);
  memory_.losses[lane] = simd::no_loss;
  const double* const first = memory_.losses.data() + simd::first_lane(tile);
  memory_.tile_loss[tile] = *std::min_element(first, first + tile_size);
  keep_bound(tile);
}

}  // namespace maxlogdet
