# SPDX-License-Identifier: MIT
# The instruction sets: sets simd_isas, their names, from narrow to wide, and simd_rows, the rows of the list
# MAXLOGDET_ISAS(X), X(name, whether this processor has all that it takes) for each.

# maxlogdet_isa(NAME BASELINE FEATURE...): simd/kernel.inl is compiled for BASELINE and every FEATURE, as -march and -m name
# them, and picked where the processor has them all. From the baseline up, so that an -march=native of a surrounding
# project does not widen it.
function(maxlogdet_isa name baseline)
  if(NOT CMAKE_SYSTEM_PROCESSOR MATCHES "${processors_of_${baseline}}")
    return()
  endif()
  list(TRANSFORM ARGN PREPEND "-m" OUTPUT_VARIABLE flags)
  list(TRANSFORM ARGN REPLACE "(.+)" "__builtin_cpu_supports(\"\\1\")" OUTPUT_VARIABLE checks)
  list(JOIN checks " && " is_supported)
  if(NOT ARGN)
    set(is_supported true)
  endif()
  set(simd_isas ${simd_isas} ${name} PARENT_SCOPE)
  set(simd_flags_of_${name} -march=${baseline} ${flags} PARENT_SCOPE)
  set(simd_rows "${simd_rows} \\\n  X(${name}, ${is_supported})" PARENT_SCOPE)
endfunction()
set(processors_of_x86-64 "x86_64|AMD64|amd64")
set(processors_of_armv8-a "aarch64|arm64")
set(simd_isas)
set(simd_rows)

# From narrow to wide; the first of an architecture is what all of its processors have.
maxlogdet_isa(sse2 x86-64)
maxlogdet_isa(avx2 x86-64 avx2 fma)
maxlogdet_isa(avx512 x86-64 avx512f avx512cd avx512dq avx512bw avx512vl)
maxlogdet_isa(neon armv8-a)

if(NOT simd_isas)
  message(FATAL_ERROR "maxlogdet: no kernel for ${CMAKE_SYSTEM_PROCESSOR}; x86-64 and AArch64 are supported. Another one "
                      "is a row of simd/isas.cmake.")
endif()
