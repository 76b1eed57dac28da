// SPDX-License-Identifier: MIT
#define MAXLOGDET_KERNEL neon_kernel
#define MAXLOGDET_ISA_NAME "neon"
#include "simd/kernel.inl"
