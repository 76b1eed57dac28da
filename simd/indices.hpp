// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>

// The numberings within the library. A caller's index, of a match in its store, is a plain std::uint32_t; `Candidates`
// (kernel/blocks/candidates.hpp) translates it, and TileLayout (kernel/screening/tiles.hpp) translates between
// candidates and lanes. Enumerations, so that mixing them does not compile.

namespace maxlogdet {

enum class Candidate : std::uint32_t {};  ///< the position among the candidates of a search: in planes and records
enum class Lane : std::uint32_t {};       ///< the position in the order of evaluation
enum class Tile : std::uint32_t {};       ///< 16 consecutive lanes, which are evaluated together

constexpr Lane no_lane = static_cast<Lane>(0xFFFFFFFFU);

namespace simd {

constexpr std::size_t tile_size = 16;  ///< one AVX-512 register of float32

/// To index plain arrays.
template <class Index>
constexpr std::size_t number(Index index) {
  return static_cast<std::size_t>(index);
}
constexpr Tile tile_of(Lane lane) { return static_cast<Tile>(number(lane) / tile_size); }

}  // namespace simd

constexpr std::size_t tiles_of(std::size_t lanes) { return (lanes + simd::tile_size - 1) / simd::tile_size; }

/// Elements to allocate for `count`: whole registers, and one more that vector stores may write to.
constexpr std::size_t padded(std::size_t count) { return simd::tile_size * (tiles_of(count) + 1); }

}  // namespace maxlogdet
