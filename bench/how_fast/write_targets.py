#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Rewrites the table of performance targets and results in docs/performance.md.

Usage: write_targets.py BENCH.json    It also reads the record of profiles/run_roofline.
"""

import math
import sys

import thread_results
import tracker_results
from maxlogdet_tools.files import json_of
from maxlogdet_tools.pages import paragraph, rewrite, table
from maxlogdet_tools.project import ROOT
from records import record_run
from results import Results, label_of, ratio

KINDS = ["2_rows", "2_rows_measurement", "3_rows", "3_rows_measurement"]
REASONS = {
    "a": "Without this library one writes a lazy greedy in Eigen that scans its bounds; a dependency should be several "
         "times faster.",
    "b": "Textbooks keep the bounds in a heap.",
    "c": "An exact search that is faster makes sampling needless.",
    "d": "A frame at 30 Hz leaves 33 ms, of which about a thousandth needs no justification.",
    "e": "Matching while selecting should not cost two selections.",
    "f": "Otherwise callers would have to compact their arrays.",
    "g": "AVX2 has half the lanes and half the registers.",
    "h": "A tracker is judged by its slowest frames.",
    "i": "Laziness should cost nothing where bounds exclude no candidate.",
    "j": "Two cores give at most 2, and nearly that to selectors that share nothing; the default `threads = 0` must "
         "not lose.",
    "k": "Above 0.8 of the peak a better kernel hardly helps.",
}  # fmt: skip


def number(value):
    return f"{value:{'.3g' if value < 100 else '.0f'}}"


def verdict(limits, values, at_least):
    """'VALUE / VALUE, missed', or a verdict for each value if these differ."""
    if any(value is None or math.isnan(value) for value in values):
        return "not measured"
    is_met = lambda value, limit: value >= limit if at_least else value <= limit
    words = ["met" if is_met(value, limit) else "missed" for value, limit in zip(values, limits)]
    if len(set(words)) == 1:
        return f"{' / '.join(number(value) for value in values)}, {words[0]}"
    return " / ".join(f"{number(value)} {word}" for value, word in zip(values, words))


def row(reason, case, limits, by_isa, at_least=False, unit=""):
    """A row of the table; limits: one per value, or one for all."""
    sign = "≥" if at_least else "≤"
    shown = " / ".join(f"{limit:g}" for limit in limits)
    each = [limits * len(values) if len(limits) == 1 else limits for values in by_isa]
    found = [verdict(limit, values, at_least) for limit, values in zip(each, by_isa)]
    return [case, f"{sign} {shown} {unit}".strip(), *found, *[""] * (2 - len(found)), reason]


def median(found):
    return None if found is None else found["median_us"]


def tracker_rows(results):
    reasons = {"Eigen": "a", "`ActiveSelection`": "e", "2005": "f"}
    for case, limits, at_least, values in tracker_results.targets(results):
        yield row(reasons[case.split()[0]], case, limits, list(values.values()), at_least)


def strategy_rows(results):
    isas = tracker_results.isas(results)
    lazy = lambda blocks, isa=None: results.find("lazy_greedy", blocks=blocks, **({"isa": isa} if isa else {}))
    case = "`lazy_greedy`: 2 rows, `measurement`; 3 rows, `measurement`"
    yield row("d", case, [25, 25, 35, 35], [[median(lazy(b)) for b in KINDS]], unit="µs")
    for reason, method, limits in (("b", "eigen_lazy", [20]), ("a", "eigen_lazy_scan", [14, 20, 20, 20]),
                                   ("c", "eigen_stochastic", [1.4, 2, 2, 2])):  # fmt: skip
        of_isa = lambda isa, kinds: [ratio(results.find(method, blocks=b), lazy(b, isa)) for b in kinds]
        other = [of_isa(isa, KINDS[:1]) for isa in isas[1:] if method != "eigen_lazy"]  # only at the base point
        case = f"{label_of(method)} / `lazy_greedy`, the same four"
        yield row(reason, case, limits, [of_isa(isas[0], KINDS), *other], True)
    ours = lambda isa: results.find("stochastic_greedy", isa=isa)
    eigen = results.find("eigen_stochastic")
    yield row("c", "Eigen stochastic / `stochastic_greedy`", [2.5], [[ratio(eigen, ours(isa))] for isa in isas], True)
    append = [results.find_append(kind, "none") for kind in ("append_blocks", "points_to_indices")]
    case = "`stochastic_greedy`; `append_blocks`; points to indices"
    yield row("d", case, [15, 5, 30], [[median(found) for found in (ours(isas[0]), *append)]], unit="µs")
    slower = ratio(lazy("2_rows", "avx2"), lazy("2_rows", "avx512"))
    yield row("g", "avx2 / avx512, `lazy_greedy`", [2.2], [[slower]])


def spread_rows(results):
    many = results.find("lazy_greedy", kind="many_calls") or {"median_us": 1, "calls": 0}
    spread = [many.get(key, math.nan) / many["median_us"] for key in ("p99_us", "undisturbed_p99_us")]
    yield row("h", f"p99 / median of {many['calls']:.0f} calls, all / undisturbed", [2], [spread])
    find = lambda method, **where: results.find(method, **where)
    families = ("equal_gains", "nearly_equal_gains")
    own = [ratio(find("lazy_greedy", family=f), find("greedy", family=f)) for f in families]
    ordinary = [ratio(find("lazy_greedy", family=f), find("greedy")) for f in families]
    case = "equal, nearly equal gains: `lazy_greedy` / `greedy`; / `greedy` at the base point"
    yield row("i", case, [1.3], [own + ordinary])


THREADED = [  # method, (n, k, blocks) of two points, their description, the minimum speed-up
    ("greedy", [("20000", "100", "2_rows"), ("100000", "100", "2_rows")], "n = 20000, 100000", 1.7),
    *((method, [("100000", "200", blocks) for blocks in KINDS[:2]], "n = 100000, k = 200: 2 rows, `measurement`", limit)
      for method, limit in (("lazy_greedy", 1.5), ("relaxed", 1.8))),
]  # fmt: skip


def thread_rows(results):
    threads = thread_results.max_threads(results)
    if threads == 1:
        return
    for method, points, what, limit in THREADED:
        speed = [ratio(*(thread_results.find(results, "threads", method, count, *point) for count in (1, threads)))
                 for point in points]  # fmt: skip
        yield row("j", f"speed-up by {threads} threads, `{method}`, {what}", [limit], [speed], True)
    case = f"throughput of {threads} serial selectors side by side"
    yield row("j", case, [0.95 * threads], [[thread_results.side_by_side(results)]], True)
    slowest, _ = thread_results.chosen_costs(results)[-1]
    yield row("j", "`threads = 0` / 1, n ≤ 5000, the slowest point", [1.03], [[slowest]])


def kernel_row():
    roofline = ROOT / "profiles/roofline.json"
    record = json_of(roofline) if roofline.is_file() else {}
    shares = [record.get(key) for key in ("full_round_share_of_slots", "full_round_share_of_peak")]
    return row("k", "full round, share of the peak in [FMA slots / flops](profiles.md)", [0.8], [shares], True)


def targets(results):
    rows = [*tracker_rows(results), *strategy_rows(results), *spread_rows(results), *thread_rows(results)]
    isas = [*tracker_results.isas(results), "–"][:2]
    return [
        *paragraph(
            "A / B is the time of A by that of B. The first five rows are of [tracker frames](#in-a-tracker), hot /",
            "cold unless they say otherwise; the others of the base point but for what they name. Two threads depend",
            "on the distance of the cores ([why](threading.md#when-it-pays)). Misses are explained",
            "[below](#what-limits-the-missed-targets).",
        ),
        "",
        *table(["case", "target", *isas, "why"], [*rows, kernel_row()]),
        "",
        *paragraph("Why these are targets:", *(f"*({letter})* {reason}" for letter, reason in REASONS.items())),
    ]


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    results = Results(sys.argv[1])
    rewrite(ROOT / "docs/performance.md", "targets", targets(results))
    record_run(["targets"], results.machine())


if __name__ == "__main__":
    main()
