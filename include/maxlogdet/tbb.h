// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/maxlogdet.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Initialises an executor of oneTBB, which uses the arena of the calling thread, for all that takes one; it needs no
/// destruction. In the library maxlogdet::tbb, libmaxlogdet_tbb.a. The error is that of maxlogdet_executor_init; a
/// struct too short for the functions is an invalid_argument, too.
maxlogdet_error maxlogdet_tbb_executor_init(maxlogdet_executor* executor, size_t struct_size);

#ifdef __cplusplus
}
#endif
