#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Prints the table of all cases; rewrites the benchmark tables of docs/ and the records in bench/results/.

Usage: write_tables.py BENCH.json [--threads]    --threads: those of docs/threading.md alone
Those of what a tracker pays are write_tracker_tables.py's, the targets are write_targets.py's.
A table stands between the lines '<!-- begin NAME -->' and '<!-- end NAME -->'.
"""

import sys
import textwrap

from results import (
    BLOCKS, EIGEN, EPSILONS, ROOT, STRATEGIES, Results, fastest, label_of, nats, ratio, record_run, times,
    us,
)  # fmt: skip

SIZES = ["200", "500", "1000", "2000", "5000", "20000", "100000"]
BUDGETS = ["20", "60", "100", "200"]
COLUMNS = [("greedy", None), ("lazy_greedy", None), *(("stochastic_greedy", e) for e in EPSILONS)]


def replace_between(path, name, lines):
    text = path.read_text()
    begin, end = f"<!-- begin {name} -->", f"<!-- end {name} -->"
    if text.count(begin) != 1 or text.count(end) != 1:
        sys.exit(f"{path}: expected one line '{begin}' and one line '{end}'")
    head, rest = text.split(begin)
    path.write_text(head + begin + "\n" + "\n".join(lines) + "\n" + end + rest.split(end)[1])
    print(f"rewrote {name} in {path.relative_to(ROOT)}")


def unless_said(path, line):
    """A run's line, if the page's first run was not on that machine; else bench/results/runs.csv has the rest."""
    machine = ",".join(line.split(",")[:4])  # processor, cores, instruction set, compiler
    return [] if machine in path.read_text().split("<!-- end latency -->")[0] else ["", line]


def table(header, rows):
    line = lambda cells: "| " + " | ".join(cells) + " |"
    return [line(header), "|" + "---|" * len(header), *(line(row) for row in rows)]


def paragraph(*sentences):
    return textwrap.wrap(" ".join(sentences), 120, break_long_words=False, break_on_hyphens=False)


def epsilon_at(method, epsilon):
    return {"epsilon": epsilon} if epsilon else {}


# The table of everything, for the terminal.


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


# docs/performance.md: the base point, then one setting changed at a time.

COUNTERPARTS = {"greedy": ["eigen_exact", "eigen_exact_batched"], "lazy_greedy": ["eigen_lazy", "eigen_lazy_scan"],
                "stochastic_greedy": ["eigen_stochastic"]}  # fmt: skip


def times_counterpart(results, row):
    """How many times faster than the same search with Eigen, the faster of its variants."""
    if row is None or row["method"] not in COUNTERPARTS:
        return ""
    return times(ratio(fastest([results.baseline(m, row) for m in COUNTERPARTS[row["method"]]]), row))


def base_row(results, label, methods, epsilon):
    """Of several methods the fastest one; None if it was not measured."""
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
    """Ours, and the faster variant of the baselines."""
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


# docs/threading.md: what several threads gain, and from where on.

THREAD_KINDS = ["threads", "choose", "after_pause", "side_by_side", "append_threads", "line"]
THREADED_SIZES = ["2000", "5000", "10000", "20000", "50000", "100000"]


def speedup_of_threads(results, method, n, threads):
    one = results.find_threads("threads", method, 1, n)
    return ratio(one, results.find_threads("threads", method, threads, n))


def chosen_costs(results):
    """How much longer `threads = 0` takes than 1 at the small points of the grid, and their rows."""
    points = [(r, results.find_threads("choose", r["method"], 0, r["n"], r["k"], r["blocks"], r["family"]))
              for r in results.rows if r["kind"] == "choose" and r["threads"] == "1"]  # fmt: skip
    return sorted(((ratio(chosen, one), one) for one, chosen in points if chosen is not None), key=lambda cost: cost[0])


def side_by_side(results):
    """The throughput of a serial selector on each thread, by that of one."""
    threads = results.max_threads()
    return threads * ratio(*(results.find_threads("side_by_side", "lazy_greedy", count) for count in (1, threads)))


def thread_rows(results, methods):
    for n in THREADED_SIZES:
        if n != "5000":  # the record has it
            append = ratio(*(results.find_append_threads(n, count) for count in (1, results.max_threads())))
            speed_ups = (speedup_of_threads(results, method, n, results.max_threads()) for method in methods)
            yield [n, *(times(value) for value in (*speed_ups, append))]


def thread_tables(results):
    threads = results.max_threads()
    if threads == 1:
        return ["One core here: nothing to measure."]
    methods = [m for m in STRATEGIES if results.find_threads("threads", m, 1, "2000")]
    costs = [cost for cost, _ in chosen_costs(results)]
    one, several = (results.find_threads("after_pause", "greedy", count, "20000") for count in (1, threads))
    return [
        *paragraph(
            f"Speed-up of {threads} threads (medians, k = 100, 2 rows, EuRoC-like), round trip of a cache line",
            f"{results.round_trip()}. {results.machine(f'1 and {threads} threads')}",
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
    replace_between(ROOT / "docs/threading.md", "crossover", thread_tables(results))
    results.record("threads.csv", *THREAD_KINDS)
    if sys.argv[2:]:
        return
    replace_between(ROOT / "docs/performance.md", "latency", base_table(results))
    replace_between(ROOT / "docs/performance.md", "grid", grid(results))
    results.record("select.csv", "select", "many_calls", "full_round")
    results.record("append.csv", "append_blocks", "points_to_indices")
    record_run(["latency", "grid"], results.machine())


if __name__ == "__main__":
    main()
