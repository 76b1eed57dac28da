#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Rewrites the tables of what was measured, in README.md, docs/performance.md and docs/threading.md.

Usage: write_pages.py BENCH.json
"""

import itertools
import math
import sys

from maxlogdet_tools.files import ROOT
from maxlogdet_tools.pages import paragraph, rewrite, stamp, table
from results import CACHES, ISAS, KINDS, MONOCULAR, STEREO, Results, against, lost, ratio, times, us

SIZES = ["200", "465", "1000", "2000"]


# docs/performance.md, in a tracker


def plan(results):
    """What to expect, for the first screen."""
    row = lambda matches, k="100": results.tracker("good_features", matches, caches="cold", k=k)
    whole = lambda found, counter="us": "–" if found is None else f"{found[counter]:.0f}"
    mono, stereo = row(MONOCULAR), row(STEREO)
    return paragraph(
        "**Keep the default strategy, `lazy_greedy`. To align 465 matches and select 100, plan for",
        f"{whole(mono)} µs per monocular frame and {whole(stereo)} µs per stereo frame**, cold, or",
        f"{whole(row(MONOCULAR, '200'))} and {whole(row(STEREO, '200'))} µs to select 200. When selecting 100, one",
        f"frame in a hundred took longer than {whole(mono, 'p99_us')} and {whole(stereo, 'p99_us')} µs.",
    )


def frames(results):
    """A frame of 465 matches."""
    rows, calls = [], []
    for matches, caches in itertools.product(KINDS, CACHES):
        found = [results.tracker(method, matches, caches=caches)
                 for method in ("align", "append_blocks", "lazy_greedy", "good_features")]  # fmt: skip
        rows.append([f"{KINDS[matches]}, {caches}", *map(us, found), us(found[-1], "p99_us")])
        calls += [row["calls"] for row in found if row is not None]
    return [
        *table(["matches, caches", "alignment, µs", "blocks, µs", "selection, µs", "all, µs",
                "all, 99th percentile, µs"], rows),
        "",
        f"Each row is of at least {min(calls, default=math.nan):.0f} calls.",
    ]  # fmt: skip


def alignment(results):
    """How well GoodFeatures aligns, and how its time grows."""
    quality = lambda row, text: "–" if row is None else text.format(**row)
    cold = lambda method, matches, n="465": results.tracker(method, matches, n, "cold")
    ratios = lambda eigens, ours: [ratio(cold(eigens, matches, n), cold(ours, matches, n))
                                   for matches, n in itertools.product(KINDS, SIZES)]  # fmt: skip
    aligned, selected = ratios("eigen_align", "align"), ratios("eigen_lazy_scan", "blocks_and_select")
    everything = {n: [us(cold("good_features", matches, n)) for matches in (STEREO, MONOCULAR)] for n in SIZES}
    few, many = SIZES[0], SIZES[-1]
    return paragraph(
        quality(cold("align", STEREO), "Of 465 stereo matches {inliers:.0f} were inliers, {wrong_percent:.1f} % of "
                "them wrong, and the pose was {deviation_mm:.1f} mm from the true one;"),
        quality(cold("align", MONOCULAR), "of 465 monocular matches {inliers:.0f}, {wrong_percent:.1f} % and "
                "{deviation_mm:.1f} mm."),
        f"Cold, *all* took {everything[few][0]} µs (stereo) or {everything[few][1]} µs (monocular) with {few} matches,",
        f"and {everything[many][0]} µs or {everything[many][1]} µs with {many}. From {few} to {many} matches, Eigen's",
        f"alignment took {times(min(aligned))} to {times(max(aligned))} times as long as ours, and its selection",
        f"{times(min(selected))} to {times(max(selected))} times as long as our blocks and selection.",
    )  # fmt: skip


def tracker_latency(results):
    """The table of README.md."""
    rows = []
    for matches, label in KINDS.items():
        everything, align, *eigen = (results.tracker(method, matches, caches="cold") for method in
                                     ("good_features", "align", "eigen_align", "eigen_lazy_scan"))  # fmt: skip
        both = "–" if None in eigen else f"{sum(of_one['us'] for of_one in eigen):.1f}"
        rows.append([label, us(align), us(everything), both])
    return [
        *paragraph(
            "From 465 matches of a simulated frame, 12 % of them wrong, the library computes inliers and pose, and selects",
            "100. Before each call other work has filled the caches, as in a tracker ([warm caches, slowest",
            "frames](docs/performance.md#a-trackers-frame)). *Eigen* is the same alignment and lazy greedy among all 465",
            "matches, written by us. It is given the selection's Jacobians, which maxlogdet computes.",
        ),
        "",
        *table(["matches", "inliers and pose, median, µs", "all, median, µs", "Eigen: all, median, µs"], rows),
    ]  # fmt: skip


# docs/performance.md, the grid: the base point, then other strategies, and other values of one setting at a time

EIGENS = {"lazy_greedy": "eigen_lazy_scan", "stochastic_greedy": "eigen_stochastic"}  # of greedy there is none
POINTS = [  # label, strategy, what differs from the base point
    ("the base case", "lazy_greedy", {}),
    ("`greedy`", "greedy", {}),
    *((f"`stochastic_greedy`, ε = {e}", "stochastic_greedy", {"epsilon": e}) for e in ("0.1", "0.01")),
    *((f"n = {n}", "lazy_greedy", {"n": n}) for n in ("200", "20000")),
    ("k = 200", "lazy_greedy", {"k": "200"}),
    ("three rows", "lazy_greedy", {"blocks": "3_rows"}),
    *((ISAS[isa], "lazy_greedy", {"isa": isa}) for isa in ("sse2", "avx2")),
    ("nearly equal gains", "lazy_greedy", {"family": "nearly_equal_gains"}),
    ("recorded frames, n about 300", "lazy_greedy", {"family": "real_frames"}),
]


def grid(results):
    rows = []
    for label, method, where in POINTS:
        ours = results.grid(method, **where)
        if ours is None:
            continue
        eigen = results.grid(EIGENS[method], **where) if method in EIGENS and "isa" not in where else None
        best = results.grid("lazy_greedy", **{name: value for name, value in where.items() if name != "epsilon"})
        rows.append([label, *against(eigen, ours)[1:], lost(ours, best)])
    return [
        *paragraph("In the base case, `lazy_greedy` selects 100 of 2000 candidates of two rows in one EuRoC-like",
                   "frame."),
        "",
        *table(["case", "time, µs", "Eigen ÷ ours (ratio)", "loss, mean, nats"], rows),
    ]


# docs/threading.md


def crossover(results):
    """The gain of several threads, and what the automatic choice costs."""
    found = [row for row in results.rows if row["kind"] == "threads"]
    several = max((row["threads"] for row in found), key=int)
    gain = lambda method, n: ratio(*(results.find(kind="threads", method=method, n=n, threads=threads)
                                     for threads in ("1", several)))  # fmt: skip
    costs = [ratio(results.find(kind="choose", method=row["method"], n=row["n"], threads="0"), row)
             for row in results.rows if row["kind"] == "choose" and row["threads"] == "1"]  # fmt: skip
    methods = ["greedy", "lazy_greedy"]  # rounds of stochastic_greedy are too short for threads
    return [
        *paragraph(f"The table has the time of one thread divided by the time of {several}, on EuRoC-like simulated",
                   "frames with k = 100 and blocks of two rows."),
        "",
        *table(["n", *(f"`{name}` (ratio)" for name in methods)],
               ([n, *(times(gain(method, n)) for method in methods)] for n in sorted({row["n"] for row in found}, key=int))),
        "",
        *paragraph(f"Up to 5000 candidates, `threads = 0` takes at most {max(costs):.2f} times as long as one thread."),
    ]  # fmt: skip


# docs/performance.md, the targets


def targets(results):
    isas = [results.widest, *(["avx2"] if results.widest == "avx512" else [])]
    rows = []

    def add(case, limit, values, bound):
        met = [value >= limit for value in values if not math.isnan(value)]
        verdict = "–" if not met else "yes" if all(met) else "no" if not any(met) else "in part"
        cells = ["–" if math.isnan(value) else f"{value:.3g}" for value in [*values, math.nan][:2]]
        rows.append([case, f"≥ {limit:g}", *cells, verdict, bound])

    for n, matches, caches, limit, bound in (
        ("465", STEREO, "hot", 4, "float64 before full rank, blocks, updates"),
        ("465", STEREO, "cold", 3, "first touch of code and data"),
        ("465", MONOCULAR, "cold", 4, "first touch of code and data"),
        ("2000", STEREO, "hot", 4.5, "rounds before full rank, where no bound helps"),
    ):
        eigen = results.tracker("eigen_lazy_scan", matches, n, caches)
        add(f"{n} {KINDS[matches]}, {caches}", limit,
            [ratio(eigen, results.tracker("blocks_and_select", matches, n, caches, isa=isa)) for isa in isas], bound)  # fmt: skip
    eigen = results.grid("eigen_stochastic")
    add("`stochastic_greedy`, ε = 0.1", 2.5,
        [ratio(eigen, results.grid("stochastic_greedy", isa=isa)) for isa in isas],
        "draws and updates, which Eigen pays, too")  # fmt: skip
    names = [*(ISAS[isa] for isa in isas), "–"][:2]
    return table(["Eigen ÷ ours (ratio)", "target", *names, "met", "what bounds it"], rows)


README, PERFORMANCE, THREADING = (ROOT / page for page in ("README.md", "docs/performance.md", "docs/threading.md"))
SECTIONS = {
    README: [tracker_latency],
    PERFORMANCE: [plan, frames, alignment, grid, targets],
    THREADING: [crossover],
}


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    results = Results(sys.argv[1])
    for page, sections in SECTIONS.items():
        for section in sections:
            lines = section(results)
            print("\n".join(lines))
            rewrite(page, section.__name__, lines)
        stamp(page, "how_fast")


if __name__ == "__main__":
    main()
