// SPDX-License-Identifier: MIT
#pragma once

// Tables of maxlogdet_search_tables. Each goes to stdout in Markdown after a line "table NAME", where NAME is the
// marker in docs/performance.md.

namespace maxlogdet::bench {

/// certificates, largest_gaps: proved upper bounds of the distance to the optimum.
void write_certificate_tables();

/// denormals: median times with denormal blocks, and their ratio to those with normal blocks nearly as small.
void write_denormal_table();

/// stopping: the cost of checking a target in every round.
void write_target_table();

/// deadline: what an answer costs and is worth that is filled because no time is left.
void write_deadline_table();

}  // namespace maxlogdet::bench
