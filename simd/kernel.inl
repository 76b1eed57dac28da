// SPDX-License-Identifier: MIT
// The functions of an instruction set, compiled once for each. The including unit defines MAXLOGDET_KERNEL (the name of
// the table it exports) and MAXLOGDET_ISA_NAME. Everything else here has internal linkage or is inlined: a weak symbol
// would let the linker run wide code on a narrow machine (tests/checks/check_symbols looks).

#include "simd/counter_random.hpp"
#include "simd/jacobian.hpp"
#include "simd/kernel.hpp"
#include "simd/triangle.hpp"
#include "simd/whitening.hpp"
#include "simd/xsimd_compat.hpp"

#include <cstring>
#include <limits>
#include <type_traits>

namespace {

using maxlogdet::simd::dimension;
using maxlogdet::simd::entries_of;
using maxlogdet::simd::factored;
using maxlogdet::simd::Form;
using maxlogdet::simd::next_below;
using maxlogdet::simd::one_row;
using maxlogdet::simd::padded_dimension;
using maxlogdet::simd::plane_of;
using maxlogdet::simd::Planes;
using maxlogdet::simd::point_plane;
using maxlogdet::simd::PromisingRound;
using maxlogdet::simd::rounded_up;
using maxlogdet::simd::rows_of;
using maxlogdet::simd::ScreenedTiles;
using maxlogdet::simd::stale_threshold;
using maxlogdet::simd::three_rows;
using maxlogdet::simd::tile_size;
using maxlogdet::simd::TileLine;
using maxlogdet::simd::Tiles;
using maxlogdet::simd::two_rows;

// A pack holds one candidate, or match, in each lane; it is as wide as this unit's flags allow.
constexpr std::size_t double_lanes = Doubles::size;
constexpr std::size_t float_lanes = Floats::size;
// A pack of float64 rounded to float32; xsimd has no float32 batch of double_lanes.
typedef float Narrow __attribute__((vector_size(double_lanes * sizeof(float))));  // NOLINT(modernize-use-using)

inline void store_narrow(const Doubles& values, float* to) {
  const Doubles::register_type exact = values;
  const Narrow rounded = __builtin_convertvector(exact, Narrow);
  std::memcpy(to, &rounded, sizeof rounded);
}

}  // namespace

#include "simd/factored.inl"
#include "simd/matches.inl"
#include "simd/screen.inl"

// These use the ones above.
#include "simd/decide.inl"
#include "simd/draws.inl"
#include "simd/factors_along_ray.inl"
#include "simd/factors_by_jacobian.inl"
#include "simd/jacobians.inl"
#include "simd/losses.inl"
#include "simd/rounds.inl"
#include "simd/screen_with_care.inl"
#include "simd/sums.inl"
#include "simd/tiles.inl"
#include "simd/traces.inl"
#include "simd/update.inl"

// This uses all about matches.
#include "simd/blocks.inl"

namespace maxlogdet {
namespace simd {

#define MAXLOGDET_FORMS(function) \
  { function<one_row>, function<two_rows>, function<three_rows>, function<factored> }
extern const Kernel MAXLOGDET_KERNEL;
const Kernel MAXLOGDET_KERNEL = {MAXLOGDET_ISA_NAME,
                                 {decide<1>, decide<2>, decide<3>},
                                 MAXLOGDET_FORMS(screen),
                                 MAXLOGDET_FORMS(screen_between),
                                 MAXLOGDET_FORMS(screen_promising),
                                 MAXLOGDET_FORMS(screen_with_care),
                                 MAXLOGDET_FORMS(list_survivors),
                                 MAXLOGDET_FORMS(make_records),
                                 MAXLOGDET_FORMS(gather),
                                 MAXLOGDET_FORMS(column_max),
                                 factored_max,
                                 {traces<1>, traces<2>, traces<3>},
                                 {exact_traces<1>, exact_traces<2>, exact_traces<3>},
                                 count_at_least,
                                 add_rows,
                                 remove_row,
                                 {losses<1>, losses<2>, losses<3>},
                                 {sum_information<1>, sum_information<2>, sum_information<3>},
                                 list_between,
                                 largest,
                                 largest_magnitude,
                                 draw,
                                 build_blocks};
#undef MAXLOGDET_FORMS

}  // namespace simd
}  // namespace maxlogdet
