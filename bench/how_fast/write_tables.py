#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Prints the table of all cases; rewrites the tables of the grid and of threads in docs/, and their records.

Usage: write_tables.py BENCH.json [--threads]    --threads: only those of docs/threading.md
write_tracker_tables.py writes the tables of tracker frames, write_targets.py the targets.
"""

import sys

import thread_results
from maxlogdet_tools.pages import paragraph, rewrite, table
from maxlogdet_tools.project import ROOT
from records import record_run
from results import BLOCKS, EIGEN, EPSILONS, STRATEGIES, Results, fastest, label_of, nats, ratio, times, us

PERFORMANCE = ROOT / "docs/performance.md"
COLUMNS = [("greedy", None), ("lazy_greedy", None), *(("stochastic_greedy", e) for e in EPSILONS)]


def epsilon_at(method, epsilon):
    return {"epsilon": epsilon} if epsilon else {}


# The table of all cases, for the terminal.


def print_all(results):
    header = ["case", "median", "p99", "max us", "delta nats", "evaluations", *(f"x {EIGEN[m][6:]}" for m in EIGEN)]
    lines = []
    order = {method: i for i, method in enumerate([*STRATEGIES, *EIGEN])}
    key = lambda r: (r["kind"], r.get("family", ""), r.get("blocks", ""), r.get("isa", ""), number(r.get("k")),
                     number(r.get("n")), order.get(r["method"], 0), r.get("epsilon", ""), r["name"])  # fmt: skip
    for row in sorted(results.rows, key=key):
        case = "/".join(p for p in row["name"].split("/") if p not in ("manual_time", "iterations:1", "repeats:1"))
        cells = [case, us(row), us(row, "p99_us"), us(row, "max_us")]
        if "delta_nats" in row:
            cells += [nats(row), f"{row['evaluations']:.0f}"]
        if row["method"] in STRATEGIES and row["kind"] == "select":
            cells += [times(ratio(results.baseline(m, row), row)) for m in EIGEN]
        lines.append(cells)
    width = max(len(cells[0]) for cells in lines)
    for cells in [header, *lines]:
        print(f"{cells[0]:<{width}}", *(f"{cell:>11}" if i < 5 else f"{cell:>17}" for i, cell in enumerate(cells[1:])))
    print()


def number(text):
    return int(text) if text and text.isdigit() else 0


# docs/performance.md: the base point, then other values of one setting at a time.

COUNTERPARTS = {"greedy": ["eigen_exact", "eigen_exact_batched"], "lazy_greedy": ["eigen_lazy", "eigen_lazy_scan"],
                "stochastic_greedy": ["eigen_stochastic"]}  # fmt: skip


def times_counterpart(results, row):
    """How many times faster than the fastest variant of the same search with Eigen."""
    if row is None or row["method"] not in COUNTERPARTS:
        return ""
    return times(ratio(fastest([results.baseline(m, row) for m in COUNTERPARTS[row["method"]]]), row))


def base_row(results, label, methods, epsilon):
    """The row of the fastest of several methods; None if none was measured."""
    two, three = (fastest([results.find(m, blocks=b, **epsilon_at(m, epsilon)) for m in methods])
                  for b in ("2_rows", "3_rows"))  # fmt: skip
    if two is None:
        return None
    return [label, us(two), us(two, "p99_us"), times_counterpart(results, two), f"{two['evaluations']:.0f}", nats(two),
            us(three), times_counterpart(results, three)]  # fmt: skip


def base_rows(results):
    for method, epsilon in COLUMNS:
        yield base_row(results, label_of(method, epsilon), [method], epsilon)
    for label, methods in (("Eigen exact", COUNTERPARTS["greedy"]), ("Eigen lazy", COUNTERPARTS["lazy_greedy"])):
        yield base_row(results, label, methods, None)
    for method in ("eigen_stochastic", "eigen_log_det"):
        yield base_row(results, label_of(method, "0.1"), [method], "0.1")


def base_table(results):
    header = ["method", "2 rows µs", "p99 µs", "× Eigen", "gains evaluated", "Δ log det (nats)", "3 rows µs", "× Eigen"]
    lines = [*table(header, filter(None, base_rows(results))), ""]
    many = results.find("lazy_greedy", kind="many_calls")
    if many is not None:
        lines += paragraph(f"{many['calls']:.0f} calls of `lazy_greedy`: p99 {us(many, 'p99_us')} µs, p99.9 "
                           f"{us(many, 'p999_us')}, maximum {us(many, 'max_us')}; another process interrupted "
                           f"{many['calls'] * many['preemptions']:.0f}.")  # fmt: skip
    return [*lines, results.machine()]


POINTS = [
    *(("n", value) for value in ("200", "20000", "100000")),
    *(("k", value) for value in ("20", "200")),
    *(("blocks", value) for value in ("1_row", "2_rows_measurement", "3_rows_measurement")),
    *(("isa", value) for value in ("sse2", "avx2")),
    *(("family", value) for value in ("kitti_like", "clustered", "equal_gains", "nearly_equal_gains")),
]


def point_row(results, label, **where):
    """Our strategies, and the fastest variant of each baseline."""
    greedy, lazy, stochastic = ours = [results.find(method, **where) for method in COUNTERPARTS]
    if None in ours:
        return None
    eigen = [fastest([results.find(m, **where) for m in COUNTERPARTS[method]])
             for method in ("lazy_greedy", "stochastic_greedy")]  # fmt: skip
    share = f"{lazy['evaluations'] / greedy['evaluations']:.2f}"
    return [label, *(us(row) for row in [*ours, *eigen]), share, nats(stochastic)]


def point_rows(results):
    label = lambda axis, value: f"{axis} = {value}" if value.isdigit() else BLOCKS.get(value, value)
    rows = [point_row(results, label(axis, value), **{axis: value}) for axis, value in [("n", "2000"), *POINTS]]
    real = results.find("lazy_greedy", family="real_frames", n="all")
    if real is not None:
        name = f"real_frames, mean n = {real['candidates']:.0f}"
        rows.append(point_row(results, name, family="real_frames", n="all"))
    return [row for row in rows if row is not None]


def grid(results):
    header = ["", "greedy", "lazy_greedy", "stochastic_greedy", "Eigen lazy", "Eigen stochastic", "share", "Δ log det"]
    return [*table(header, point_rows(results)), "", *paragraph(full_rounds(results), appended(results))]


def full_rounds(results):
    found = [results.find("greedy", kind="full_round", blocks=blocks) for blocks in ("1_row", "2_rows", "3_rows")]
    rounds = " / ".join(f"{row['median_us'] / int(row['k']):.2f}" if row else "–" for row in found)
    gains = " / ".join(f"{1e3 * row['median_us'] / row['evaluations']:.2f}" if row else "–" for row in found)
    return f"A round of `greedy`, 1950 gains on average, takes {rounds} µs with 1 / 2 / 3 rows, {gains} ns a gain."


def appended(results):
    thirds = ["none", "stereo", "depth"]
    cells = lambda weighting: " / ".join(us(results.find_append("append_blocks", third, weighting)) for third in thirds)
    parts = ", ".join(f"{cells(weighting)} (`{weighting}`)" for weighting in
                      ("map_bias", "map_bias_world", "measurement", "measurement_and_map"))  # fmt: skip
    return f"`append_blocks` of 2000 matches takes, with no third row / stereo / depth, {parts} µs."


# docs/threading.md: the gain of several threads.

def thread_rows(results, methods):
    threads = thread_results.max_threads(results)
    for n in thread_results.SIZES:
        if n != "5000":  # only in the record
            append = ratio(*(thread_results.find_append(results, n, count) for count in (1, threads)))
            speed_ups = (thread_results.speedup(results, method, n, threads) for method in methods)
            yield [n, *(times(value) for value in (*speed_ups, append))]


def thread_tables(results):
    threads = thread_results.max_threads(results)
    if threads == 1:
        return ["This machine has one core: nothing was measured."]
    methods = [m for m in STRATEGIES if thread_results.find(results, "threads", m, 1, "2000")]
    costs = [cost for cost, _ in thread_results.chosen_costs(results)]
    one, several = (thread_results.find(results, "after_pause", "greedy", count, "20000") for count in (1, threads))
    return [
        *paragraph(
            f"Speed-up of {threads} threads (medians, k = 100, 2 rows, EuRoC-like), round trip of a cache line",
            f"{thread_results.round_trip(results)}. {results.machine(f'1 and {threads} threads')}",
        ),
        "",
        *table(["n", *methods, "append_blocks"], thread_rows(results, methods)),
        "",
        *paragraph(
            f"With n ≤ 5000 `threads = 0` takes {costs[len(costs) // 2]:.3f} times as long as 1 in the median of",
            f"{len(costs)} cases, {costs[-1]:.3f} at most. After 33 ms of pause `greedy`, n = 20000, takes",
            f"{us(one)} µs on one thread, {us(several)} on {threads} (minimum {several['min_us']:.0f}, p99",
            f"{us(several, 'p99_us')}).",
        ),
    ]


def main():
    if len(sys.argv) not in (2, 3) or sys.argv[2:] not in ([], ["--threads"]):
        sys.exit(__doc__)
    results = Results(sys.argv[1])
    print_all(results)
    rewrite(ROOT / "docs/threading.md", "crossover", thread_tables(results))
    results.record("threads.csv", *thread_results.KINDS)
    if sys.argv[2:]:
        return
    rewrite(PERFORMANCE, "latency", base_table(results))
    rewrite(PERFORMANCE, "grid", grid(results))
    results.record("select.csv", "select", "many_calls", "full_round")
    results.record("append.csv", "append_blocks", "points_to_indices")
    record_run(["latency", "grid"], results.machine())


if __name__ == "__main__":
    main()
