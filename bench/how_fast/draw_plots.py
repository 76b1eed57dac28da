#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Draws docs/images/{latency_over_n,tracker}.{svg,png}.

Usage: draw_plots.py BENCH.json [--tracker]    --tracker: only that one
"""

import math
import sys

import tracker_results
from maxlogdet_tools.gnuplot import Colour, Picture, data_block, draw_both
from maxlogdet_tools.project import ROOT
from results import SIZES, STOCHASTIC, Results, label_of

# Our strategies have full lines of saturated colours, Eigen's dashed lines of pale ones.
STYLES = {
    "greedy": (Colour.BLUE, "dt 1 pt 5"),
    "lazy_greedy": (Colour.VERMILION, "dt 1 pt 7"),
    "stochastic_greedy": (Colour.GREEN, "dt 1 pt 9"),
    "eigen_exact": (Colour.SKY_BLUE, "dt 2 pt 4"),
    "eigen_exact_batched": (Colour.SKY_BLUE, "dt 3 pt 12"),
    "eigen_lazy": (Colour.ORANGE, "dt 2 pt 6"),
    "eigen_lazy_scan": (Colour.ORANGE, "dt 3 pt 8"),
    "eigen_stochastic": ("#66c2a5", "dt 2 pt 10"),
    "eigen_log_det": (Colour.PURPLE, "dt 2 pt 13"),
}
GRID = "lc rgb '#c0c0c0' lw 0.7, lc rgb '#e4e4e4' lw 0.7"
KEY = "set key outside right center reverse Left width -2 spacing 1.3"


def style_of(method):
    colour, line = STYLES[method]
    return f"lc rgb '{colour}' {line}"


def curve(block, style, title):
    return f"${block} using 1:2 with linespoints lw 2 ps 1 {style} title '{title}'"


def tics(values):
    return "set xtics (" + ", ".join(f"'{value}' {value}" for value in values) + ")\n"


def plot(*curves):
    return "plot " + ", \\\n".join(curves) + "\n"


def latency_over_n(results):
    blocks, curves = "", []
    for method in STYLES:
        found = [(n, results.find(method, n=n)) for n in SIZES]
        blocks += data_block(method, [(n, row["median_us"]) for n, row in found if row is not None])
        curves.append(curve(method, style_of(method), label_of(method, "0.1" if method in STOCHASTIC else None)))
    return Picture(1000, 560, (
        f"set encoding utf8\n{blocks}set title 'latency over n, k = 100; EuRoC-like frame, 2 rows, one thread'\n"
        "set logscale xy\nset xlabel 'candidates n'\nset ylabel 'median of one call (µs)'\n"
        f"{tics(SIZES)}set xrange [{int(SIZES[0]) * 0.85}:{int(SIZES[-1]) * 1.18}]\n"
        f"set format y '%.0f'\nset grid xtics ytics mytics {GRID}\nset tics nomirror out\n{KEY}\nset border 3\n"
        + plot(*curves)
    ))


def tracker(results):
    blocks, curves, sizes, highest = "", [], tracker_results.SIZES, 1
    for (kind, name), colour in zip(tracker_results.KINDS.items(), (Colour.BLUE, Colour.GREEN, Colour.VERMILION)):
        for caches, line in (("hot", "dt 1 pt 7"), ("cold", "dt 2 pt 6")):
            points = [(n, tracker_results.times_eigen(results, kind, n, caches)) for n in sizes]
            points = [(n, value) for n, value in points if not math.isnan(value)]
            highest = max([highest, *(value for _, value in points)])
            blocks += data_block(f"{caches}_{kind}", points)
            curves.append(curve(f"{caches}_{kind}", f"lc rgb '{colour}' {line}", f"{name}, {caches}"))
    title = "time of lazy greedy in Eigen ÷ time of maxlogdet with its blocks; KITTI-like frames, k = 100"
    return Picture(1000, 420, (
        f"set encoding utf8\n{blocks}set title '{title}'\nset logscale x\nset ylabel 'Eigen ÷ maxlogdet (ratio)'\n"
        f"set xlabel 'matches n'\n{tics(n for n in sizes if n != '465')}set xrange [180:2200]\n"
        f"set yrange [0:{1.1 * highest:.1f}]\nset grid ytics {GRID}\nset tics nomirror out\n{KEY}\nset border 3\n"
        + plot("1 lc rgb '#808080' notitle", *curves)
    ))


def main():
    if len(sys.argv) not in (2, 3) or sys.argv[2:] not in ([], ["--tracker"]):
        sys.exit(__doc__)
    results = Results(sys.argv[1])
    pictures = {}
    if any(row["kind"] == "tracker" for row in results.rows):
        pictures["tracker"] = tracker(results)
    if not sys.argv[2:]:
        pictures["latency_over_n"] = latency_over_n(results)
    for name, picture in pictures.items():
        draw_both(picture, ROOT / "docs/images" / name)


if __name__ == "__main__":
    main()
