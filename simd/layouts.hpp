// SPDX-License-Identifier: MIT
#pragma once

#include <cassert>
#include <cstddef>
#include <cstdint>

// The numberings within the library; TileLayout (kernel/screening/tiles.hpp) translates between indices and lanes.
// Enumerations, so that mixing them does not compile.

namespace maxlogdet {

enum class Index : std::uint32_t {};  ///< of a match, and of its candidate: in the store, in planes and records
enum class Lane : std::uint32_t {};   ///< the position in the order of evaluation
enum class Tile : std::uint32_t {};   ///< 16 consecutive lanes, which are evaluated together

constexpr Lane no_lane = static_cast<Lane>(0xFFFFFFFFU);

namespace simd {

constexpr std::size_t tile_size = 16;  ///< one AVX-512 register of float32

/// To index plain arrays.
template <class Number>
constexpr std::size_t number(Number index) {
  return static_cast<std::size_t>(index);
}
constexpr Tile tile_of(Lane lane) { return static_cast<Tile>(number(lane) / tile_size); }

}  // namespace simd

constexpr std::size_t tiles_of(std::size_t lanes) { return (lanes + simd::tile_size - 1) / simd::tile_size; }

/// Elements to allocate for `count`: whole registers, and one more that vector stores may write to.
constexpr std::size_t padded(std::size_t count) { return simd::tile_size * (tiles_of(count) + 1); }

}  // namespace maxlogdet

// How kernels find the numbers of candidates.

namespace maxlogdet::simd {

constexpr int dimension = 6;         ///< of the state: translation, rotation
constexpr int padded_dimension = 8;  ///< of a row of the inverse factor: 64 bytes

/// Candidates as a structure of arrays: entry (row, column) of candidate i is at
/// data[(dimension * row + column) * stride + i].
struct Planes {
  const float* data;
  std::size_t stride;
};

/// What screening reads of a candidate: the entries of its rows, one after the other; or, if all blocks are
/// A [ I | -[X]x ] with an upper triangular A, the six entries of A, by rows, and the point X: half as much to read,
/// and three quarters of the arithmetic.
enum Form { one_row, two_rows, three_rows, factored };
constexpr std::size_t forms = 4;
constexpr int rows_of(Form form) { return form == factored ? 3 : static_cast<int>(form) + 1; }
/// Of blocks that are not factored, with 1, 2 or 3 rows.
constexpr Form form_of_rows(int rows) {
  assert(rows >= 1 && rows <= 3);
  return static_cast<Form>(rows - 1);
}
constexpr std::size_t entries_of(Form form) {
  return form == factored ? 9 : static_cast<std::size_t>(dimension * rows_of(form));
}
/// The planes of a store: 18 of entries, and 3 of the point.
constexpr std::size_t point_plane = std::size_t{3} * dimension;
constexpr std::size_t planes_of_store = point_plane + 3;
/// The plane of an entry of a form.
constexpr std::size_t factored_planes[] = {0, 1, 2, 7, 8, 14, 18, 19, 20};
constexpr std::size_t plane_of(Form form, std::size_t entry) {
  return form == factored ? factored_planes[entry] : entry;
}

/// Floats from one record to the next: a candidate's entries together, padded to a multiple of four.
constexpr std::size_t record_size(Form form) { return (entries_of(form) + 3) / 4 * 4; }

/// Candidates by tiles: entry e of lane l of tile t is at data[(entries_of(form) * t + e) * tile_size + l]. All arrays
/// hold whole tiles.
struct Tiles {
  const float* data;
  std::size_t count;
  const float* remaining;        ///< per lane: 1 where there is a candidate that remains, else 0
  const unsigned char* in_each;  ///< per tile: how many remain
};

}  // namespace maxlogdet::simd
