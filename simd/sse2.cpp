// SPDX-License-Identifier: MIT
#define MAXLOGDET_KERNEL sse2_kernel
#define MAXLOGDET_ISA_NAME "sse2"
#include "simd/kernel.inl"
