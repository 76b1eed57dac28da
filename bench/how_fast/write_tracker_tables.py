#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Prints the tables of tracker frames; rewrites them in docs/performance.md and README.md, and the record.

Usage: write_tracker_tables.py BENCH.json
"""

import math
import sys

from maxlogdet_tools.pages import paragraph, rewrite, table
from maxlogdet_tools.project import ROOT
from records import record_run, unless_on_page
from results import Results, ratio, us
from tracker_results import (
    CACHES, KINDS, MONOCULAR, STEREO, STEREO_MAP, find, isas, p99_by_median, times_eigen, times_select,
)  # fmt: skip

SHOWN = [(kind, n) for kind in (MONOCULAR, STEREO_MAP) for n in ("200", "465", "2000")]  # the record has all rows


def number(value, digits=2):
    return "–" if math.isnan(value) else f"{value:.{digits}f}"


def hot_and_cold(value):
    """HOT / COLD, where value(caches) is each of them."""
    return " / ".join(value(caches) for caches in CACHES)


def frame_rows(results):
    for blocks, n in SHOWN:
        row = lambda method, caches: find(results, method, blocks, n, caches)
        cell = lambda method: hot_and_cold(lambda caches: us(row(method, caches)))
        ratios = [hot_and_cold(lambda caches: number(times_eigen(results, blocks, n, caches, isa=isa)))
                  for isa in isas(results)]  # fmt: skip
        tail = hot_and_cold(lambda caches: number(p99_by_median(row("blocks_and_select", caches)), 1))
        yield [KINDS[blocks], n, cell("append_blocks"), cell("lazy_greedy"), cell("blocks_and_select"),
               cell("eigen_lazy_scan"), *ratios, tail]  # fmt: skip


def pair_row(results, label, first, second):
    """The time of the first row relative to the second on each instruction set; first(caches, isa) finds a row."""
    by = lambda isa: hot_and_cold(lambda caches: number(ratio(first(caches, isa), second(caches, isa))))
    return [*label, *(by(isa) for isa in isas(results))]


def pair_rows(results):
    for blocks in (MONOCULAR, STEREO_MAP):
        for n in ("465", "2000"):
            eigen = lambda caches, isa: find(results, "eigen_stochastic", blocks, n, caches)
            ours = lambda caches, isa: find(results, "stochastic_greedy", blocks, n, caches, isa=isa)
            yield pair_row(results, ["Eigen stochastic / ours", KINDS[blocks], n], eigen, ours)
    for blocks in (MONOCULAR, STEREO_MAP):
        of = lambda count: lambda caches, isa: find(results, "lazy_greedy", blocks, "400", caches, isa=isa, slots=count)
        label = ["2000, 1600 of them excluded / 400 alone, *select*", KINDS[blocks], "400"]
        yield pair_row(results, label, of("2000"), of("400"))
    plain, motion = (lambda caches, isa, p=p: find(results, "lazy_greedy", STEREO, "465", caches, isa=isa, prior=p)
                     for p in (None, "motion"))  # fmt: skip
    yield pair_row(results, ["default prior / motion prior, *select*", KINDS[STEREO], "465"], plain, motion)


def active_rows(results):
    for n in ("800", "3000"):
        for matched in ("1", "0.5", "0.2"):
            row = lambda batch: find(results, "active", STEREO_MAP, n, batch=batch, matched=matched)
            one, *batches = (row(batch) for batch in ("1", "8", "32"))
            if one is None:
                continue
            slower = " / ".join(number(times_select(results, n, matched, isa=isa)) for isa in isas(results))
            cells = [n, matched, slower, f"{one['proposals']:.0f}", f"{1e3 * one['median_us'] / one['proposals']:.0f}"]
            for batch, row in zip(("8", "32"), batches):
                delta = round(row["log_det"] - one["log_det"], 4) + 0.0  # no -0.0000
                cells += [number(times_select(results, n, matched, batch)), f"{delta:.4f}"]
            yield cells


def page(results):
    by_isa = " / ".join(isas(results))
    ratios = [f"×, {isa}" for isa in isas(results)]
    prior = [find(results, "lazy_greedy", STEREO, "465", prior=p) for p in (None, "motion")]
    gains = " / ".join("–" if row is None else f"{row['evaluations']:.0f}" for row in prior)
    return [
        *paragraph(
            f"Median µs, hot / cold, k = 100, {results.widest}; ×: Eigen's lazy select alone by our *both*, to which",
            "p99 / median belongs too.",
        ),
        "",
        *table(["matches", "n", "blocks", "select", "both", "Eigen lazy", *ratios, "p99 / median"],
               frame_rows(results)),
        "",
        "![how many times faster than Eigen's lazy select, over n](images/tracker.png)",
        "",
        *paragraph(
            "The time of A by that of B, hot / cold; motion prior: deviations of 0.05 m and 0.01 rad (gains evaluated:",
            f"{gains}). Slots without a match (`Matches::usable`) are in the table of targets.",
        ),
        "",
        *table(["A / B", "matches", "n", *isas(results)], pair_rows(results)),
        "",
        *paragraph(
            "`ActiveSelection` until 100 are accepted, stereo with covariances, hot; ×: its time by that of *select*;",
            "matched: the share of the proposals; by 8, by 32: batches, `next(indices, m)` and `answer`, with Δ log",
            f"det to one by one ({results.widest}).",
        ),
        "",
        *table(["n", "matched", f"one by one: ×, {by_isa}", "proposals", "ns each", "by 8: ×", "Δ", "by 32: ×", "Δ"],
               active_rows(results)),
    ]  # fmt: skip


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
        "100 of 465 matches, KITTI-like frames, from points to indices; cold: after other work has evicted caches and",
        "branch predictors ([docs/performance.md](docs/performance.md#in-a-tracker)). × lazy: the time of lazy greedy",
        "written with Eigen, its search alone, divided by that of our blocks and selection together.",
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
        print("no case of a tracker was measured: its tables stay unchanged")
        return
    performance = ROOT / "docs/performance.md"
    lines = [*page(results), *unless_on_page(performance, results.machine())]
    print("\n".join(lines))
    rewrite(performance, "tracker", lines)
    record_run(["tracker"], results.machine())
    rewrite(ROOT / "README.md", "tracker_latency", readme(results))
    results.record("tracker.csv", "tracker")


if __name__ == "__main__":
    main()
