// SPDX-License-Identifier: MIT
// The functions of an instruction set, compiled once for each by a unit that kernel/CMakeLists.txt generates. It
// defines MAXLOGDET_KERNEL, the name of the table that is exported, and MAXLOGDET_ISA_NAME. Everything else here has
// internal linkage or is inlined: a weak symbol would let the linker run wide code on a narrow machine
// (tests/checks/check_symbols looks).

#include "simd/kernel.hpp"
#include "simd/xsimd_compat.hpp"

#include <cstring>
#include <limits>
#include <type_traits>

namespace maxlogdet::simd {
namespace {

// A pack holds one candidate, or match, in each lane; it is as wide as this unit's flags allow.
constexpr std::size_t double_lanes = Doubles::size;
constexpr std::size_t float_lanes = Floats::size;
// A pack of float64 rounded to float32; xsimd has no float32 batch of double_lanes.
typedef float Narrow __attribute__((vector_size(double_lanes * sizeof(float))));  // NOLINT(modernize-use-using)

// Consecutive floats as doubles.
inline Doubles widened(const float* values) {
  Narrow narrow;
  std::memcpy(&narrow, values, sizeof narrow);
  return Doubles(__builtin_convertvector(narrow, Doubles::register_type));
}

// Rounded in memory: GCC 12.2 drops (double)(float)x in short loops at -O3.
inline void store_narrow(const Doubles& values, float* to) {
  const Doubles::register_type exact = values;
  const Narrow rounded = __builtin_convertvector(exact, Narrow);
  std::memcpy(to, &rounded, sizeof rounded);
}

}  // namespace
}  // namespace maxlogdet::simd

#include "simd/arrays.inl"
#include "simd/gains.inl"
#include "simd/whitening.inl"

// These use the ones above.
#include "simd/alignment.inl"
#include "simd/blocks.inl"
#include "simd/exact_gains.inl"
#include "simd/factor_updates.inl"
#include "simd/gather.inl"

namespace maxlogdet::simd {
namespace {

template <Form form>
constexpr LayoutFunctions layout_functions() {
  return {make_records<form>, gather<form>};
}
template <int Rows>
constexpr ExactFunctions exact_functions() {
  return {decide<Rows>, evaluate_in_float64<Rows>, traces<Rows>};
}

}  // namespace

extern const Kernel MAXLOGDET_KERNEL;
const Kernel MAXLOGDET_KERNEL = {
    MAXLOGDET_ISA_NAME,
    build_blocks,
    {whiten_matches, measure_leverage, measure_errors, count_third, add_normal_equations},
    {layout_functions<one_row>(), layout_functions<two_rows>(), layout_functions<three_rows>(),
     layout_functions<factored>()},
    {evaluate_listed<one_row>, evaluate_listed<two_rows>, evaluate_listed<three_rows>, evaluate_listed<factored>},
    {exact_functions<1>(), exact_functions<2>(), exact_functions<3>()},
    add_rows,
    {measure_sizes, median, largest, list_tiles, highest_unevaluated, list_survivors, keep_bounds}};

}  // namespace maxlogdet::simd
