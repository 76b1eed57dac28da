// SPDX-License-Identifier: MIT
// The end of a round of Screening: listing the survivors, between which float64 decides, and removing candidates.
#include "kernel/screening/screening.hpp"

#include "kernel/base/limits.hpp"
#include "kernel/blocks/stored_rows.hpp"

#include <maxlogdet/block_store.hpp>

#include <algorithm>

namespace maxlogdet {

using simd::tile_size;

namespace {

// More survivors than this are evaluated again with care before float64 decides.
constexpr std::size_t many_survivors = 24;

}  // namespace

std::size_t Screening::survivors(std::uint32_t* lanes) noexcept {
  const std::size_t found = list_distinct_survivors(lanes);
  if (errors_.with_care() || found <= many_survivors) return found;
  look_with_care();
  return list_distinct_survivors(lanes);
}

std::size_t Screening::survivors(std::size_t k, std::uint32_t* lanes) noexcept {
  return k == 1 ? survivors(lanes) : list_survivors(nullptr, lanes);
}

// Candidates whose relative gain is below this threshold are not the best.
float Screening::survivor_threshold() const noexcept { return errors_.line().survivor_threshold(assured_); }

std::size_t Screening::list_survivors(const float* unlike, std::uint32_t* lanes) const noexcept {
  const float threshold = survivor_threshold();
  const std::uint32_t* list = memory_.list;
  std::size_t count = listed_;
  if (lists_all_) {  // compares 16 tiles at once
    std::uint32_t* const reaching = memory_.list + tiles_.tile_count();
    count = kernel_.list_between(memory_.highest, tiles_.tile_count(), 0, 1, threshold, float_infinity, reaching);
    list = reaching;
  }
  return kernel_.list_survivors[tiles_.form()](tiles_.tiles(), memory_.relative_gains, memory_.highest, threshold, list,
                                               count, unlike, lanes);
}

// Of identical candidates only the one of lowest index can be selected: drops the copies of the survivor of lowest
// index.
std::size_t Screening::list_distinct_survivors(std::uint32_t* lanes) const noexcept {
  std::size_t found = survivors_found_;
  if (found > 0) {
    std::copy_n(static_cast<const std::uint32_t*>(memory_.survivors), found, lanes);
  } else {
    found = list_survivors(nullptr, lanes);
  }
  if (found <= many_survivors) return found;
  const std::uint32_t first = lane_of_first(lanes, found);
  std::size_t others = 0;
  if (tiles_.form() == simd::factored) {
    others = drop_copies(lanes, found, first);
  } else {
    float of_first[simd::dimension * max_block_rows];
    const std::size_t stride = tiles_.tiles().entry_stride;
    for (std::size_t e = 0; e < simd::entries_of(tiles_.form()); ++e) of_first[e] = tiles_.entries(first)[e * stride];
    others = list_survivors(of_first, lanes);
  }
  lanes[others] = first;
  return others + 1;
}

// The lane of the candidate of lowest index.
std::uint32_t Screening::lane_of_first(const std::uint32_t* lanes, std::size_t count) const noexcept {
  std::uint32_t first = lanes[0];
  std::uint32_t lowest = candidate(first);
  for (std::size_t j = 1; j < count; ++j) {
    const std::uint32_t other = candidate(lanes[j]);
    first = other < lowest ? lanes[j] : first;
    lowest = std::min(lowest, other);
  }
  return first;
}

// Drops the candidates whose rows are identical to those of `first`, entry by entry.
std::size_t Screening::drop_copies(std::uint32_t* lanes, std::size_t count, std::uint32_t first) const noexcept {
  const auto is_copy = [&](std::uint32_t lane) {
    return are_identical(evaluator_.planes(), rows(), candidate(lane), candidate(first));
  };
  return static_cast<std::size_t>(std::remove_if(lanes, lanes + count, is_copy) - lanes);
}

// Called where one bound for all candidates excludes too few of them.
void Screening::look_with_care() noexcept {
  // Keeps the bounds of tiles that are not evaluated again, too.
  if (tiles_.is_ordered() && !are_withdrawn_ && !are_bounds_kept_) keep_bounds();
  are_bounds_kept_ = false;
  survivors_found_ = 0;
  std::size_t kept = 0;
  for (std::size_t j = 0; j < listed_; ++j) {
    const std::uint32_t tile = memory_.list[j];
    const bool may_hold_best = errors_.line().at_most(static_cast<double>(memory_.highest[tile])) >= assured_;
    if (may_hold_best || are_withdrawn_) memory_.list[kept++] = tile;
  }
  lists_all_ = lists_all_ && kept == listed_;
  listed_ = kept;
  errors_.take_care();
  evaluate_listed();
}

std::size_t Screening::next_certain() noexcept {
  if (errors_.with_care()) return lanes();
  float best = -1;
  float second = -1;  // second-highest maximum of a tile
  std::uint32_t tile = 0;
  for (std::size_t j = 0; j < listed_; ++j) {
    const float highest = memory_.highest[memory_.list[j]];
    tile = highest > best ? memory_.list[j] : tile;
    second = std::max(second, std::min(best, highest));
    best = std::max(best, highest);
  }
  if (best < 0) return lanes();
  best_ = -1;
  assured_ = -1;
  learn_from(best);
  const float threshold = survivor_threshold();
  if (second >= threshold || stale_threshold() < lowest_listed_) return lanes();
  std::uint32_t found[2 * tile_size];
  const std::size_t count = kernel_.list_survivors[tiles_.form()](tiles_.tiles(), memory_.relative_gains,
                                                                  memory_.highest, threshold, &tile, 1, nullptr, found);
  return count == 1 ? found[0] : lanes();
}

void Screening::withdraw(std::size_t lane) noexcept {
  const std::size_t tile = lane / tile_size;
  tiles_.remove(lane);
  memory_.relative_gains[lane] = -1;
  memory_.lower[lane] = -1;
  memory_.highest[tile] = kernel_.largest(memory_.relative_gains + tile_size * tile, tile_size);
}

void Screening::remove(std::size_t lane) noexcept {
  tiles_.remove(lane);
  memory_.relative_gains[lane] = -1;
  // A far outlier of a frame is selected early; it should not loosen error bounds any longer.
  if (!tiles_.is_ordered() || errors_.is_small()) return;
  tiles_.clear_entries(lane);
  tiles_.find_column_max(errors_.column_max());
}

}  // namespace maxlogdet
