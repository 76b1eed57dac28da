// SPDX-License-Identifier: MIT
#pragma once

#include "simd/blocks.hpp"
#include "simd/layouts.hpp"
#include "simd/round.hpp"

#include <cstddef>
#include <cstdint>

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

/// Chunks of a step: every `count`-th run of 16 tiles, from run `index` on. Each lists its tiles from
/// `first_of_list` of RoundArrays::list on.
struct Part {
  std::size_t index, count, first_of_list;
};

/// What a step has evaluated: the largest value found, -1 if none, and how many candidates.
struct Evaluated {
  float best;
  std::size_t count;
};

/// The blocks in the lanes of tiles, as they are stored: candidate[i] is in lane i; null in the order of the store.
struct BlocksOfLanes {
  Planes planes;
  const Candidate* candidate;
};

/// Rounds in float32 (simd/round.hpp), per form; W rounded to float32. Fused multiply-adds, if the instruction set has
/// them.
struct RoundFunctions {
  /// Evaluates det(I + Y Y^T) - 1 in the tiles of a part with a stale bound of at least `from` that are not evaluated.
  Evaluated (*evaluate)(const Tiles& tiles, const float* w, const Round& round, float from, const Part& part);

  /// A whole round for one candidate: prove_best and survivors.
  std::size_t (*run)(const Tiles& tiles, const float* w, Round& round, Lane* survivors);
};

/// The parts of a round that do not depend on the form.
struct BoundFunctions {
  /// Lists the lanes of evaluated tiles that may hold the best, and returns how many. Up to 16 more may be written.
  std::size_t (*list_survivors)(const Tiles& tiles, const Round& round, Lane* lanes);

  /// Makes the maxima of the evaluated tiles their stale bounds, and returns the largest of all. A round that goes on
  /// begins again.
  float (*keep)(const Tiles& tiles, const Round& round);

  /// The largest value of all evaluated tiles; -1 if there is none.
  float (*highest_evaluated)(const Tiles& tiles, const Round& round);

  /// The largest stale bound of a tile that is not evaluated; any_candidate if there is none.
  float (*highest_unevaluated)(const Tiles& tiles, const Round& round);
};

/// Copies of candidates, per form.
struct LayoutFunctions {
  /// Copies candidates [0, count) into records, from which single candidates are gathered faster than from planes; read
  /// and written up to the next multiple of 16 candidates.
  void (*make_records)(const Planes& planes, std::size_t count, float* records);

  /// Copies the listed candidates to consecutive lanes: entry e of candidate listed[16 t + l] to
  /// tiles[(entries * t + e) * 16 + l]. `count` is a multiple of 16.
  void (*gather)(const float* records, const Candidate* listed, std::size_t count, float* tiles);

  /// column_max[c] is the largest |entry| in column c of any row of tiles that lie one after the other; of factored
  /// ones of |A| [ I | |[X]x| ].
  void (*column_max)(const float* tiles, std::size_t tile_count, double* column_max);
};

/// float64, in one fixed order of operations: the same bits on every instruction set, but for `evaluate` and
/// `screen_traces`, which only exclude candidates. Per number of rows.
struct ExactFunctions {
  /// relative_gains[j], not below 0, of candidate listed[j]: det(M + H^T H) / det(M) - 1 = det(I + Y Y^T) - 1. Without
  /// the 1, gains far below 2^-53 keep their digits.
  void (*decide)(const Planes& planes, const double* w, const Candidate* listed, std::size_t count,
                 double* relative_gains);

  /// Evaluates the same, rounded to float32, in the tiles listed: `gains` and `highest` of `arrays`. By elimination it
  /// takes half of the time, and is off by more (docs/numerics.md).
  Evaluated (*evaluate)(const Tiles& tiles, const BlocksOfLanes& blocks, const double* w, bool by_elimination,
                        const Tile* list, std::size_t count, const RoundArrays& arrays);

  /// traces[j] = |Y|_F^2 of candidate listed[j].
  void (*traces)(const Planes& planes, const double* w, const Candidate* listed, std::size_t count, double* traces);

  /// traces[i] = |Y|_F^2 for candidate i in [0, count), its term of tr(M^-1 sum of H^T H), in float32; -1 if free[i] is
  /// 0, and beyond the last one up to the next multiple of 16. free[i] is 0 or 1.
  void (*screen_traces)(const Planes& planes, const double* w, const unsigned char* free, std::size_t count,
                        float* traces);

  /// The relative loss of removing a candidate, 1 - det(M - H^T H) / det(M) = 1 - det(I - Y Y^T), in [0, 1], for the
  /// tiles listed, whatever lane a candidate is in. losses[16 t + l] is that of lane l of tile t, no_loss if it does
  /// not remain, lowest[t] the smallest of the tile.
  void (*losses)(const Tiles& tiles, const double* w, const Tile* list, std::size_t count, double* losses,
                 double* lowest);

  /// sums, 6 x 6: H^T H summed over the candidates i in [0, count) with counted[i] != 0; at least `count` + 7 floats of
  /// a plane can be read. Each entry takes at most `sum_roundings` additions in a row.
  void (*sum_information)(const Planes& planes, const unsigned char* counted, std::size_t count, double* sums);
};

/// The loss of a lane without a candidate; relative losses are at most 1.
constexpr double no_loss = 2;
constexpr double sum_roundings(std::size_t count, int rows) { return (static_cast<double>(count) / 8 + 1) * rows + 8; }

/// Updates of W, in float64, the same bits on every instruction set.
struct FactorFunctions {
  /// W <- the inverse Cholesky factor of M + H^T H, for the `count` rows of H, one after the other, six float64 each; W
  /// is zero above the diagonal; `narrow`: the new W rounded to float32. Returns the relative gain.
  double (*add_rows)(double* w, const double* rows, int count, float* narrow);

  /// W <- the inverse Cholesky factor of M - h^T h, if the share of det M that is left, 1 - |W h^T|^2, is above
  /// `min_share` >= 0; else W stays as it is. Returns that share; NaN if W h^T overflows.
  double (*remove_row)(double* w, const double* row, double min_share);
};

/// Plain arrays of float32.
struct ArrayFunctions {
  /// How many of values[0 .. count), padded to a multiple of 16, are at least `threshold`; the padding counts too.
  std::size_t (*count_at_least)(const float* values, std::size_t count, float threshold);

  /// List the positions in [0, count) with lower <= values[i] < upper, in order; return how many. No value reaches an
  /// `upper` of NaN. Read up to the next multiple of 16; up to 16 more than are listed may be written.
  std::size_t (*list_candidates)(const float* values, std::size_t count, float lower, float upper, Candidate* list);
  std::size_t (*list_tiles)(const float* values, std::size_t count, float lower, float upper, Tile* list);

  /// The largest of -1 and values[0 .. count).
  float (*largest)(const float* values, std::size_t count);

  /// The largest |value| of values[0 .. count), none of which is NaN; 0 if there is none.
  float (*largest_magnitude)(const float* values, std::size_t count);
};

/// From matches to blocks.
struct BlockFunctions {
  BuildBlocks build;  ///< see simd/blocks.hpp

  /// As column_max, of the first `count` candidates of a store whose blocks are factored. False if A or X are so large
  /// that the underflow of one product could matter next to another (docs/numerics.md): then they must not be screened
  /// so.
  bool (*factored_max)(const Planes& planes, std::size_t count, double* column_max);
};

/// draws[j], j in [0, count), is uniform in [0, range - j): draw first + j of the CounterRandom with this key.
using Draw = void (*)(std::uint64_t key, std::uint64_t first, std::uint32_t range, std::size_t count,
                      std::uint32_t* draws);

struct Kernel {
  const char* isa;
  BlockFunctions blocks;
  LayoutFunctions layouts[forms];
  RoundFunctions rounds[forms];
  BoundFunctions bounds;
  ExactFunctions exact[3];  ///< [rows - 1]
  FactorFunctions factor;
  ArrayFunctions arrays;
  Draw draw;
};

/// Kernels built into this library, narrowest first, then nullptr.
const Kernel* const* built_in() noexcept;

/// Whether this machine (processor and operating system) can run it.
bool is_supported(const Kernel& kernel) noexcept;

/// The kernel that MAXLOGDET_ISA names, or the widest one supported if it is unset or empty; nullptr if it names one
/// that is not built in or that this machine lacks.
const Kernel* active() noexcept;

}  // namespace maxlogdet::simd
