// SPDX-License-Identifier: MIT
#include "kernel/screening/losses.hpp"

#include "kernel/screening/lane_order.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace maxlogdet {
namespace {

using simd::tile_size;

constexpr double unit_roundoff = std::numeric_limits<double>::epsilon() / 2;
// A generous constant of the error analysis in docs/numerics.md.
constexpr double rounding_errors = 256;
constexpr float infinity = std::numeric_limits<float>::infinity();

}  // namespace

LossesMemory::LossesMemory(std::size_t capacity) : losses(tile_size * tiles_of(capacity)), least(tiles_of(capacity)) {}

Losses::Losses(const threading::Evaluator& evaluator, const double* column_max, ScreeningMemory& tiles,
               LossesMemory& memory) noexcept
    : evaluator_(evaluator), kernel_(evaluator.kernel()), tiles_memory_(tiles), memory_(memory) {
  double squares = 0;
  for (int column = 0; column < simd::dimension; ++column) squares += column_max[column] * column_max[column];
  row_norm_ = std::sqrt(squares);
}

void Losses::start(const unsigned char* left, std::size_t n, const InformationFactor& factor) noexcept {
  ScreeningMemory& memory = tiles_memory_;
  const std::size_t lanes = tile_size * tiles_of(n);
  for (std::size_t i = 0; i < lanes; ++i) memory.remaining[i] = i < n && left[i] != 0 ? 1.0F : 0.0F;
  tile_count_ = tiles_of(n);
  tiles_ = {evaluator_.planes().data, tile_size, evaluator_.planes().stride, memory.remaining};
  evaluate_all(factor);

  float top = 0;
  for (std::size_t i = 0; i < lanes; ++i) {
    memory.relative_gains[i] = memory.remaining[i] > 0 ? static_cast<float>(memory_.losses[i]) : 0.0F;
    top = std::max(top, memory.relative_gains[i]);
  }
  std::uint32_t* const order = memory.candidate;
  const std::size_t count = order_lanes(memory.relative_gains, memory.remaining, lanes, top, evaluator_.team(),
                                        memory.order_counts, memory.bucket, order);
  const simd::Form form = simd::form_of_rows(evaluator_.rows());
  evaluator_.make_records(form, lanes, memory.records);
  tile_count_ = tiles_of(count);
  tiles_ = pack_listed(evaluator_, form, count, memory);
  evaluate_all(factor);
}

void Losses::evaluate(const InformationFactor& factor, std::size_t first, std::size_t last) noexcept {
  const std::uint32_t* const list = tiles_memory_.list;
  evaluator_.losses(tiles_, factor.inverse(), list + first, last - first, memory_.losses, memory_.least);
  evaluations_ += tile_size * (last - first);
}

void Losses::evaluate_all(const InformationFactor& factor) noexcept {
  for (std::size_t tile = 0; tile < tile_count_; ++tile) tiles_memory_.list[tile] = static_cast<std::uint32_t>(tile);
  listed_ = tile_count_;
  evaluate(factor, 0, listed_);
  keep_bounds();
}

void Losses::evaluate_between(const InformationFactor& factor, float least, float most) noexcept {
  const std::size_t first = listed_;
  listed_ += kernel_.list_between(tiles_memory_.bounds, tile_count_, 0, 1, least, most, tiles_memory_.list + first);
  if (listed_ > first) evaluate(factor, first, listed_);
}

void Losses::note_errors(const InformationFactor& factor) noexcept {
  factor_error_ = std::max(factor_error_, factor.relative_error());
  const double omega = factor.inverse_norm() * row_norm_;
  const double longest = std::min(1.0, omega);  // row of Y
  rounding_error_ = std::max(rounding_error_, rounding_errors * unit_roundoff * longest * (longest + omega));
}

// The negative of a float32 that is not above the least loss of the tile, so that what finds the largest finds it.
void Losses::keep_bound(std::size_t tile) const noexcept {
  tiles_memory_.bounds[tile] = -static_cast<float>(memory_.least[tile] * (1 - 2e-7));
}

void Losses::keep_bounds() const noexcept {
  for (std::size_t j = 0; j < listed_; ++j) keep_bound(tiles_memory_.list[j]);
}

double Losses::min_listed() const noexcept {
  double least = simd::no_loss;
  for (std::size_t j = 0; j < listed_; ++j) least = std::min(least, memory_.least[tiles_memory_.list[j]]);
  return least;
}

std::size_t Losses::least(const InformationFactor& factor, bool lazily) noexcept {
  listed_ = 0;
  note_errors(factor);
  if (lazily && factor_error_ < hopeless_error) {
    // The tile that held the least so far; then whatever might hold less than what it holds now.
    const float highest = kernel_.largest(tiles_memory_.bounds, tile_count_);
    evaluate_between(factor, highest, infinity);
    const double threshold = (min_listed() + 2 * rounding_error_) / (1 - 2.5 * factor_error_);
    const auto lowest = -static_cast<float>(std::min(threshold, 1.0) * (1 + 2e-7));
    evaluate_between(factor, lowest, std::nextafter(highest, -infinity));
    keep_bounds();  // not before: a tile whose bound falls into the second range would be evaluated twice
  } else {
    evaluate_all(factor);
  }

  const double least = min_listed();
  std::size_t found = 0;
  bool is_found = false;
  for (std::size_t j = 0; j < listed_; ++j) {
    const std::size_t tile = tiles_memory_.list[j];
    if (memory_.least[tile] > least) continue;
    for (std::size_t lane = tile * tile_size; lane < (tile + 1) * tile_size; ++lane) {
      if (memory_.losses[lane] > least || (is_found && candidate(lane) < candidate(found))) continue;
      found = lane;
      is_found = true;
    }
  }
  return found;
}

void Losses::remove(std::size_t lane) noexcept {
  const std::size_t tile = lane / tile_size;
  tiles_memory_.remaining[lane] = 0;
  memory_.losses[lane] = simd::no_loss;
  const double* const first = memory_.losses + tile * tile_size;
  memory_.least[tile] = *std::min_element(first, first + tile_size);
  keep_bound(tile);
}

std::size_t Losses::list_all_but(std::size_t kept, std::uint32_t* candidates) noexcept {
  std::uint32_t* const lanes = tiles_memory_.bucket;
  std::size_t count = 0;
  for (std::uint32_t lane = 0; lane < tile_size * tile_count_; ++lane) {
    if (tiles_memory_.remaining[lane] > 0) lanes[count++] = lane;
  }
  const std::size_t dropped = count - std::min(kept, count);
  std::nth_element(lanes, lanes + dropped, lanes + count, [this](std::uint32_t a, std::uint32_t b) {
    const double* const losses = memory_.losses;
    return losses[a] < losses[b] || (losses[a] == losses[b] && candidate(a) > candidate(b));
  });
  for (std::size_t j = 0; j < dropped; ++j) candidates[j] = candidate(lanes[j]);
  return dropped;
}

}  // namespace maxlogdet
