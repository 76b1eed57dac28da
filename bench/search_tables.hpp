// SPDX-License-Identifier: MIT
#pragma once

// Tables of maxlogdet_search_tables. Each goes to stdout in Markdown after a line "table NAME", NAME being that of its
// place in docs/performance.md.

namespace maxlogdet::bench {

/// certificates, largest_gaps: how far answers are proved to be from the optimum.
void write_certificate_tables();

/// relaxed, relaxed_over_n, relaxed_frames: the relaxed strategy against lazy greedy.
void write_relaxed_tables();

/// exchange: what sweeps of swaps gain.
void write_exchange_table();

/// denormals: medians with denormal blocks, and how many times as long as with blocks nearly as tiny.
void write_denormal_table();

/// backward: backward greedy against lazy greedy.
void write_backward_table();

/// stopping: what it costs to look for a target in every round.
void write_target_table();

}  // namespace maxlogdet::bench
