#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""What the benchmarks measured, from Google Benchmark's JSON: the source of every number in tables.

Usage: results.py BENCH.json    Fails with one line if the machine was too noisy to publish.
"""

import math
import statistics
import sys

from maxlogdet_tools.files import json_of

MOST_NOISE = 0.05  # by which the medians of the first and of the second half of the blocks may differ
BASE = {"kind": "grid", "family": "euroc_like", "n": "2000", "k": "100", "blocks": "2_rows"}
KINDS = {"stereo_with_covariances": "stereo with covariances", "monocular": "monocular"}
STEREO, MONOCULAR = KINDS
CACHES = ["hot", "cold"]
# How pages write instruction sets.
ISAS = {"sse2": "SSE2", "avx2": "AVX2", "avx512": "AVX-512", "neon": "NEON"}


def fields_of(name):
    """The fields of KIND/METHOD/KEY:VALUE/..., the names of cases."""
    parts = name.split("/")
    words = [part for part in parts if ":" not in part]
    return {"kind": words[0], "method": words[1], **dict(part.split(":", 1) for part in parts if ":" in part)}


class Results:
    def __init__(self, path):
        data = json_of(path)
        self.widest = data["context"]["maxlogdet_isa"]
        blocks = {}
        for result in data["benchmarks"]:
            if result["run_type"] == "iteration":
                blocks.setdefault(result["run_name"], []).append(result)
        self.rows = []
        for name, found in blocks.items():
            found.sort(key=lambda block: block["repetition_index"])
            times = [block["real_time"] for block in found]
            last = max(found, key=lambda block: block["calls"])
            self.rows.append({**last, **fields_of(name), "times": times, "us": statistics.median(times)})

    def find(self, **wanted):
        """The row with these fields; None if it was not measured."""
        return next((row for row in self.rows if all(row.get(key) == value for key, value in wanted.items())), None)

    def of(self, method, isa, **wanted):
        return self.find(method=method, isa="native" if method.startswith("eigen_") else isa or self.widest, **wanted)

    def tracker(self, method, matches, n="465", caches="hot", k="100", isa=None):
        return self.of(method, isa, kind="tracker", matches=matches, n=n, caches=caches, k=k)

    def grid(self, method, isa=None, **where):
        """The row of a method at the base point, changed by `where`."""
        if "stochastic" in method:
            where.setdefault("epsilon", "0.1")
        return self.of(method, isa, **{**BASE, **where})

    def noise(self):
        """By how much the two halves of the run differ: those of the baseline, whose blocks are interleaved with all others,
        or those of the middle case."""
        baseline = self.find(kind="baseline") or sys.exit("expected the case baseline/eigen_lazy_scan among those measured")
        return max(difference(baseline), statistics.median(map(difference, self.rows)))


def difference(row):
    """Between the first and the second half of a case's blocks, as a share."""
    half = (len(row["times"]) + 1) // 2
    first, second = statistics.median(row["times"][:half]), statistics.median(row["times"][-half:])
    return max(first, second) / min(first, second) - 1


def ratio(slow, fast):
    return math.nan if slow is None or fast is None else slow["us"] / fast["us"]


def us(row, counter="us"):
    """A time with at least three digits."""
    if row is None:
        return "–"
    return f"{row[counter]:.0f}" if row[counter] >= 1000 else f"{row[counter]:.1f}"


def times(value):
    return "–" if math.isnan(value) else f"{value:.0f}" if value >= 10 else f"{value:.1f}"


def against(eigen, ours):
    """The cells of both times and of their ratio: that of the times as they are written, so that a reader who divides finds
    the same."""
    cells = [us(eigen), us(ours)]
    return [*cells, "–" if "–" in cells else times(float(cells[0]) / float(cells[1]))]


def lost(row, best):
    """The loss: how much less log det this row has than the best, in nats."""
    return "–" if row is None or best is None else f"{round(best['log_det'] - row['log_det'], 3) + 0.0:.3f}"


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    noise = Results(sys.argv[1]).noise()
    if noise > MOST_NOISE:
        sys.exit(f"too noisy to publish: the two halves of the run differ by {100 * noise:.0f} %, expected at most "
                 f"{100 * MOST_NOISE:.0f} %")  # fmt: skip


if __name__ == "__main__":
    main()
