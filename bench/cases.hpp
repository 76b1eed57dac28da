// SPDX-License-Identifier: MIT
#pragma once

namespace maxlogdet::bench {

/// Latency and quality of select() and of the baselines; `full`: more of the grid.
void add_selection_cases(bool full);

/// append_blocks, and the way from points to indices.
void add_append_cases();

/// select() and append_blocks on several threads, and selectors side by side.
void add_threading_cases();

}  // namespace maxlogdet::bench
