#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Prints what was measured "in a tracker"; rewrites these tables in docs/performance.md and README.md.

Usage: write_tracker_tables.py BENCH.json
"""

import math
import sys

from results import ROOT, Results, ratio, us
from tracker_results import (
    CACHES, KINDS, MONOCULAR, SIZES, STEREO, STEREO_MAP, find, isas, p99_by_median, times_dense, times_eigen,
    times_select,
)  # fmt: skip
from write_tables import replace_between, table

POINTS = [(n, k) for n in SIZES for k in (("50", "100", "200") if n == "465" else ("100",))]


def number(value, digits=2):
    return "–" if math.isnan(value) else f"{value:.{digits}f}"


def hot_and_cold(value):
    """HOT / COLD of what value(caches) says."""
    return " / ".join(value(caches) for caches in CACHES)


def frame_rows(results):
    for blocks, name in KINDS.items():
        for n, k in POINTS:
            row = lambda method, caches: find(results, method, blocks, n, caches, k)
            cell = lambda method: hot_and_cold(lambda caches: us(row(method, caches)))
            ratios = [number(times_eigen(results, blocks, n, caches, k)) for caches in CACHES]
            tail = hot_and_cold(lambda caches: number(p99_by_median(row("blocks_and_select", caches)), 1))
            yield [name, n, k, cell("append_blocks"), cell("lazy_greedy"), cell("blocks_and_select"),
                   cell("eigen_lazy_scan"), *ratios, tail]  # fmt: skip


def isa_rows(results, isa):
    for blocks, name in KINDS.items():
        for n in SIZES:
            row = lambda caches, of=None: find(results, "blocks_and_select", blocks, n, caches, isa=of)
            yield [name, n, hot_and_cold(lambda caches: us(row(caches, isa))),
                   hot_and_cold(lambda caches: number(ratio(row(caches, isa), row(caches)))),
                   *(number(times_eigen(results, blocks, n, caches, isa=isa)) for caches in CACHES)]  # fmt: skip


def stochastic_rows(results):
    for blocks, name in KINDS.items():
        for n in ("465", "2000"):
            eigen = lambda caches: find(results, "eigen_stochastic", blocks, n, caches)
            for isa in isas(results):
                ours = lambda caches: find(results, "stochastic_greedy", blocks, n, caches, isa=isa)
                yield [name, n, isa, hot_and_cold(lambda caches: us(ours(caches))),
                       hot_and_cold(lambda caches: us(eigen(caches))),
                       *(number(ratio(eigen(caches), ours(caches))) for caches in CACHES)]  # fmt: skip


def sparse_rows(results, method, n, slots):
    for blocks in (MONOCULAR, STEREO_MAP):
        for isa in isas(results):
            row = lambda caches, of: find(results, method, blocks, n, caches, isa=isa, slots=of)
            ratios = [number(times_dense(results, method, blocks, n, slots, caches, isa)) for caches in CACHES]
            times = [hot_and_cold(lambda caches: us(row(caches, of))) for of in (slots, n)]
            yield [KINDS[blocks], isa, *times, *ratios]


def active_rows(results):
    for n in ("800", "3000"):
        for isa in isas(results):
            for matched in ("1", "0.5", "0.2"):
                select = find(results, "lazy_greedy", STEREO_MAP, n, isa=isa)
                row = lambda batch: find(results, "active", STEREO_MAP, n, isa=isa, batch=batch, matched=matched)
                one, *batches = (row(batch) for batch in ("1", "8", "32"))
                if one is None:
                    continue
                cells = [n, isa, matched, us(select), us(one), number(times_select(results, n, matched, isa=isa)),
                         f"{one['proposals']:.0f}", f"{1e3 * one['median_us'] / one['proposals']:.0f}"]  # fmt: skip
                for row in batches:
                    cells += [us(row), f"{row['proposals']:.0f}", f"{row['log_det'] - one['log_det'] + 0.0:.4f}"]
                yield cells


def prior_rows(results):
    for isa in isas(results):
        for caches in CACHES:
            row = lambda prior: find(results, "lazy_greedy", STEREO, "465", caches, isa=isa, prior=prior)
            plain, motion = row(None), row("motion")
            if plain is None or motion is None:
                continue
            yield [isa, caches, us(plain), us(motion), f"{100 * (1 - 1 / ratio(plain, motion)):.0f} %",
                   f"{plain['evaluations']:.0f}", f"{motion['evaluations']:.0f}"]  # fmt: skip


def page(results):
    widest, *others = isas(results)
    eigen = ["× hot", "× cold"]
    sparse = ["ratio, hot", "ratio, cold"]
    batches = [f"{words}{batch}" for batch in ("8", "32") for words in ("µs, by ", "proposals, by ", "Δ log det, by ")]
    lines = [
        results.machine(),
        "",
        f"Median µs of single calls, hot / cold, {widest}. ×: Eigen's lazy select alone by our blocks and select;",
        "p99 / median: of these two together.",
        "",
        *table(["matches", "n", "k", "blocks µs", "select µs", "both µs", "Eigen lazy µs", *eigen, "p99 / median"],
               frame_rows(results)),  # fmt: skip
        "",
        "![how many times faster than Eigen's lazy select, over n](images/tracker.png)",
        "",
    ]
    for isa in others:
        lines += [
            f"The same with {isa}, k = 100; Eigen is compiled for this machine as above:",
            "",
            *table(["matches", "n", "both µs", f"{isa} / {widest}", *eigen], isa_rows(results, isa)),
            "",
        ]
    return lines + [
        "`stochastic_greedy` against Eigen's, ε = 0.1, k = 100, on blocks that are there:",
        "",
        *table(["matches", "n", "isa", "select µs", "Eigen stochastic µs", *eigen], stochastic_rows(results)),
        "",
        "A slot for every keypoint, 2005 of them, of which 377 have a match (`Matches::usable`), against these alone;",
        "blocks and select:",
        "",
        *table(["matches", "isa", "2005 slots µs", "377 alone µs", *sparse],
               sparse_rows(results, "blocks_and_select", "377", "2005")),  # fmt: skip
        "",
        "2000 candidates of which 1600 are excluded (`Options::excluded`), against the other 400 alone; select:",
        "",
        *table(["matches", "isa", "2000 stored µs", "400 alone µs", *sparse],
               sparse_rows(results, "lazy_greedy", "400", "2000")),  # fmt: skip
        "",
        "`ActiveSelection` until 100 are accepted, stereo with covariances, hot, in turns with `select` on the same",
        "store. matched: which share of the proposals; ns: a proposal, one by one; batches: by `next(indices, m)` and",
        "`answer`; Δ log det: of batches, against one by one (nats).",
        "",
        *table(["n", "isa", "matched", "select µs", "one by one µs", "ratio", "proposals", "ns", *batches],
               active_rows(results)),  # fmt: skip
        "",
        "What a motion prior saves: deviations of 0.05 m and 0.01 rad, against the default; stereo, n = 465, select:",
        "",
        *table(["isa", "caches", "default µs", "motion prior µs", "saved", "gains evaluated, default", "motion prior"],
               prior_rows(results)),  # fmt: skip
    ]


def readme_rows(results):
    for blocks in (STEREO_MAP, MONOCULAR):
        for caches in CACHES:
            row = lambda method: find(results, method, blocks, caches=caches)
            both = row("blocks_and_select")
            yield [KINDS[blocks], caches, us(row("append_blocks")), us(row("lazy_greedy")), us(both),
                   us(both, "p99_us"), us(row("eigen_lazy_scan")),
                   number(times_eigen(results, blocks, "465", caches), 1)]  # fmt: skip


def readme(results):
    return [
        "100 of 465 matches, KITTI-like frames, from points to indices; cold: after other work, to which caches and",
        "branch predictors are left ([docs/performance.md](docs/performance.md#in-a-tracker)). ×: the search alone,",
        "lazy greedy written with Eigen, by blocks and selection together.",
        "",
        *table(["matches", "caches", "blocks µs", "select µs", "both µs", "both, p99 µs", "Eigen lazy µs", "× lazy"],
               readme_rows(results)),  # fmt: skip
        "",
        results.machine(),
    ]


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    results = Results(sys.argv[1])
    if not any(row["kind"] == "tracker" for row in results.rows):
        print("nothing measured of what a tracker pays: its tables stay as they are")
        return
    lines = page(results)
    print("\n".join(lines))
    replace_between(ROOT / "docs/performance.md", "tracker", lines)
    replace_between(ROOT / "README.md", "tracker_latency", readme(results))


if __name__ == "__main__":
    main()
