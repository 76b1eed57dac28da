#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Prints the table of all cases; rewrites the tables of strategies, settings and threads in docs/, and their records.

Usage: write_tables.py BENCH.json [--threads]    --threads: only those of docs/threading.md
write_tracker_tables.py writes the tables of tracker frames, write_targets.py the targets.
"""

import sys

import thread_results
from maxlogdet_tools.pages import paragraph, rewrite, table
from maxlogdet_tools.project import ROOT
from maxlogdet_tools.runs import stamp
from results import EIGEN, EPSILONS, ISAS, STRATEGIES, Results, fastest, lost, printed_ratio, ratio, times, us

PERFORMANCE = ROOT / "docs/performance.md"
THREADING = ROOT / "docs/threading.md"
# Our strategies, and the variants of the same search with Eigen.
COUNTERPARTS = {"greedy": ["eigen_exact", "eigen_exact_batched"], "lazy_greedy": ["eigen_lazy", "eigen_lazy_scan"],
                "stochastic_greedy": ["eigen_stochastic"]}  # fmt: skip


# The table of all cases, for the terminal.


def print_all(results):
    header = ["case", "median", "p99", "max us", "lost nats", "evaluations", *(f"x {EIGEN[m][6:]}" for m in EIGEN)]
    lines = []
    order = {method: i for i, method in enumerate([*STRATEGIES, *EIGEN])}
    key = lambda r: (r["kind"], r.get("family", ""), r.get("blocks", ""), r.get("isa", ""), number(r.get("k")),
                     number(r.get("n")), order.get(r["method"], 0), r.get("epsilon", ""), r["name"])  # fmt: skip
    for row in sorted(results.rows, key=key):
        case = "/".join(p for p in row["name"].split("/") if p not in ("manual_time", "iterations:1", "repeats:1"))
        cells = [case, us(row), us(row, "p99_us"), us(row, "max_us")]
        if "delta_nats" in row:
            cells += [lost(row), f"{row['evaluations']:.0f}"]
        if row["method"] in STRATEGIES and row["kind"] == "select":
            cells += [times(ratio(results.baseline(m, row), row)) for m in EIGEN]
        lines.append(cells)
    width = max(len(cells[0]) for cells in lines)
    for cells in [header, *lines]:
        print(f"{cells[0]:<{width}}", *(f"{cell:>11}" if i < 5 else f"{cell:>17}" for i, cell in enumerate(cells[1:])))
    print()


def number(text):
    return int(text) if text and text.isdigit() else 0


# docs/performance.md: the strategies at the base point, then other values of one setting at a time.


def fastest_eigen(results, method, **where):
    return fastest([results.find(m, **where) for m in COUNTERPARTS[method]])


def strategy_rows(results):
    for method, epsilon in [("lazy_greedy", None), ("greedy", None), *(("stochastic_greedy", e) for e in EPSILONS[1:])]:
        where = {"epsilon": epsilon} if epsilon else {}
        ours, eigen = results.find(method, **where), fastest_eigen(results, method, **where)
        if ours is not None:
            name = f"`{method}`" + (f", ε = {epsilon}" if epsilon else "")
            yield [name, us(eigen), us(ours), printed_ratio(us(eigen), us(ours)), lost(ours)]


def strategies(results):
    header = ["strategy", "Eigen, median, µs", "maxlogdet, median, µs", "Eigen ÷ maxlogdet (ratio)",
              "loss, mean, nats"]  # fmt: skip
    return table(header, strategy_rows(results))


POINTS = [  # label, what differs from the base point
    ("the base case", {}),
    *((f"n = {n}", {"n": n}) for n in ("200", "20000")),
    ("k = 200", {"k": "200"}),
    ("blocks of three rows", {"blocks": "3_rows"}),
    ("weighting `measurement`", {"blocks": "2_rows_measurement"}),
    *((ISAS[isa], {"isa": isa}) for isa in ("sse2", "avx2")),
    ("frame with nearly equal gains", {"family": "nearly_equal_gains"}),
    ("recorded frames, n about 300", {"family": "real_frames", "n": "all"}),
]


def setting_rows(results):
    for label, where in POINTS:
        ours, eigen = results.find("lazy_greedy", **where), fastest_eigen(results, "lazy_greedy", **where)
        if ours is not None:
            yield [label, us(eigen), us(ours), printed_ratio(us(eigen), us(ours))]


def settings(results):
    header = ["setting", "Eigen, median, µs", "maxlogdet, median, µs", "Eigen ÷ maxlogdet (ratio)"]
    return table(header, setting_rows(results))


# docs/threading.md: the gain of several threads.

METHODS = ["greedy", "lazy_greedy"]  # rounds of stochastic_greedy are too short for threads


def thread_rows(results, threads):
    for n in thread_results.SIZES:
        if n != "5000":  # only in the record
            yield [n, *(times(thread_results.speedup(results, method, n, threads)) for method in METHODS)]


def thread_tables(results):
    threads = thread_results.max_threads(results)
    if threads == 1:
        return ["This machine has one core: nothing was measured."]
    costs = [cost for cost, _ in thread_results.chosen_costs(results)]
    return [
        *paragraph(f"The table has the time of one thread divided by the time of {threads}, on EuRoC-like simulated",
                   "frames with k = 100 and blocks of two rows."),
        "",
        *table(["n", *(f"`{name}` (ratio)" for name in METHODS)], thread_rows(results, threads)),
        "",
        *paragraph(
            f"The round trip of a cache line between the cores took {thread_results.round_trip(results)}. Up to 5000",
            f"candidates, `threads = 0` takes at most {costs[-1]:.2f} times as long as `threads = 1`.",
        ),
    ]  # fmt: skip


def main():
    if len(sys.argv) not in (2, 3) or sys.argv[2:] not in ([], ["--threads"]):
        sys.exit(__doc__)
    results = Results(sys.argv[1])
    print_all(results)
    rewrite(THREADING, "crossover", thread_tables(results))
    stamp(THREADING, "how_fast --threads")
    results.record("threads.csv", *thread_results.KINDS)
    if sys.argv[2:]:
        return
    rewrite(PERFORMANCE, "strategies", strategies(results))
    rewrite(PERFORMANCE, "settings", settings(results))
    stamp(PERFORMANCE, "how_fast")
    results.record("select.csv", "select", "many_calls", "full_round")
    results.record("append.csv", "append_blocks", "points_to_indices")


if __name__ == "__main__":
    main()
