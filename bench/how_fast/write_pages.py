#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Rewrites the tables of what was measured: in README.md, docs/performance.md and docs/threading.md.

Usage: write_pages.py BENCH.json    write_targets.py writes the targets.
"""

import itertools
import math
import sys

from maxlogdet_tools.pages import paragraph, rewrite, table
from maxlogdet_tools.project import ROOT
from maxlogdet_tools.runs import stamp
from results import CACHES, ISAS, KINDS, MONOCULAR, STEREO, Results, lost, printed_ratio, ratio, times, us

SIZES = ["200", "465", "1000", "2000"]


# docs/performance.md, in a tracker


def plan(results):
    """What to expect, for the first screen."""
    row = lambda matches, k: results.tracker("good_features", matches, caches="cold", k=k)
    whole = lambda found, counter="us": "–" if found is None else f"{found[counter]:.0f}"
    mono, stereo = row(MONOCULAR, "100"), row(STEREO, "100")
    return paragraph(
        "**Keep the default strategy, `lazy_greedy`. To align 465 matches and to select 100 of them, plan for",
        f"{whole(mono)} µs per monocular frame and {whole(stereo)} µs per stereo frame.** To select 200, plan for",
        f"{whole(row(MONOCULAR, '200'))} µs (monocular) or {whole(row(STEREO, '200'))} µs (stereo). These are medians",
        "with cold caches, over blocks of calls, of the fastest call in each. The covariances of the map points of",
        "stereo matches are given. When selecting 100 matches, one frame in a hundred took longer than",
        f"{whole(mono, 'p99_us')} µs (monocular) or {whole(stereo, 'p99_us')} µs (stereo). At 30 frames a second, a",
        "tracker has 33 000 µs for a frame.",
    )


def frames(results):
    """A frame of 465 matches."""
    rows, calls = [], {}
    for matches, caches in itertools.product(KINDS, CACHES):
        found = [results.tracker(method, matches, caches=caches)
                 for method in ("append_blocks", "lazy_greedy", "blocks_and_select")]  # fmt: skip
        rows.append([KINDS[matches], caches, *map(us, found), us(found[-1], "p99_us")])
        calls.setdefault(caches, []).extend(row["calls"] for row in found if row is not None)
    least = {caches: f"{min(counts, default=math.nan):.0f}" for caches, counts in calls.items()}
    return [
        *table(["matches", "caches", "blocks, median, µs", "selection, median, µs", "both, median, µs",
                "both, 99th percentile, µs"], rows),
        "",
        *paragraph(f"Each hot median is of at least {least['hot']} calls, each cold median of at least",
                   f"{least['cold']}. They are taken over blocks of calls, from the fastest call in each."),
    ]  # fmt: skip


def alignment(results):
    """All that GoodFeatures does, and how well it aligns."""
    rows, ratios = [], []
    for matches, n in itertools.product(KINDS, SIZES):
        eigen, ours, everything = (results.tracker(method, matches, n, "cold")
                                   for method in ("eigen_align", "align", "good_features"))  # fmt: skip
        ratios.append(ratio(eigen, ours))
        found = ["–", "–"] if ours is None else [f"{ours['inliers']:.0f} ({ours['wrong_percent']:.1f} %)",
                                                 f"{ours['deviation_mm']:.1f}"]  # fmt: skip
        rows.append([f"{n}, {KINDS[matches]}", us(eigen), us(ours), us(everything), *found])
    return [
        *table(["matches", "Eigen: alignment, median, µs", "maxlogdet: alignment, median, µs",
                "maxlogdet: all, median, µs", "inliers (wrong among them)", "deviation from the true pose, mm"], rows),
        "",
        *paragraph(f"Eigen took {times(min(ratios))} to {times(max(ratios))} times as long."),
    ]  # fmt: skip


def against_eigen(results):
    rows = []
    for matches, n in itertools.product(KINDS, SIZES):
        eigen, ours = (us(results.tracker(method, matches, n, "cold")) for method in ("eigen_lazy_scan", "blocks_and_select"))
        rows.append([KINDS[matches], n, eigen, ours, printed_ratio(eigen, ours)])
    return table(["matches", "n", "Eigen: selection alone, median, µs", "maxlogdet: blocks and selection, median, µs",
                  "Eigen ÷ maxlogdet (ratio)"], rows)  # fmt: skip


def sampling(results):
    rows = []
    for n in ("465", "2000"):
        lazy, stochastic = (results.tracker(method, STEREO, n) for method in ("lazy_greedy", "stochastic_greedy"))
        rows.append([n, us(lazy), us(stochastic), lost(stochastic, lazy)])
    return table(["n", "`lazy_greedy`, median, µs", "`stochastic_greedy`, median, µs", "loss, mean, nats"], rows)


def tracker_latency(results):
    """The table of README.md."""
    rows = []
    for matches, caches in itertools.product(KINDS, CACHES):
        row = lambda method: results.tracker(method, matches, caches=caches)
        everything, eigen = row("good_features"), [row("eigen_align"), row("eigen_lazy_scan")]
        both = "–" if None in eigen else f"{sum(of_one['us'] for of_one in eigen):.1f}"
        rows.append([KINDS[matches], caches, us(everything), us(everything, "p99_us"), us(row("align")), both])
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


# docs/performance.md, the grid: the base point, then other values of one setting at a time

POINTS = [  # label, what differs from the base point
    ("the base case", {}),
    *((f"n = {n}", {"n": n}) for n in ("200", "20000")),
    ("k = 200", {"k": "200"}),
    ("blocks of three rows", {"blocks": "3_rows"}),
    ("weighting `measurement`", {"blocks": "2_rows_measurement"}),
    *((ISAS[isa], {"isa": isa}) for isa in ("sse2", "avx2")),
    ("frame with nearly equal gains", {"family": "nearly_equal_gains"}),
    ("recorded frames, n about 300", {"family": "real_frames"}),
]


def settings(results):
    rows = []
    for label, where in POINTS:
        ours = us(results.grid("lazy_greedy", **where))
        eigen = us(results.grid("eigen_lazy_scan", **where)) if "isa" not in where else "–"
        if ours != "–":
            rows.append([label, eigen, ours, printed_ratio(eigen, ours)])
    return table(["setting", "Eigen, median, µs", "maxlogdet, median, µs", "Eigen ÷ maxlogdet (ratio)"], rows)


def strategies(results):
    best = results.grid("lazy_greedy")
    rows = []
    for method, counterpart, epsilon in (("lazy_greedy", "eigen_lazy_scan", None), ("greedy", None, None),
                                         ("stochastic_greedy", "eigen_stochastic", "0.1"),
                                         ("stochastic_greedy", "eigen_stochastic", "0.01")):  # fmt: skip
        where = {"epsilon": epsilon} if epsilon else {}
        row = results.grid(method, **where)
        ours, eigen = us(row), us(results.grid(counterpart, **where)) if counterpart else "–"
        name = f"`{method}`" + (f", ε = {epsilon}" if epsilon else "")
        rows.append([name, eigen, ours, printed_ratio(eigen, ours), lost(row, best)])
    return table(["strategy", "Eigen, median, µs", "maxlogdet, median, µs", "Eigen ÷ maxlogdet (ratio)",
                  "loss, mean, nats"], rows)  # fmt: skip


# docs/threading.md

THREAD_METHODS = ["greedy", "lazy_greedy"]  # rounds of stochastic_greedy are too short for threads


def crossover(results):
    """The gain of several threads, and what the automatic choice costs."""
    found = [row for row in results.rows if row["kind"] == "threads"]
    several = max(int(row["threads"]) for row in found)
    find = lambda kind, method, n, threads: results.find(kind=kind, method=method, n=n, threads=str(threads))
    gain = lambda method, n: ratio(find("threads", method, n, 1), find("threads", method, n, several))
    costs = [ratio(find("choose", row["method"], row["n"], 0), row)
             for row in results.rows if row["kind"] == "choose" and row["threads"] == "1"]  # fmt: skip
    line = results.find(kind="line")
    trips = int(line["method"].split("_")[0])
    trip, fastest, slowest = (1e3 * time / trips for time in (line["us"], min(line["times"]), max(line["times"])))
    sizes = sorted({row["n"] for row in found}, key=int)
    return [
        *paragraph(f"The table has the time of one thread divided by the time of {several}, on EuRoC-like simulated",
                   "frames with k = 100 and blocks of two rows."),
        "",
        *table(["n", *(f"`{name}` (ratio)" for name in THREAD_METHODS)],
               ([n, *(times(gain(method, n)) for method in THREAD_METHODS)] for n in sizes)),
        "",
        *paragraph(f"The round trip of a cache line between the cores took {trip:.0f} ns ({fastest:.0f} to",
                   f"{slowest:.0f}). Up to 5000 candidates, `threads = 0` takes at most {max(costs):.2f} times as",
                   "long as `threads = 1`."),
    ]  # fmt: skip


PERFORMANCE, FRONT, THREADING = (ROOT / page for page in ("docs/performance.md", "README.md", "docs/threading.md"))
# By the kind of the cases: sections, each with its page, and how the stamp names the run.
SECTIONS = {
    "tracker": ([(plan, PERFORMANCE), (frames, PERFORMANCE), (alignment, PERFORMANCE), (against_eigen, PERFORMANCE),
                 (sampling, PERFORMANCE), (tracker_latency, FRONT)], "how_fast --tracker"),
    "grid": ([(settings, PERFORMANCE), (strategies, PERFORMANCE)], "how_fast"),
    "threads": ([(crossover, THREADING)], "how_fast --threads"),
}  # fmt: skip


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    results = Results(sys.argv[1])
    for kind, (sections, run) in SECTIONS.items():
        if not results.has(kind):
            continue
        for section, page in sections:
            lines = section(results)
            print("\n".join(lines))
            rewrite(page, section.__name__, lines)
        for page in dict.fromkeys(page for _, page in sections):
            stamp(page, run)


if __name__ == "__main__":
    main()
