// SPDX-License-Identifier: MIT
#define MAXLOGDET_KERNEL avx2_kernel
#define MAXLOGDET_ISA_NAME "avx2"
#include "simd/kernel.inl"
