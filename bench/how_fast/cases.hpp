// SPDX-License-Identifier: MIT
#pragma once

namespace maxlogdet::bench {

/// Latency and quality of select() and of the baselines; `full`: a larger grid.
void add_selection_cases(bool full);

/// append_blocks, alone and followed by a selection.
void add_append_cases();

/// select() on several threads, and several selectors at once.
void add_threading_cases();

/// The cost per frame of a tracker: some hundred matches, with hot and with cold caches.
void add_tracker_cases();

}  // namespace maxlogdet::bench
