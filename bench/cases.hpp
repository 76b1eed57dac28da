// SPDX-License-Identifier: MIT
#pragma once

namespace maxlogdet::bench {

/// Latency and quality of select() and of the baselines; `full`: more of the grid.
void add_selection_cases(bool full);

/// append_blocks, and the way from points to indices.
void add_append_cases();

/// select() and append_blocks on several threads, and selectors side by side.
void add_threading_cases();

/// What a tracker pays a frame: frames of some hundred matches, with hot and with cold caches.
void add_tracker_cases();

}  // namespace maxlogdet::bench
