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
from results import ISAS, KINDS, MONOCULAR, STEREO, Results, against, lost, ratio, times, us

SIZES = ["200", "465", "1000", "2000"]


# docs/performance.md, in a tracker


def plan(results):
    """What to expect, for the first screen."""
    row = lambda matches, k="100": results.tracker("good_features", matches, caches="cold", k=k)
    whole = lambda found: "–" if found is None else f"{found['us']:.0f}"
    return paragraph(
        "**Keep the default strategy, `lazy_greedy`. To align 465 matches and select 100, plan for",
        f"{whole(row(MONOCULAR))} µs per monocular frame and {whole(row(STEREO))} µs per stereo frame**, cold, or",
        f"{whole(row(MONOCULAR, '200'))} and {whole(row(STEREO, '200'))} µs to select 200.",
    )


def frames(results):
    """A frame of 465 matches."""
    rows = []
    for matches in KINDS:
        found = [results.tracker(method, matches, caches="cold")
                 for method in ("align", "append_blocks", "lazy_greedy", "good_features")]  # fmt: skip
        rows.append([KINDS[matches], *map(us, found), us(found[-1], "p99_us")])
    return table(["median, µs, cold", "alignment", "blocks", "selection", "all", "all, 99th percentile"], rows)


def alignment(results):
    """How well GoodFeatures aligns, and how its time grows."""
    quality = lambda row, text: "–" if row is None else text.format(**row)
    cold = lambda method, matches, n="465": results.tracker(method, matches, n, "cold")
    aligned = [ratio(cold("eigen_align", matches, n), cold("align", matches, n))
               for matches, n in itertools.product(KINDS, SIZES)]  # fmt: skip
    few, many = SIZES[0], SIZES[-1]
    stereo, mono = (us(cold("good_features", matches, many)) for matches in (STEREO, MONOCULAR))
    return paragraph(
        quality(cold("align", STEREO), "Of 465 stereo matches {inliers:.0f} were inliers, {wrong_percent:.1f} % of "
                "them wrong, and the pose was {deviation_mm:.1f} mm from the true one;"),
        quality(cold("align", MONOCULAR), "of 465 monocular matches {inliers:.0f}, {wrong_percent:.1f} % and "
                "{deviation_mm:.1f} mm."),
        f"Cold, *all* took {stereo} µs (stereo) or {mono} µs (monocular) with {many} matches. From {few} to",
        f"{many} matches, Eigen's alignment took {times(min(aligned))} to {times(max(aligned))} times as long as ours.",
    )  # fmt: skip


def tracker_latency(results):
    """The table of README.md."""
    rows = []
    for matches, label in KINDS.items():
        everything, align, *eigen = (results.tracker(method, matches, caches="cold") for method in
                                     ("good_features", "align", "eigen_align", "eigen_lazy_scan"))  # fmt: skip
        both = "–" if None in eigen else f"{sum(of_one['us'] for of_one in eigen):.1f}"
        rows.append([label, us(results.tracker("align", matches)), us(align), us(everything), both])
    return [
        *paragraph(
            "From 465 matches of a simulated frame, 12 % of them wrong, the library computes inliers and pose, and selects",
            "100. Times are medians in µs. Before *cold* calls, other work has filled the caches, as in a tracker; *warm* ones",
            "follow each other ([slowest frames](docs/performance.md#a-trackers-frame)). *Eigen* is the same alignment and",
            "lazy greedy among all 465 matches, written by us. It is given the selection's Jacobians, which maxlogdet computes.",
        ),
        "",
        *table(["matches", "inliers and pose, warm", "inliers and pose, cold", "all, cold", "Eigen: all, cold"], rows),
    ]  # fmt: skip


# docs/performance.md, the grid: the base point, then other strategies, and other values of one setting at a time

EIGENS = {"lazy_greedy": "eigen_lazy_scan", "stochastic_greedy": "eigen_stochastic"}  # of greedy there is none
POINTS = [  # label, strategy, what differs from the base point
    ("the base case", "lazy_greedy", {}),
    ("`greedy`", "greedy", {}),
    ("`stochastic_greedy`, ε = 0.1", "stochastic_greedy", {"epsilon": "0.1"}),
    ("n = 20000", "lazy_greedy", {"n": "20000"}),
    ("three rows", "lazy_greedy", {"blocks": "3_rows"}),
    (ISAS["avx2"], "lazy_greedy", {"isa": "avx2"}),
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
        if "epsilon" in where:
            label += f", loses {lost(ours, results.grid('lazy_greedy'))} nats"
        rows.append([label, *against(eigen, ours)[1:]])
    return [
        *paragraph("In the base case, `lazy_greedy` selects 100 of 2000 finished EuRoC-like blocks, hot. Each case changes",
                   "one setting."),
        "",
        *table(["case", "time, µs", "Eigen ÷ ours"], rows),
    ]


# docs/threading.md


def crossover(results):
    """The gain of several threads."""
    found = [row for row in results.rows if row["kind"] == "threads"]
    several = max((row["threads"] for row in found), key=int)
    sizes = sorted({row["n"] for row in found}, key=int)
    gain = lambda method, n: ratio(*(results.find(kind="threads", method=method, n=n, threads=threads)
                                     for threads in ("1", several)))  # fmt: skip
    methods = ["greedy", "lazy_greedy"]  # rounds of stochastic_greedy are too short for threads
    return [
        f"Time of one thread divided by that of {several}, in EuRoC-like frames with k = 100:",
        "",
        *table(["n", *(f"`{name}`" for name in methods)],
               ([n, *(times(gain(method, n)) for method in methods)] for n in sizes)),
    ]  # fmt: skip


# docs/performance.md, the targets


def targets(results):
    isas = [results.widest, *(["avx2"] if results.widest == "avx512" else [])]
    rows = []

    def add(case, limit, values, bound):
        cells = ["–" if math.isnan(value) else f"{value:.3g}" for value in [*values, math.nan][:2]]
        rows.append([case, f"≥ {limit:g}", *cells, bound])

    for n, matches, caches, limit, bound in (
        ("465", STEREO, "hot", 4, "float64 before full rank, blocks, updates"),
        ("465", STEREO, "cold", 3, "first touch of code and data"),
        ("465", MONOCULAR, "cold", 4, "first touch of code and data"),
        ("2000", STEREO, "hot", 4.5, "rounds before full rank, where no bound helps"),
    ):
        eigen = results.tracker("eigen_lazy_scan", matches, n, caches)
        add(f"{n} {'stereo' if matches == STEREO else 'monocular'}, {caches}", limit,
            [ratio(eigen, results.tracker("blocks_and_select", matches, n, caches, isa=isa)) for isa in isas], bound)  # fmt: skip
    eigen = results.grid("eigen_stochastic")
    add("the base case, `stochastic_greedy`", 2.5,
        [ratio(eigen, results.grid("stochastic_greedy", isa=isa)) for isa in isas],
        "draws and updates, which Eigen pays, too")  # fmt: skip
    names = [*(ISAS[isa] for isa in isas), "–"][:2]
    return table(["Eigen ÷ ours", "target", *names, "what bounds it"], rows)


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
