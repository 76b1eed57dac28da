#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Prints the table of all cases; rewrites the benchmark tables of docs/.

Usage: write_tables.py BENCH.json [--threads]    --threads: those of docs/threading.md alone
Those of what a tracker pays are write_tracker_tables.py's.
A table stands between the lines '<!-- begin NAME -->' and '<!-- end NAME -->'.
"""

import json
import math
import sys

import tracker_results
from results import BASE, BLOCKS, EIGEN, EPSILONS, ROOT, STRATEGIES, Results, fastest, label_of, nats, ratio, times, us

SIZES = ["200", "500", "1000", "2000", "5000", "20000", "100000"]
BUDGETS = ["20", "60", "100", "200"]
COLUMNS = [("greedy", None), ("lazy_greedy", None), *(("stochastic_greedy", e) for e in EPSILONS)]
BASELINES = [(method, None) for method in EIGEN]


def replace_between(path, name, lines):
    text = path.read_text()
    begin, end = f"<!-- begin {name} -->", f"<!-- end {name} -->"
    if text.count(begin) != 1 or text.count(end) != 1:
        sys.exit(f"{path}: expected one line '{begin}' and one line '{end}'")
    head, rest = text.split(begin)
    path.write_text(head + begin + "\n" + "\n".join(lines) + "\n" + end + rest.split(end)[1])
    print(f"rewrote {name} in {path.relative_to(ROOT)}")


def table(header, rows):
    line = lambda cells: "| " + " | ".join(cells) + " |"
    return [line(header), "|" + "---|" * len(header), *(line(row) for row in rows)]


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


# The main cases.


def readme_rows(results):
    for blocks in ("2_rows", "3_rows"):
        for method, epsilon in COLUMNS:
            row = results.find(method, blocks=blocks, **epsilon_at(method, epsilon))
            if row is None:
                continue
            baseline = lambda *methods: fastest([results.baseline(m, row) for m in methods])
            exact = ratio(baseline("eigen_exact", "eigen_exact_batched"), row)
            lazy = ratio(baseline("eigen_lazy", "eigen_lazy_scan"), row)
            stochastic = ratio(baseline("eigen_stochastic"), row)
            log_det = ratio(baseline("eigen_log_det"), row)
            yield [label_of(method, epsilon), BLOCKS[blocks], us(row), us(row, "p99_us"), us(row, "max_us"), nats(row),
                   f"{row['evaluations']:.0f}", times(exact), times(lazy), times(stochastic), times(log_det)]  # fmt: skip


def latency_table(results):
    header = ["strategy", "blocks", "median µs", "p99 µs", "max µs", "Δ log det (nats)", "gains evaluated",
              "× exact", "× lazy", "× stochastic", "× log det"]  # fmt: skip
    return [
        "100 of 2000 matches, EuRoC-like frame. The last columns: how many times faster than a search written with Eigen in "
        "float64 and",
        "compiled with `-O3 -march=native`, in the same run ([bench/eigen_baselines.cpp](../bench/eigen_baselines.cpp)): exact and "
        "lazy greedy, the",
        "faster of two variants each; stochastic greedy with the same ε, or 0.1; and the method's own way, a 6 x 6 "
        "log det a candidate.",
        "",
        *table(header, readme_rows(results)),
        "",
        results.machine(),
    ]


# docs/performance.md: one table an axis, all else at the base point.


def medians(results, title, axis, values, columns, names=None):
    """Median us over one axis; a value of the axis a line."""
    rows = []
    for value in values:
        found = [results.find(m, **{axis: value}, **epsilon_at(m, e)) for m, e in columns]
        if any(found):
            rows.append([(names or {}).get(value, value), *(us(row) for row in found)])
    return [title, "", *table([axis, *(label_of(m, e) for m, e in columns)], rows), ""]


def base_rows(results):
    many = results.find("lazy_greedy", kind="many_calls")
    methods = [*COLUMNS, *BASELINES[:4], *((m, e) for m, _ in BASELINES[4:] for e in EPSILONS)]
    found = [(label_of(m, e), results.find(m, **epsilon_at(m, e))) for m, e in methods]
    found.insert(2, ("lazy_greedy, many calls", many))
    for label, row in found:
        if row is not None:
            mismatches = f"{row['mismatches']:.0f}" if "mismatches" in row else "–"
            yield [label, us(row), us(row, "p99_us"), us(row, "p999_us"), us(row, "max_us"),
                   nats(row), mismatches, f"{row['evaluations']:.0f}", f"{row['calls']:.0f}",
                   f"{row['calls'] * row['preemptions']:.0f}"]  # fmt: skip


def family_rows(results, names):
    columns = [("greedy", None), ("lazy_greedy", None), ("stochastic_greedy", "0.1"), *BASELINES]
    for family in names:
        n = {"n": "all"} if family == "real_frames" else {}
        found = [results.find(m, family=family, **n, **epsilon_at(m, e)) for m, e in columns]
        if not any(found):
            continue
        lazy = found[1]
        share = "–" if lazy is None or found[0] is None else f"{lazy['evaluations'] / found[0]['evaluations']:.2f}"
        size = "" if lazy is None or not n else f" (mean n {lazy['candidates']:.0f})"
        yield [family + size, *(us(row) for row in found), nats(found[2]), share]


def grid(results):
    families = ["euroc_like", "kitti_like", "far_narrow", "clustered", "equal_gains", "nearly_equal_gains", "real_frames"]
    isas = sorted({r["isa"] for r in results.rows if r.get("isa") not in (None, "native")})
    isas.sort(key=lambda isa: -(results.find("greedy", isa=isa) or {"median_us": 0})["median_us"])
    thirds, weightings = ["none", "stereo", "depth"], ["map_bias", "map_bias_world", "measurement", "measurement_and_map"]
    return [
        results.machine(),
        "",
        "Median µs of single calls. Where a table does not say otherwise: n = 2000, k = 100, 2 rows, EuRoC-like, "
        "ε = 0.1, the widest instruction set.",
        "Repetitions of all cases are interleaved. The baselines are [bench/eigen_baselines.cpp](../bench/eigen_baselines.cpp), "
        "float64, `-O3 -march=native`.",
        "",
        "![latency over n](images/latency_over_n.png)",
        "",
        "![latency over k](images/latency_over_k.png)",
        "",
        "At the base point (mismatches: positions at which the indices differ from exact greedy's):",
        "",
        *table(["method", "median µs", "p99 µs", "p99.9 µs", "max µs", "Δ log det (nats)", "mismatches",
                "gains evaluated", "calls", "preemptions"], base_rows(results)),  # fmt: skip
        "",
        "![what a loss of log det buys in time](images/pareto.png)",
        "",
        *medians(results, "Over n:", "n", SIZES, COLUMNS + BASELINES),
        *medians(results, "Over k:", "k", BUDGETS, COLUMNS + BASELINES),
        "`stochastic_greedy` over k and ε, median µs and Δ log det (nats):",
        "",
        *table(["k", *(f"ε = {e}" for e in EPSILONS)],
               ([k, *(f"{us(r)}, {nats(r)}" for r in (results.find("stochastic_greedy", k=k, epsilon=e) for e in EPSILONS))]
                for k in BUDGETS)),  # fmt: skip
        "",
        "![latency and loss over budget and epsilon](images/budget_epsilon.png)",
        "",
        *medians(results, "Over the rows of a block:", "blocks", list(BLOCKS), COLUMNS + BASELINES, BLOCKS),
        *medians(results, "Over instruction sets:", "isa", isas, [COLUMNS[0], COLUMNS[1], COLUMNS[3]]),
        "Over families of frames (Δ: of `stochastic_greedy`; share: gains that `lazy_greedy` evaluates of those that "
        "`greedy` does):",
        "",
        *table(["family", "greedy", "lazy_greedy", "stochastic_greedy", *EIGEN.values(), "Δ log det (nats)", "share"],
               family_rows(results, families)),  # fmt: skip
        "",
        "A round of greedy, 1950 gains on average and all that goes with them:",
        "",
        *table(["blocks", "µs a round", "ns a gain"], full_round_rows(results)),
        "",
        "`append_blocks`, 2000 matches, by weighting and third row:",
        "",
        *table(["weighting", *thirds], ([w, *(us(results.find_append("append_blocks", t, w)) for t in thirds)]
                                        for w in weightings)),  # fmt: skip
    ]


def full_round_rows(results):
    for blocks, name in BLOCKS.items():
        row = results.find("greedy", kind="full_round", blocks=blocks)
        if row is not None:
            yield [name, f"{row['median_us'] / int(row['k']):.2f}", f"{1e3 * row['median_us'] / row['evaluations']:.2f}"]


# docs/threading.md: what several threads gain, and from where on.

THREADED_SIZES = ["2000", "5000", "10000", "20000", "50000", "100000"]


def speedup_of_threads(results, method, n, threads):
    one = results.find_threads("threads", method, 1, n)
    return ratio(one, results.find_threads("threads", method, threads, n))


def crossover_of(results, method, threads):
    """The smallest measured n from which on several threads are always faster."""
    found = None
    for n in reversed(THREADED_SIZES):
        if not speedup_of_threads(results, method, n, threads) > 1:
            break
        found = n
    return found


def thread_tables(results):
    most = results.max_threads()
    if most == 1:
        return ["One core here: nothing to measure."]
    cell = lambda one, several: f"{us(one)} / {us(several)} = {times(ratio(one, several))}"
    methods = [m for m in STRATEGIES if results.find_threads("threads", m, 1, "2000")]
    rows = []
    for n in THREADED_SIZES:
        found = [(results.find_threads("threads", m, 1, n), results.find_threads("threads", m, most, n)) for m in methods]
        append = [results.find_append_threads(n, count) for count in (1, most)]
        rows.append([n, *(cell(*pair) for pair in found), cell(*append) if all(append) else "–"])
    points = [(r, results.find_threads("choose", r["method"], 0, r["n"], r["k"], r["blocks"], r["family"]))
              for r in results.rows if r["kind"] == "choose" and r["threads"] == "1"]  # fmt: skip
    costs = [(ratio(chosen, one), one) for one, chosen in points if chosen is not None]
    worst, at = max(costs, key=lambda cost: cost[0])
    median = sorted(cost for cost, _ in costs)[len(costs) // 2]
    alone, together = (results.find_threads("side_by_side", "lazy_greedy", count) for count in (1, most))
    pauses = [results.find_threads("after_pause", "greedy", count, "20000") for count in (1, most)]
    return [
        results.machine(f"1 and {most} threads"),
        f"A cache line's way to the other core and back: {results.round_trip()}.",
        "",
        f"Median µs on one thread / on {most} threads = how many times faster (k = 100, 2 rows, EuRoC-like, calls one right "
        "after the other):",
        "",
        *table(["n", *methods, "append_blocks"], rows),
        "",
        f"From which n on {most} threads are faster: " +
        ", ".join(f"`{m}` {crossover_of(results, m, most) or 'nowhere'}" for m in methods) + ".",
        "",
        f"`threads = 0` against 1 at the {len(costs)} points of the grid with n ≤ 5000: {median:.3f} times as long in the "
        f"median, {worst:.3f} at most (`{at['method']}`, n = {at['n']}, k = {at['k']}, {BLOCKS[at['blocks']]}, {at['family']}).",
        "",
        f"Serial selectors side by side on {most} threads: {most * ratio(alone, together):.2f} times the throughput of one.",
        "",
        f"`greedy`, n = 20000, after a pause of 33 ms: {us(pauses[0])} µs on one thread, {us(pauses[1])} on {most} "
        f"(best of all calls {pauses[1]['min_us']:.0f}, p99 {us(pauses[1], 'p99_us')}).",
    ]


# What was aimed at, and what was found.


def targets(results):
    rows = []

    def verdict(limit, value, unit, at_least):
        if value is None or math.isnan(value):
            return "not measured"
        is_met = value >= limit if at_least else value <= limit
        return f"{value:{'.3g' if value < 100 else '.0f'}} {unit}".strip() + (", met" if is_met else ", missed")

    def add(case, limit, value, unit, at_least=False):
        sign = "≥" if at_least else "≤"
        rows.append([case, f"{sign} {limit:g} {unit}".strip(), verdict(limit, value, unit, at_least)])

    def add_by_isa(case, limit, values, at_least=False):
        """A ratio on several instruction sets."""
        found = "; ".join(f"{isa} {verdict(limit, value, '', at_least)}" for isa, value in values.items())
        rows.append([case, f"{'≥' if at_least else '≤'} {limit:g}", found])

    for case, limit, at_least, values in tracker_results.targets(results):
        add_by_isa(case, limit, values, at_least)
    by_isa = lambda slow, method, **where: {
        isa: ratio(slow, results.find(method, isa=isa, **where)) for isa in tracker_results.isas(results)
    }
    median = lambda row: None if row is None else row["median_us"]
    for blocks, limit in (("2_rows_measurement", 25), ("2_rows", 25), ("3_rows_measurement", 35), ("3_rows", 35)):
        name = BLOCKS[blocks]
        lazy = results.find("lazy_greedy", blocks=blocks)
        add(f"`lazy_greedy`, {name}", limit, median(lazy), "µs")
        is_base = blocks == BASE["blocks"]
        for method, least in (("eigen_lazy", 20), ("eigen_lazy_scan", 14 if is_base else 20),
                              ("eigen_stochastic", 1.4 if is_base else 2)):  # fmt: skip
            case, eigen = f"{label_of(method)} / `lazy_greedy`, {name}", results.find(method, blocks=blocks)
            if is_base and method != "eigen_lazy":
                add_by_isa(case, least, by_isa(eigen, "lazy_greedy"), at_least=True)
            else:
                add(case, least, ratio(eigen, lazy), "", at_least=True)
    stochastic = results.find("stochastic_greedy")
    add("`stochastic_greedy`, ε = 0.1", 15, median(stochastic), "µs")
    add_by_isa("Eigen stochastic / `stochastic_greedy`, ε = 0.1", 2.5,
               by_isa(results.find("eigen_stochastic"), "stochastic_greedy"), at_least=True)  # fmt: skip
    add("`append_blocks`, map_bias", 5, median(results.find_append("append_blocks", "none")), "µs")
    add("points to indices, map_bias, `lazy_greedy`", 30, median(results.find_append("points_to_indices", "none")), "µs")
    avx2, avx512 = (results.find("lazy_greedy", isa=isa) for isa in ("avx2", "avx512"))
    add("avx2 / avx512, `lazy_greedy`", 2.2, ratio(avx2, avx512), "")
    many = results.find("lazy_greedy", kind="many_calls")
    calls = f"{many['calls']:.0f}" if many else "many"
    add(f"p99 / median over {calls} calls, `lazy_greedy`", 2, many and many["p99_us"] / many["median_us"], "")
    preempted = f"{many['calls'] * many['preemptions']:.0f}" if many else "some"
    add(f"the same without calls that another process interrupted ({preempted} times)", 2,
        many and many.get("undisturbed_p99_us", math.nan) / many["median_us"], "")  # fmt: skip
    for family in ("equal_gains", "nearly_equal_gains"):
        name = family.replace("_", " ")
        lazy, greedy = (results.find(method, family=family) for method in ("lazy_greedy", "greedy"))
        add(f"{name}, `lazy_greedy` / `greedy`", 1.3, ratio(lazy, greedy), "")
        add(f"{name}, `lazy_greedy` / `greedy` on the ordinary EuRoC-like frame", 1.3, ratio(lazy, results.find("greedy")), "")
    most = results.max_threads()
    if most > 1:
        for method, n, k, blocks, least in (("greedy", "20000", "100", "2_rows", 1.7), ("greedy", "100000", "100", "2_rows", 1.7),
                                            ("lazy_greedy", "100000", "200", "2_rows", 1.5),
                                            ("lazy_greedy", "100000", "200", "2_rows_measurement", 1.5),
                                            ("relaxed", "100000", "200", "2_rows", 1.8),
                                            ("relaxed", "100000", "200", "2_rows_measurement", 1.8)):  # fmt: skip
            one, several = (results.find_threads("threads", method, count, n, k, blocks) for count in (1, most))
            add(f"{most} threads against 1, `{method}`, n = {n}, k = {k}, {BLOCKS[blocks]}", least, ratio(one, several), "",
                at_least=True)  # fmt: skip
        alone, together = (results.find_threads("side_by_side", "lazy_greedy", count) for count in (1, most))
        add(f"throughput of {most} serial selectors side by side against one", 0.95 * most, most * ratio(alone, together), "",
            at_least=True)  # fmt: skip
        costs = [ratio(results.find_threads("choose", r["method"], 0, r["n"], r["k"], r["blocks"], r["family"]), r)
                 for r in results.rows if r["kind"] == "choose" and r["threads"] == "1"]  # fmt: skip
        add("`threads = 0` against 1, n ≤ 5000, the slowest point", 1.03, max(costs), "")
    roofline = ROOT / "profiles/roofline.json"
    record = json.loads(roofline.read_text()) if roofline.is_file() else {}
    add("full round, share of the measured FMA slots (`profiles/`)", 0.8, record.get("full_round_share_of_slots"), "",
        at_least=True)  # fmt: skip
    add("full round, share of the measured FMA flops (`profiles/`)", 0.8, record.get("full_round_share_of_peak"), "",
        at_least=True)  # fmt: skip
    defaults = (
        "A / B: the time of A by that of B. Where nothing else is said, n = 2000, k = 100, `map_bias` blocks of 2 rows, an "
        f"EuRoC-like frame, and {results.widest}; of rows with hot or cold, and of `ActiveSelection`, k = 100 and KITTI-like "
        "frames ([below](#in-a-tracker)). Rows of two threads depend on a cache line's way to the other core and back, which "
        f"took {results.round_trip()} ([why](#what-was-learnt))."
    )
    return [results.machine(), "", defaults, "", *table(["case", "target", "found"], rows)]


def main():
    if len(sys.argv) not in (2, 3) or sys.argv[2:] not in ([], ["--threads"]):
        sys.exit(__doc__)
    results = Results(sys.argv[1])
    print_all(results)
    replace_between(ROOT / "docs/threading.md", "crossover", thread_tables(results))
    if sys.argv[2:]:
        return
    replace_between(ROOT / "docs/performance.md", "latency", latency_table(results))
    replace_between(ROOT / "docs/performance.md", "targets", targets(results))
    replace_between(ROOT / "docs/performance.md", "grid", grid(results))


if __name__ == "__main__":
    main()
