// SPDX-License-Identifier: MIT
#pragma once

#include "simd/gain_filter.hpp"
#include "simd/layouts.hpp"
#include "simd/matches.hpp"

#include <cstddef>
#include <cstdint>
#include <limits>

// The functions that an instruction set offers, by parts. Raw pointers in, raw pointers out: besides the headers of
// this folder, a per-ISA translation unit shares with the rest only what is inlined or has internal linkage, so that
// the linker cannot merge code of wider instructions into baseline code.
//
// W is the inverse Cholesky factor, 6 x 8 row-major, of which the lower triangle is read: M = L L^T, W = L^-1. Y = H
// W^T.

namespace maxlogdet::simd {

/// 2^-102. Rounding to float32 is relative to the magnitude only down to 2^-126, and the caller may flush denormal
/// numbers to zero: error bounds take the entries of W as at least this large.
constexpr double smallest_entry = 1.9721522630525295e-31;

/// The arrays that a round reads and writes. All hold whole registers.
struct RoundArrays {
  float* bounds;   ///< per tile: its stale bound; no exact relative gain in it exceeds this (but for the drift)
  float* highest;  ///< per tile: the maximum of `gains` when last evaluated
  float* gains;    ///< per lane: the relative gain when last evaluated, in float32 or rounded to it; -1: none there
  Tile* list;      ///< scratch: tiles to evaluate
};

/// Nothing is evaluated: NaN, which no bound reaches.
constexpr float nothing_evaluated = std::numeric_limits<float>::quiet_NaN();

/// What a round knows (docs/architecture.md).
struct Round {
  RoundArrays arrays;
  GainFilter filter;
  float evaluated_from = nothing_evaluated;  ///< exactly the tiles of at least this stale bound are evaluated
  double assured = -1;                       ///< a lower bound of the largest exact relative gain
};

/// What a call has evaluated: the largest value found, -1 if none, and how many candidates.
struct Evaluated {
  float best;
  std::size_t count;
};

/// The blocks in the lanes of tiles, as they are stored: candidate[i] is in lane i; null in the order of the store.
struct BlocksOfLanes {
  Planes planes;
  const Index* candidate;
};

/// Evaluates det(I + Y Y^T) - 1 in float32 in the tiles listed, with W rounded to float32, and fused multiply-adds if
/// the instruction set has them: `gains` and `highest` of `arrays`.
using EvaluateTiles = Evaluated (*)(const Tiles& tiles, const float* w, const Tile* list, std::size_t count,
                                    const RoundArrays& arrays);

/// Copies of candidates, per form.
struct LayoutFunctions {
  /// Copies candidates [0, count) into records, from which single candidates are gathered faster than from planes; read
  /// and written up to the next multiple of 16 candidates.
  void (*make_records)(const Planes& planes, std::size_t count, float* records);

  /// Copies the listed candidates to consecutive lanes: entry e of candidate listed[16 t + l] to
  /// tiles[(entries * t + e) * 16 + l]. `count` is a multiple of 16.
  void (*gather)(const float* records, const Index* listed, std::size_t count, float* tiles);
};

/// float64, in one fixed order of operations: the same bits on every instruction set, but for `evaluate`, which only
/// excludes candidates. Per number of rows.
struct ExactFunctions {
  /// relative_gains[j], not below 0, of candidate listed[j]: det(M + H^T H) / det(M) - 1 = det(I + Y Y^T) - 1. Without
  /// the 1, gains far below 2^-53 keep their digits.
  void (*decide)(const Planes& planes, const double* w, const Index* listed, std::size_t count, double* relative_gains);

  /// Evaluates the same by elimination, rounded to float32, in the tiles listed: `gains` and `highest` of `arrays`. It
  /// takes half of the time of `decide`, and is off by more (docs/numerics.md).
  Evaluated (*evaluate)(const Tiles& tiles, const BlocksOfLanes& blocks, const double* w, const Tile* list,
                        std::size_t count, const RoundArrays& arrays);

  /// traces[i] = |Y|_F^2 of candidate i in [0, count), its term of tr(M^-1 sum of H^T H). Reads and writes up to 7
  /// more.
  void (*traces)(const Planes& planes, const double* w, std::size_t count, double* traces);
};

/// W <- the inverse Cholesky factor of M + H^T H, for the `count` rows of H, one after the other, six float64 each; W
/// is zero above the diagonal; `narrow`: the new W rounded to float32. Returns the relative gain. In float64, the same
/// bits on every instruction set.
using AddRows = double (*)(double* w, const double* rows, int count, float* narrow);

/// Medians have 23 - 11 bits after the first: 2^-12 is far below the error of a median.
constexpr std::uint32_t rounded_bits = 11;

/// Arrays of float32.
struct ArrayFunctions {
  /// sizes[i]: the largest |entry| of block i in three columns, of which `planes` has the first; infinite if that is 0.
  /// `sizes` is aligned; reads and writes up to the next multiple of 16.
  void (*measure_sizes)(const float* planes, std::size_t stride, int rows, std::size_t count, float* sizes);

  /// The lower median of those of `count` values that are finite, rounded up to a float whose last rounded_bits are 1.
  /// `count` is a multiple of 16. Values are aligned, and not negative.
  float (*median)(const float* values, std::size_t count, std::size_t& finite);

  /// The largest of -1 and values[0 .. count).
  float (*largest)(const float* values, std::size_t count);

  /// Lists the positions in [0, count) with lower <= values[i] < upper, in order; returns how many. No value reaches an
  /// `upper` of NaN. Reads up to the next multiple of 16.
  std::size_t (*list_tiles)(const float* values, std::size_t count, float lower, float upper, Tile* list);

  /// The largest stale bound of a tile that is not evaluated; any_candidate if there is none.
  float (*highest_unevaluated)(const Tiles& tiles, const Round& round);

  /// Lists the lanes of evaluated tiles that may hold the best, and returns how many.
  std::size_t (*list_survivors)(const Tiles& tiles, const Round& round, Lane* lanes);

  /// Makes the maxima of the evaluated tiles their stale bounds, and returns the largest of all.
  float (*keep_bounds)(const Tiles& tiles, const Round& round);
};

struct Kernel {
  const char* isa;
  BuildBlocks build_blocks;  ///< from matches to blocks, see simd/matches.hpp
  AlignmentFunctions alignment;
  LayoutFunctions layouts[forms];
  EvaluateTiles evaluate[forms];
  ExactFunctions exact[3];  ///< [rows - 1]
  AddRows add_rows;
  ArrayFunctions arrays;
};

/// Kernels built into this library, narrowest first, then nullptr.
const Kernel* const* built_in() noexcept;

/// Whether this machine (processor and operating system) can run it.
bool is_supported(const Kernel& kernel) noexcept;

/// The kernel that MAXLOGDET_ISA names, or the widest one supported if it is unset or empty; nullptr if it names one
/// that is not built in or that this machine lacks.
const Kernel* active() noexcept;

}  // namespace maxlogdet::simd
