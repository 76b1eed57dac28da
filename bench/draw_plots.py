#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Draws docs/images/{latency_over_n,latency_over_k,budget_epsilon,pareto,threads,tracker}.{svg,png} with gnuplot.

Usage: draw_plots.py BENCH.json FOLDER_FOR_SCRIPTS [--tracker]    --tracker: that one alone
"""

import math
import pathlib
import subprocess
import sys

import tracker_results
from results import EPSILONS, ROOT, STOCHASTIC, Results, label_of
from write_tables import BUDGETS, SIZES, THREADED_SIZES, speedup_of_threads

# Ours in full lines of saturated colours, Eigen's dashed and pale. Okabe and Ito's colours: told apart by all eyes.
STYLES = {
    "greedy": "lc rgb '#0072b2' dt 1 pt 5",
    "lazy_greedy": "lc rgb '#d55e00' dt 1 pt 7",
    "stochastic_greedy": "lc rgb '#009e73' dt 1 pt 9",
    "relaxed": "lc rgb '#cc79a7' dt 1 pt 11",
    "eigen_exact": "lc rgb '#56b4e9' dt 2 pt 4",
    "eigen_exact_batched": "lc rgb '#56b4e9' dt 3 pt 12",
    "eigen_lazy": "lc rgb '#e69f00' dt 2 pt 6",
    "eigen_lazy_scan": "lc rgb '#e69f00' dt 3 pt 8",
    "eigen_stochastic": "lc rgb '#66c2a5' dt 2 pt 10",
    "eigen_log_det": "lc rgb '#cc79a7' dt 2 pt 13",
}
SETTING = "EuRoC-like frame, 2 rows, one thread"


def draw(name, size, body, folder):
    for ending, terminal in (
        ("svg", "svg size {},{} dynamic noenhanced font 'sans-serif,14' background 'white'"),
        ("png", "pngcairo size {},{} noenhanced font 'sans-serif,11' background 'white'"),
    ):
        file = ROOT / "docs/images" / f"{name}.{ending}"
        script = f"set terminal {terminal.format(*size)}\nset output '{file}'\nset encoding utf8\n" + body
        path = pathlib.Path(folder) / f"{name}.{ending}.gp"
        path.write_text(script)
        subprocess.run(["gnuplot", str(path)], check=True)
    print(f"drew docs/images/{name}.svg and .png")


GRID = "lc rgb '#c0c0c0' lw 0.7, lc rgb '#e4e4e4' lw 0.7"
KEY = "set key outside right center reverse Left width -2 spacing 1.3"


def block(name, lines):
    return f"${name} << EOD\n" + "\n".join(lines or ["NaN NaN"]) + "\nEOD\n"


def lines_over(results, axis, values, title, log_x):
    body = ""
    curves = []
    for method, style in STYLES.items():
        found = [(value, results.find(method, **{axis: value})) for value in values]
        body += block(method, [f"{value} {row['median_us']}" for value, row in found if row is not None])
        label = label_of(method, "0.1" if method in STOCHASTIC else None)
        curves.append(f"${method} using 1:2 with linespoints lw 2 ps 1 {style} title '{label}'")
    ticks = ", ".join(f"'{value}' {value}" for value in values)
    low, high = int(values[0]), int(values[-1])
    return (
        body + f"set title '{title}'\nset logscale {'xy' if log_x else 'y'}\n"
        f"set xlabel '{'candidates n' if axis == 'n' else 'budget k'}'\nset ylabel 'median of one call (µs)'\n"
        f"set xtics ({ticks})\nset xrange [{low * 0.85 if log_x else 0}:{high * 1.18 if log_x else high + 10}]\n"
        f"set format y '%.0f'\nset grid xtics ytics mytics {GRID}\nset tics nomirror out\n{KEY}\nset border 3\nplot "
        + ", \\\n".join(curves) + "\n"
    )


def heat_map(results, counter, title, number_format):
    values = {(k, e): results.find("stochastic_greedy", k=k, epsilon=e) for k in BUDGETS for e in EPSILONS}
    lines = [
        f"{BUDGETS.index(k)} {EPSILONS.index(e)} {row[counter]} {row[counter]:{number_format}}"
        for (k, e), row in values.items()
        if row is not None
    ]
    name = counter
    budgets = ", ".join(f"'{k}' {i}" for i, k in enumerate(BUDGETS))
    epsilons = ", ".join(f"'{e}' {i}" for i, e in enumerate(EPSILONS))
    return block(name, lines) + (
        f"set title '{title}'\nset xlabel 'budget k'\nset ylabel 'ε'\nset xtics ({budgets}) scale 0\n"
        f"set ytics ({epsilons}) scale 0\n"
        f"set xrange [-0.5:{len(BUDGETS) - 0.5}]\nset yrange [-0.5:{len(EPSILONS) - 0.5}]\n"
        f"unset key\nunset colorbox\nplot ${name} using 1:2:3 with image, "
        f"${name} using 1:2:4 with labels font ',14'\n"
    )


def budget_epsilon(results):
    return (
        f"set multiplot layout 1,2 title 'stochastic_greedy, n = 2000; {SETTING}'\n"
        "set palette defined (0 '#f7fbff', 1 '#6baed6')\n"
        + heat_map(results, "median_us", "median of one call (µs)", ".1f")
        + "set palette defined (0 '#fc8d59', 1 '#fff7ec')\n"
        + heat_map(results, "delta_nats", "mean Δ log det to exact greedy (nats)", ".3f")
        + "unset multiplot\n"
    )


def pareto(results):
    # Exact methods lie on the line of no loss, so the axis of losses is linear; labels would overlap there: a key.
    body = ""
    curves = []
    latencies, losses = [], [0.1]
    for method, style in STYLES.items():
        epsilons = EPSILONS if method in STOCHASTIC else [None]
        found = [(e, results.find(method, **({"epsilon": e} if e else {}))) for e in epsilons]
        lines = [f"{r['median_us']} {-r['delta_nats'] + 0.0:.6f} {f'ε={e}' if e else ''}" for e, r in found if r]
        body += block(method, lines)
        latencies += [r["median_us"] for _, r in found if r]
        losses += [-r["delta_nats"] for _, r in found if r]
        kind = "linespoints" if method in STOCHASTIC else "points"
        curves.append(f"${method} using 1:2 with {kind} lw 2 ps 1.6 {style} title '{label_of(method)}'")
        if method in ("stochastic_greedy", "eigen_log_det"):
            curves.append(f"${method} using 1:2:3 with labels left offset 1,0.6 font ',10' notitle")
    return (
        body + f"set title 'loss against latency, n = 2000, k = 100; {SETTING}'\nset logscale x\n"
        "set xlabel 'median of one call (µs)'\nset ylabel 'mean loss of log det to exact greedy (nats)'\n"
        f"set yrange [-0.05:{1.15 * max(losses):.2f}]\nset xrange [{0.7 * min(latencies)}:{1.4 * max(latencies)}]\n"
        f"set format x '%.0f'\nset grid xtics ytics mxtics {GRID}\nset tics nomirror out\n{KEY}\nset border 3\nplot "
        + ", \\\n".join(curves) + "\n"
    )


def threads_over_n(results):
    threads = results.max_threads()
    body, curves = "", []
    for method, style in STYLES.items():
        points = [(n, speedup_of_threads(results, method, n, threads)) for n in THREADED_SIZES]
        points = [(n, value) for n, value in points if not math.isnan(value)]
        if not points:
            continue
        body += block(method, [f"{n} {value}" for n, value in points])
        curves.append(f"${method} using 1:2 with linespoints lw 2 ps 1 {style} title '{label_of(method)}'")
    ticks = ", ".join(f"'{n}' {n}" for n in THREADED_SIZES)
    return (
        body + f"set title '{threads} threads against one, k = 100; EuRoC-like frame, 2 rows'\nset logscale x\n"
        f"set xlabel 'candidates n'\nset ylabel 'times faster'\nset xtics ({ticks})\nset xrange [1700:120000]\n"
        f"set yrange [0:{threads + 0.5}]\n"
        f"set grid ytics {GRID}\nset tics nomirror out\n{KEY}\nset border 3\nplot 1 lc rgb '#808080' notitle, "
        + ", \\\n".join(curves) + "\n"
    )


def tracker(results):
    body, curves, sizes, highest = "", [], tracker_results.SIZES, 1
    for (blocks, name), colour in zip(tracker_results.KINDS.items(), ("#0072b2", "#009e73", "#d55e00")):
        for caches, style in (("hot", "dt 1 pt 7"), ("cold", "dt 2 pt 6")):
            points = [(n, tracker_results.times_eigen(results, blocks, n, caches)) for n in sizes]
            points = [(n, value) for n, value in points if not math.isnan(value)]
            highest = max([highest, *(value for _, value in points)])
            body += block(f"{caches}_{blocks}", [f"{n} {value}" for n, value in points])
            curves.append(f"${caches}_{blocks} using 1:2 with linespoints lw 2 ps 1 lc rgb '{colour}' {style} "
                          f"title '{name}, {caches}'")  # fmt: skip
    ticks = ", ".join(f"'{n}' {n}" for n in sizes if n != "465")
    return (
        body + "set title 'times faster than the lazy select in Eigen, blocks included; KITTI-like frames, k = 100'\n"
        f"set logscale x\nset xlabel 'matches n'\nset ylabel 'times faster'\nset xtics ({ticks})\n"
        f"set xrange [180:2200]\nset yrange [0:{1.1 * highest:.1f}]\nset grid ytics {GRID}\nset tics nomirror out\n"
        f"{KEY}\nset border 3\nplot 1 lc rgb '#808080' notitle, " + ", \\\n".join(curves) + "\n"
    )


def main():
    if len(sys.argv) not in (3, 4) or sys.argv[3:] not in ([], ["--tracker"]):
        sys.exit(__doc__)
    results, folder = Results(sys.argv[1]), sys.argv[2]
    if any(row["kind"] == "tracker" for row in results.rows):
        draw("tracker", (1000, 420), tracker(results), folder)
    if sys.argv[3:]:
        return
    over_n = lines_over(results, "n", SIZES, f"latency over n, k = 100; {SETTING}", True)
    draw("latency_over_n", (1000, 560), over_n, folder)
    over_k = lines_over(results, "k", BUDGETS, f"latency over k, n = 2000; {SETTING}", False)
    draw("latency_over_k", (1000, 560), over_k, folder)
    draw("budget_epsilon", (1000, 420), budget_epsilon(results), folder)
    if results.max_threads() > 1:
        draw("threads", (1000, 420), threads_over_n(results), folder)
    draw("pareto", (1000, 560), pareto(results), folder)


main()
