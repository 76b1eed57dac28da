// SPDX-License-Identifier: MIT
#pragma once

#include "simd/blocks.hpp"
#include "simd/rounding.hpp"
#include "simd/upper_line.hpp"

#include <cstddef>
#include <cstdint>

// The table of functions that an instruction set offers. Raw pointers in, raw pointers out: besides this header, a
// per-ISA translation unit shares with the rest only what is inlined or has internal linkage (a hash, rounding, camera
// models), so that the linker cannot merge code of wider instructions into baseline code.

namespace maxlogdet {
namespace simd {

constexpr int dimension = 6;           ///< of the state: translation, rotation
constexpr int padded_dimension = 8;    ///< of a row of the inverse factor: 64 bytes
constexpr std::size_t tile_size = 16;  ///< candidates that are screened together: one AVX-512 register of float32

/// 2^-102. Rounding to float32 is relative to the magnitude only down to 2^-126, and the caller may flush denormal
/// numbers to zero: error bounds take the entries of W as at least this large.
constexpr double smallest_entry = 1.9721522630525295e-31;

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
constexpr Form form_of_rows(int rows) { return static_cast<Form>(rows - 1); }
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

/// Candidates by tiles of 16. Entry e (of a form) of lane l of tile t is at data[t * tile_stride + e * entry_stride +
/// l]: the planes of a store as they are (not if it is factored), or a copy in which each tile is contiguous. All
/// arrays hold whole tiles.
struct Tiles {
  const float* data;
  std::size_t tile_stride;
  std::size_t entry_stride;
  const float* remaining;  ///< per lane: 1 where there is a candidate that remains, else 0
};

/// Decides: the relative gain of a candidate H (r x 6) at information M = L L^T,
///     det(M + H^T H) / det(M) - 1 = det(I_r + Y Y^T) - 1,   Y = H L^-T,
/// not below 0, in float64, in one fixed order of operations: the same bits on every instruction set. Without the 1,
/// gains far below 2^-53 keep their digits. `inverse_factor` is W = L^-1, 6 x 8 row-major, its lower triangle is read.
/// relative_gains[j] is that of candidate indices[j], j in [0, count).
using Decide = void (*)(const Planes& planes, const double* inverse_factor, const std::uint32_t* indices,
                        std::size_t count, double* relative_gains);

/// Screens: the same in float32, for the tiles listed, with fused multiply-adds if the instruction set has them; W
/// rounded to float32, 6 x 8 row-major. Lanes that do not remain get -1. relative_gains[16 t + l] is that of lane l of
/// tile t, highest[t] the largest of the tile. Returns the largest of all.
using Screen = float (*)(const Tiles& tiles, const float* inverse_factor, const std::uint32_t* list, std::size_t count,
                         float* relative_gains, float* highest);

/// Lists the tiles t with lower <= bounds[t] <= upper, as ListBetween does, and screens them.
struct ScreenedTiles {
  std::size_t count;
  float largest;
};
using ScreenBetween = ScreenedTiles (*)(const Tiles& tiles, const float* inverse_factor, const float* bounds,
                                        std::size_t tile_count, std::size_t part, std::size_t parts, float lower,
                                        float upper, std::uint32_t* list, float* relative_gains, float* highest);

/// A round of lazy greedy. Tiles with a bound of at least `first_threshold` > 0 are screened first, then those that may
/// hold the best candidate nevertheless; then survivors are listed, and the bounds of screened tiles updated.
struct PromisingRound {
  std::size_t tile_count;
  float first_threshold;
  UpperLine line;                   ///< above exact relative gains
  double tight_above, tight_below;  ///< the relative gains between which it is tight: if the best is not between them,
                                    ///< the caller has to finish the round
  double drift;   ///< (1 - drift) (1 + an exact relative gain) is at most 1 + the stale bound of its tile
  float* bounds;  ///< per tile; this and the following are read and written
  float* relative_gains;
  float* highest;
  std::uint32_t* list;   ///< screened tiles
  std::uint32_t* lanes;  ///< survivors

  bool is_done = false;  ///< the whole round, not only screening
  std::size_t listed = 0;
  float lowest_listed = 0;  ///< the bound down to which tiles are screened
  float best = -1;          ///< the largest relative gain in float32
  double assured = -1;      ///< a lower bound of the largest exact relative gain
  std::size_t survivors = 0;
  float highest_bound = -1;  ///< the largest of `bounds`, updated
};
using ScreenPromising = void (*)(const Tiles& tiles, const float* inverse_factor, PromisingRound& round);

/// Screens with a bound of each candidate's own rounding error (docs/numerics.md): relative_gains and `highest` hold
/// upper bounds of the exact relative gain, +infinity where float32 overflows; lower[16 t + l] is a lower bound.
/// Returns the largest lower bound.
using ScreenWithCare = float (*)(const Tiles& tiles, const float* inverse_factor, const std::uint32_t* list,
                                 std::size_t count, float* relative_gains, float* highest, float* lower);

/// Floats from one record to the next: a candidate's entries together, padded to a multiple of four.
constexpr std::size_t record_size(Form form) { return (entries_of(form) + 3) / 4 * 4; }

/// Lists the lanes of the listed tiles whose relative gain is at least `threshold` and whose block differs from
/// `unlike` in some entry (nullptr: any block); returns how many. Up to 16 more may be written.
using ListSurvivors = std::size_t (*)(const Tiles& tiles, const float* relative_gains, const float* highest,
                                      float threshold, const std::uint32_t* list, std::size_t count,
                                      const float* unlike, std::uint32_t* lanes);

/// Copies candidates [0, count) into records, from which single candidates are gathered faster than from planes;
/// read and written up to the next multiple of 16 candidates.
using MakeRecords = void (*)(const Planes& planes, std::size_t count, float* records);

/// Copies the listed candidates to consecutive lanes: entry e of candidate indices[16 t + l] to
/// tiles[(entries * t + e) * 16 + l]. `count` is a multiple of 16.
using Gather = void (*)(const float* records, const std::uint32_t* indices, std::size_t count, float* tiles);

/// column_max[c] is the largest |entry| in column c of any row of tiles that lie one after the other; of factored ones
/// of |A| [ I | |[X]x| ].
using ColumnMax = void (*)(const float* tiles, std::size_t tile_count, double* column_max);

/// The same of the first `count` candidates of a store whose blocks are factored. False if A or X are so large that
/// the underflow of one product could matter next to another (docs/numerics.md): then they must not be screened so.
using FactoredMax = bool (*)(const Planes& planes, std::size_t count, double* column_max);

/// traces[i] = |H W^T|_F^2 for candidate i in [0, count), its term of tr(M^-1 sum of H^T H), in float32; -1 if
/// free[i] is 0, and beyond the last one up to the next multiple of 16. free[i] is 0 or 1.
using Traces = void (*)(const Planes& planes, const double* inverse_factor, const unsigned char* free,
                        std::size_t count, float* traces);

/// The same for listed candidates, as Decide: in float64, in one fixed order of operations.
using ExactTraces = void (*)(const Planes& planes, const double* inverse_factor, const std::uint32_t* indices,
                             std::size_t count, double* traces);

/// How many of values[0 .. count), padded to a multiple of 16, are at least `threshold`; the padding counts too.
using CountAtLeast = std::size_t (*)(const float* values, std::size_t count, float threshold);

/// Lists the positions i in [0, count) with lower <= values[i] <= upper, in order; returns how many. Looks at every
/// `parts`-th run of 16 positions, from run `part` on. Read up to the next multiple of 16; up to 16 more than are
/// listed may be written.
using ListBetween = std::size_t (*)(const float* values, std::size_t count, std::size_t part, std::size_t parts,
                                    float lower, float upper, std::uint32_t* list);

/// The largest of -1 and values[0 .. count); read up to the next multiple of 16.
using Largest = float (*)(const float* values, std::size_t count);

/// The largest |value| of values[0 .. count), none of which is NaN; 0 if there is none.
using LargestMagnitude = float (*)(const float* values, std::size_t count);

/// W <- the inverse Cholesky factor of M + H^T H, for the `count` rows of H, one after the other, six float64 each; W
/// is 6 x 8 row-major, zero above the diagonal; `narrow`: the new W rounded to float32. Returns the relative gain.
/// In float64, the same bits on every instruction set.
using AddRows = double (*)(double* inverse_factor, const double* rows, int count, float* narrow);

/// W <- the inverse Cholesky factor of M - h^T h, if the share of det M that is left, 1 - |W h^T|^2, is above
/// `min_share` >= 0; else W stays as it is. Returns that share; NaN if W h^T overflows. Otherwise as AddRows.
using RemoveRow = double (*)(double* inverse_factor, const double* row, double min_share);

/// The loss of a lane without a candidate; relative losses are at most 1.
constexpr double no_loss = 2;

/// The relative loss of removing a candidate H,
///     1 - det(M - H^T H) / det(M) = 1 - det(I_r - Y Y^T),   Y = H L^-T,
/// in [0, 1], for the tiles listed, in float64: the same bits on every instruction set, whatever lane a candidate is
/// in. losses[16 t + l] is that of lane l of tile t, no_loss if it does not remain, lowest[t] the smallest of the tile.
using Losses = void (*)(const Tiles& tiles, const double* inverse_factor, const std::uint32_t* list, std::size_t count,
                        double* losses, double* lowest);

/// sums, 6 x 6: H^T H summed over the candidates i in [0, count) with counted[i] != 0; at least `count` + 7 floats of a
/// plane can be read. In float64, the same bits on every instruction set: each entry takes at most `sum_roundings`
/// additions in a row.
using SumInformation = void (*)(const Planes& planes, const unsigned char* counted, std::size_t count, double* sums);
constexpr double sum_roundings(std::size_t count, int rows) { return (static_cast<double>(count) / 8 + 1) * rows + 8; }

/// draws[j], j in [0, count), is uniform in [0, range - j): draw first + j of the CounterRandom with this key.
using Draw = void (*)(std::uint64_t key, std::uint64_t first, std::uint32_t range, std::size_t count,
                      std::uint32_t* draws);

struct Kernel {
  const char* isa;
  Decide decide[3];  ///< [rows - 1]
  Screen screen[forms];
  ScreenBetween screen_between[forms];
  ScreenPromising screen_promising[forms];
  ScreenWithCare screen_with_care[forms];
  ListSurvivors list_survivors[forms];
  MakeRecords make_records[forms];
  Gather gather[forms];
  ColumnMax column_max[forms];
  FactoredMax factored_max;
  Traces traces[3];             ///< [rows - 1]
  ExactTraces exact_traces[3];  ///< [rows - 1]
  CountAtLeast count_at_least;
  AddRows add_rows;
  RemoveRow remove_row;
  Losses losses[3];                   ///< [rows - 1]
  SumInformation sum_information[3];  ///< [rows - 1]
  ListBetween list_between;
  Largest largest;
  LargestMagnitude largest_magnitude;
  Draw draw;
  BuildBlocks build_blocks;  ///< see simd/blocks.hpp
};

/// Kernels built into this library, narrowest first, then nullptr.
const Kernel* const* built_in() noexcept;

/// Whether this machine (processor and operating system) can run it.
bool is_supported(const Kernel& kernel) noexcept;

/// The kernel that MAXLOGDET_ISA names, or the widest one supported if it is unset or empty; nullptr if it names one
/// that is not built in or that this machine lacks.
const Kernel* active() noexcept;

}  // namespace simd
}  // namespace maxlogdet
