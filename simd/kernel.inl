// SPDX-License-Identifier: MIT
// All that an instruction set offers, compiled once for each. The including unit defines MAXLOGDET_KERNEL (the name of
// the table it exports) and MAXLOGDET_ISA_NAME. Everything else here has internal linkage and must be inlined: a weak
// symbol would let the linker run wide code on a narrow machine (tests/check_symbols looks).

#include "simd/counter_random.hpp"
#include "simd/kernel.hpp"
#include "simd/xsimd_compat.hpp"

#include <cstring>
#include <limits>

namespace {

using maxlogdet::simd::dimension;
using maxlogdet::simd::padded_dimension;
using maxlogdet::simd::Planes;
using maxlogdet::simd::tile_size;
using maxlogdet::simd::Tiles;

// A pack holds one candidate, or match, a lane; it is as wide as this unit's flags allow.
constexpr std::size_t double_lanes = Doubles::size;
constexpr std::size_t float_lanes = Floats::size;

}  // namespace

#include "simd/blocks.inl"
#include "simd/decide.inl"
#include "simd/draws.inl"
#include "simd/losses.inl"
#include "simd/screen.inl"
#include "simd/sums.inl"
#include "simd/traces.inl"
#include "simd/update.inl"

namespace maxlogdet {
namespace simd {

extern const Kernel MAXLOGDET_KERNEL;
const Kernel MAXLOGDET_KERNEL = {MAXLOGDET_ISA_NAME,
                                 {decide<1>, decide<2>, decide<3>},
                                 {screen<1>, screen<2>, screen<3>},
                                 {screen_with_care<1>, screen_with_care<2>, screen_with_care<3>},
                                 {list_survivors<1>, list_survivors<2>, list_survivors<3>},
                                 {make_records<1>, make_records<2>, make_records<3>},
                                 {gather<1>, gather<2>, gather<3>},
                                 {column_max<1>, column_max<2>, column_max<3>},
                                 {traces<1>, traces<2>, traces<3>},
                                 {exact_traces<1>, exact_traces<2>, exact_traces<3>},
                                 count_at_least,
                                 add_row,
                                 remove_row,
                                 {losses<1>, losses<2>, losses<3>},
                                 {sum_information<1>, sum_information<2>, sum_information<3>},
                                 list_between,
                                 largest,
                                 draw,
                                 build_blocks};

}  // namespace simd
}  // namespace maxlogdet
