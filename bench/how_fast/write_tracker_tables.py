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
from results import Results, printed_ratio, ratio, us
from tracker_results import (
    CACHES, KINDS, MONOCULAR, STEREO, STEREO_MAP, find, times_dense,
)  # fmt: skip

SHOWN = [STEREO_MAP, MONOCULAR]  # the record has all rows


def number(value, digits=2):
    return "–" if math.isnan(value) else f"{value:.{digits}f}"


def lost(row, best):
    """The loss: how much less log det this row has than the best, in nats."""
    return "–" if row is None or best is None else f"{round(best['log_det'] - row['log_det'], 3) + 0.0:.3f}"


def plan(results):
    """What to expect, for the first screen."""
    calls = {k: [find(results, "good_features", blocks, caches="cold", k=k) for blocks in (MONOCULAR, STEREO_MAP)]
             for k in ("100", "200")}  # fmt: skip
    times = lambda k, counter: [microseconds(row, counter) for row in calls[k]]
    median, percentile, median_of_200 = times("100", "median_us"), times("100", "p99_us"), times("200", "median_us")
    return paragraph(
        "**Keep the default strategy, `lazy_greedy`. To align 465 matches and to select 100 of them, plan for",
        f"{median[0]} µs per monocular frame and {median[1]} µs per stereo frame.** To select 200, plan for",
        f"{median_of_200[0]} µs (monocular) or {median_of_200[1]} µs (stereo). These are medians with cold caches.",
        "The covariances of the map points of stereo matches are given. When selecting 100 matches, one frame in a",
        f"hundred took longer than {percentile[0]} µs (monocular) or {percentile[1]} µs (stereo). At 30 frames a second, a",
        "tracker has 33 000 µs for a frame.",
    )


def microseconds(row, counter):
    return "–" if row is None else f"{row[counter]:.0f}"


def frames(results):
    """A frame of 465 matches."""
    rows, calls = [], {}
    for blocks, caches in itertools.product(SHOWN, CACHES):
        row = lambda method: find(results, method, blocks, caches=caches)
        measured = [row("append_blocks"), row("lazy_greedy"), row("blocks_and_select")]
        rows.append([KINDS[blocks], caches, *map(us, measured), us(measured[-1], "p99_us")])
        calls.setdefault(caches, []).extend(found["calls"] for found in measured if found is not None)
    least = {caches: f"{min(counts):.0f}" if counts else "–" for caches, counts in calls.items()}
    return [
        *table(["matches", "caches", "blocks, median, µs", "selection, median, µs", "both, median, µs",
                "both, 99th percentile, µs"], rows),
        "",
        *paragraph(f"Each hot median is of at least {least['hot']} calls, each cold median of at least",
                   f"{least['cold']}."),
    ]  # fmt: skip


def alignment(results):
    """All that GoodFeatures does, and how well it aligns."""
    rows, ratios = [], []
    for blocks, n in itertools.product(SHOWN, ("200", "465", "1000", "2000")):
        eigen, ours, everything = (find(results, method, blocks, n, "cold")
                                   for method in ("eigen_align", "align", "good_features"))
        ratios.append(ratio(eigen, ours))
        found = ["–", "–"] if ours is None else [f"{ours['inliers']:.0f} ({ours['wrong_percent']:.1f} %)",
                                                 number(ours["deviation_mm"], 1)]
        rows.append([f"{n}, {KINDS[blocks]}", us(eigen), us(ours), us(everything), *found])
    ratios = [value for value in ratios if not math.isnan(value)]
    return [
        *table(["matches", "Eigen: alignment, median, µs", "maxlogdet: alignment, median, µs",
                "maxlogdet: all, median, µs", "inliers (wrong among them)", "deviation from the true pose, mm"], rows),
        "",
        *paragraph(f"Eigen took {min(ratios):.1f} to {max(ratios):.1f} times as long." if ratios else "–"),
    ]  # fmt: skip


def against_eigen(results):
    rows = []
    for blocks, n in itertools.product(SHOWN, ("200", "465", "1000", "2000")):
        median = lambda method: us(find(results, method, blocks, n, "cold"))
        eigen, ours = median("eigen_lazy_scan"), median("blocks_and_select")
        rows.append([KINDS[blocks], n, eigen, ours, printed_ratio(eigen, ours)])
    return table(["matches", "n", "Eigen: selection alone, median, µs", "maxlogdet: blocks and selection, median, µs",
                  "Eigen ÷ maxlogdet (ratio)"], rows)  # fmt: skip


def sampling(results):
    rows = []
    for n in ("465", "2000"):
        lazy, stochastic = (find(results, method, STEREO_MAP, n) for method in ("lazy_greedy", "stochastic_greedy"))
        rows.append([n, us(lazy), us(stochastic), lost(stochastic, lazy)])
    return table(["n", "`lazy_greedy`, median, µs", "`stochastic_greedy`, median, µs", "loss, mean, nats"], rows)


def worst(values):
    return number(max(values, key=lambda value: -math.inf if math.isnan(value) else value))


def change(caches, results):
    """How a motion prior changes the time of a selection."""
    row = lambda prior: find(results, "lazy_greedy", STEREO, caches=caches, prior=prior)
    percent = 100 * (ratio(row("motion"), row(None)) - 1)
    return "–" if math.isnan(percent) else f"{abs(percent):.0f} % {'more' if percent > 0 else 'less'} time ({caches})"


def details(results):
    slots = worst([times_dense(results, "blocks_and_select", blocks, "377", "2005", caches)
                   for blocks, caches in itertools.product(SHOWN, CACHES)])  # fmt: skip
    return paragraph(
        "Pass only keypoints that have a map point. With 1628 other keypoints, marked as not usable, 377 matches took",
        f"up to {slots} times as long as alone. With a motion prior (standard deviations 5 cm and 0.01 rad),",
        f"`select` took {change('hot', results)} and {change('cold', results)} than without, on stereo frames without",
        "covariances.",
    )


def readme(results):
    rows = []
    for blocks, caches in itertools.product(SHOWN, CACHES):
        row = lambda method: find(results, method, blocks, caches=caches)
        everything = row("good_features")
        eigen = [row("eigen_align"), row("eigen_lazy_scan")]
        both = "–" if None in eigen else f"{sum(of_one['median_us'] for of_one in eigen):.1f}"
        rows.append([KINDS[blocks], caches, us(everything), us(everything, "p99_us"), us(row("align")), both])
    return [
        *paragraph(
            "The library aligns 465 matches of a simulated frame, of which 12 % are wrong, and selects 100. *Hot*",
            "calls follow other calls. Before a *cold* call, other work has filled the caches, as in a tracker. Plan",
            "with the cold rows ([details](docs/performance.md#alignment)). *Eigen* is the same alignment and the same",
            "selection, which we wrote with Eigen. Computing the Jacobians of the selection is in the times of maxlogdet,",
            "and not in those of Eigen. The covariances of map points are given, and computing them is in neither.",
        ),
        "",
        *table(["matches", "caches", "maxlogdet, median, µs", "maxlogdet, 99th percentile, µs",
                "of this the alignment, median, µs", "Eigen, median, µs"], rows),
    ]  # fmt: skip


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    results = Results(sys.argv[1])
    if not any(row["kind"] == "tracker" for row in results.rows):
        print("no case of a tracker was measured: its tables stay unchanged")
        return
    performance, front = ROOT / "docs/performance.md", ROOT / "README.md"
    for section in (plan, frames, alignment, against_eigen, sampling, details):
        lines = section(results)
        print("\n".join(lines))
        rewrite(performance, section.__name__, lines)
    rewrite(front, "tracker_latency", readme(results))
    for page in (performance, front):
        stamp(page, "how_fast --tracker")
    results.record("tracker.csv", "tracker")


if __name__ == "__main__":
    main()
