// SPDX-License-Identifier: MIT
#define MAXLOGDET_KERNEL avx512_kernel
#define MAXLOGDET_ISA_NAME "avx512"
#include "simd/kernel.inl"
