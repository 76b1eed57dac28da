#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Prints the tables of tracker frames; rewrites them in docs/performance.md and README.md, and the record.

Usage: write_tracker_tables.py BENCH.json
"""

import itertools
import math
import sys

from maxlogdet_tools.pages import paragraph, rewrite, table
from maxlogdet_tools.project import ROOT
from maxlogdet_tools.runs import stamp
from results import Results, ratio, us
from tracker_results import (
    CACHES, KINDS, MONOCULAR, STEREO, STEREO_MAP, find, times_dense, times_eigen, times_select,
)  # fmt: skip

SHOWN = [STEREO_MAP, MONOCULAR]  # the record has all rows


def number(value, digits=2):
    return "–" if math.isnan(value) else f"{value:.{digits}f}"


def lost(row, best):
    """The loss of log det, in nats."""
    return "–" if row is None or best is None else f"{round(best['log_det'] - row['log_det'], 3) + 0.0:.3f}"


def frames(results):
    """A frame of 465 matches."""
    rows = []
    for blocks, caches in itertools.product(SHOWN, CACHES):
        row = lambda method: find(results, method, blocks, caches=caches)
        both = row("blocks_and_select")
        rows.append([KINDS[blocks], caches, us(row("append_blocks")), us(row("lazy_greedy")), us(both),
                     us(both, "p99_us")])  # fmt: skip
    return table(["matches", "caches", "blocks, µs", "selection, µs", "both, µs", "both, 99th percentile, µs"], rows)


def against_eigen(results):
    rows = []
    for blocks, n in itertools.product(SHOWN, ("465", "2000")):
        row = lambda method: find(results, method, blocks, n)
        ratios = (number(times_eigen(results, blocks, n, caches), 1) for caches in CACHES)
        rows.append([KINDS[blocks], n, us(row("eigen_lazy_scan")), us(row("blocks_and_select")), *ratios])
    return table(["matches", "n", "Eigen, hot, µs", "ours, hot, µs", "times as fast, hot (ratio)",
                  "times as fast, cold (ratio)"], rows)  # fmt: skip


def sampling(results):
    rows = []
    for n in ("465", "2000"):
        lazy, stochastic = (find(results, method, STEREO_MAP, n) for method in ("lazy_greedy", "stochastic_greedy"))
        rows.append([n, us(lazy), us(stochastic), lost(stochastic, lazy)])
    return table(["n", "`lazy_greedy`, µs", "`stochastic_greedy`, µs", "lost, nats"], rows)


def worst(values):
    return number(max(values, key=lambda value: -math.inf if math.isnan(value) else value))


def details(results):
    slots = worst([times_dense(results, "blocks_and_select", blocks, "377", "2005", caches)
                   for blocks, caches in itertools.product(SHOWN, CACHES)])  # fmt: skip
    hot, cold = (number(ratio(*(find(results, "lazy_greedy", STEREO, caches=caches, prior=prior)
                                for prior in (None, "motion")))) for caches in CACHES)  # fmt: skip
    return paragraph(
        f"A frame of 2005 slots of which only 377 hold a match takes at most {slots} times as long as these matches",
        f"alone. A motion prior of 5 cm and 0.01 rad makes selections from a stereo frame {hot} times as fast (hot)",
        f"and {cold} times as fast (cold).",
    )


def active(results):
    rows, losses = [], []
    for n, share in itertools.product(("800", "3000"), ("1", "0.5", "0.2")):
        one, some, many = (find(results, "active", STEREO_MAP, n, batch=batch, matched=share)
                           for batch in ("1", "8", "32"))  # fmt: skip
        if one is not None:
            losses += [lost(some, one)] if some is not None else []
            times = (number(times_select(results, n, share, batch), 1) for batch in ("1", "32"))
            rows.append([n, f"{100 * float(share):.0f}", *times, lost(many, one)])
    return [
        *table(["n", "found, %", "one by one (ratio)", "by 32 (ratio)", "by 32, lost, nats"], rows),
        "",
        f"Batches of eight proposals lost at most {max(losses, key=float, default='–')} nats.",
    ]


def readme(results):
    rows = []
    for blocks, caches in itertools.product(SHOWN, CACHES):
        both = find(results, "blocks_and_select", blocks, caches=caches)
        rows.append([KINDS[blocks], caches, us(both), us(both, "p99_us"),
                     us(find(results, "eigen_lazy_scan", blocks, caches=caches)),
                     number(times_eigen(results, blocks, "465", caches), 1)])  # fmt: skip
    return [
        *paragraph(
            "A tracker selects 100 of the 465 matches of a frame: *hot* when the caches still hold the code and data",
            "of the previous call, *cold* when the other work of a tracker has just displaced them",
            "([docs/performance.md](docs/performance.md#in-a-tracker)).",
        ),
        "",
        *table(["matches", "caches", "blocks and selection, µs", "99th percentile, µs", "selection in Eigen, µs",
                "times as fast (ratio)"], rows),
    ]  # fmt: skip


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    results = Results(sys.argv[1])
    if not any(row["kind"] == "tracker" for row in results.rows):
        print("no case of a tracker was measured: its tables stay unchanged")
        return
    performance, front = ROOT / "docs/performance.md", ROOT / "README.md"
    for section in (frames, against_eigen, sampling, details, active):
        lines = section(results)
        print("\n".join(lines))
        rewrite(performance, section.__name__, lines)
    rewrite(front, "tracker_latency", readme(results))
    for page in (performance, front):
        stamp(page, "how_fast --tracker")
    results.record("tracker.csv", "tracker")


if __name__ == "__main__":
    main()
