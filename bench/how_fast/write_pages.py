#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Rewrites the tables of what was measured, in README.md, docs/performance.md, docs/threading.md and, which also needs
the record of profiles/run, in docs/maintenance.md.

Usage: write_pages.py BENCH.json
"""

import itertools
import math
import sys

from maxlogdet_tools.files import ROOT, json_of
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
        eigen, ours = (results.tracker(method, matches, n, "cold") for method in ("eigen_lazy_scan", "blocks_and_select"))
        rows.append([KINDS[matches], n, *against(eigen, ours)])
    return table(["matches", "n", "Eigen: selection alone, median, µs", "maxlogdet: blocks and selection, median, µs",
                  "Eigen ÷ maxlogdet (ratio)"], rows)  # fmt: skip


def tracker_latency(results):
    """The table of README.md."""
    rows = []
    for matches, caches in itertools.product(KINDS, CACHES):
        everything, align, *eigen = (results.tracker(method, matches, caches=caches) for method in
                                     ("good_features", "align", "eigen_align", "eigen_lazy_scan"))  # fmt: skip
        both = "–" if None in eigen else f"{sum(of_one['us'] for of_one in eigen):.1f}"
        rows.append([KINDS[matches], caches, us(everything), us(everything, "p99_us"), us(align), both])
    return [
        *paragraph(
            "The library aligns 465 matches of a simulated frame, of which 12 % are wrong, and selects 100. *Hot*",
            "calls follow other calls. Before a *cold* call, other work has filled the caches, as in a tracker. Plan with",
            "the cold rows ([details](docs/performance.md#alignment)). *Eigen* is the same alignment, and lazy greedy",
            "among all 465 matches, which we wrote with Eigen. Computing the Jacobians of the selection is in the times",
            "of maxlogdet, not in those of Eigen. Map covariances are given, and computing them is in neither.",
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
    *((ISAS[isa], {"isa": isa}) for isa in ("sse2", "avx2")),
    ("frame with nearly equal gains", {"family": "nearly_equal_gains"}),
    ("recorded frames, n about 300", {"family": "real_frames"}),
]


def settings(results):
    rows = []
    for label, where in POINTS:
        eigen = None if "isa" in where else results.grid("eigen_lazy_scan", **where)
        ours = results.grid("lazy_greedy", **where)
        if ours is not None:
            rows.append([label, *against(eigen, ours)])
    return table(["setting", "Eigen, median, µs", "maxlogdet, median, µs", "Eigen ÷ maxlogdet (ratio)"], rows)


def strategies(results):
    best = results.grid("lazy_greedy")
    rows = []
    for method, eigens, where in (("lazy_greedy", "eigen_lazy_scan", {}), ("greedy", "eigen_greedy", {}),
                                  *(("stochastic_greedy", "eigen_stochastic", {"epsilon": epsilon})
                                    for epsilon in ("0.1", "0.01"))):  # fmt: skip
        row = results.grid(method, **where)
        name = f"`{method}`" + "".join(f", ε = {epsilon}" for epsilon in where.values())
        rows.append([name, *against(results.grid(eigens, **where), row), lost(row, best)])
    return table(["strategy", "Eigen, median, µs", "maxlogdet, median, µs", "Eigen ÷ maxlogdet (ratio)",
                  "loss, mean, nats"], rows)  # fmt: skip


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


# docs/maintenance.md


def targets(results):
    isas = [results.widest, *(["avx2"] if results.widest == "avx512" else [])]
    rows = []

    def add(case, limit, values, bound):
        met = [value >= limit for value in values if not math.isnan(value)]
        verdict = "–" if not met else "yes" if all(met) else "no" if not any(met) else "in part"
        cells = ["–" if math.isnan(value) else f"{value:.3g}" for value in [*values, math.nan][:2]]
        rows.append([case, f"≥ {limit:g}", *cells, verdict, bound])

    for n, matches, caches, limit, bound in (
        ("465", STEREO, "hot", 4, "float64 before full rank, blocks and updates"),
        ("465", STEREO, "cold", 3, "the first touch of code and data"),
        ("465", MONOCULAR, "cold", 4, "the first touch of code and data"),
        ("2000", STEREO, "hot", 4.5, "rounds before full rank, where no bound helps"),
    ):
        eigen = results.tracker("eigen_lazy_scan", matches, n, caches)
        add(f"Eigen ÷ ours, {n} {KINDS[matches]}, {caches}", limit,
            [ratio(eigen, results.tracker("blocks_and_select", matches, n, caches, isa=isa)) for isa in isas], bound)  # fmt: skip
    eigen = results.grid("eigen_stochastic")
    add("Eigen ÷ `stochastic_greedy`, ε = 0.1", 2.5,
        [ratio(eigen, results.grid("stochastic_greedy", isa=isa)) for isa in isas],
        "draws and updates, which Eigen pays, too")  # fmt: skip
    [share] = [r["share_of_peak"] for r in json_of(ROOT / "profiles/roofline.json")["full_round"] if r["rows"] == 2]
    add("full round ÷ [peak of the core](profiles.md)", 0.8, [share],
        "multiplications that have nothing to add")  # fmt: skip
    names = [*(ISAS[isa] for isa in isas), "–"][:2]
    return table(["case (ratio)", "target", *names, "met", "what bounds it"], rows)


README, PERFORMANCE, THREADING, MAINTENANCE = (
    ROOT / page for page in ("README.md", "docs/performance.md", "docs/threading.md", "docs/maintenance.md"))  # fmt: skip
SECTIONS = {
    README: [tracker_latency],
    PERFORMANCE: [plan, frames, alignment, against_eigen, settings, strategies],
    THREADING: [crossover],
    MAINTENANCE: [targets],
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
