#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Rewrites the table of performance targets and results in docs/maintenance.md.

Usage: write_targets.py BENCH.json    It also reads the record of profiles/run_roofline.
"""

import math
import sys

import thread_results
from maxlogdet_tools.files import json_of
from maxlogdet_tools.pages import rewrite, table
from maxlogdet_tools.project import ROOT
from maxlogdet_tools.runs import stamp
from results import BLOCKS, ISAS, Results, ratio
from tracker_results import CACHES, KINDS, MONOCULAR, STEREO_MAP, isas, times_dense, times_eigen

PAGE = ROOT / "docs/maintenance.md"


def number(value):
    return "–" if math.isnan(value) else f"{value:{'.3g' if value < 100 else '.0f'}}"


def median(found):
    return math.nan if found is None else found["median_us"]


# The cases: (case, unit, limit, whether it is a lower limit, values, that of the widest instruction set first).


def tracker_cases(results):
    of_isas = lambda value: [value(isa) for isa in isas(results)]
    frames = [("465", STEREO_MAP, (4, 3)), ("465", MONOCULAR, (6, 4)), ("2000", STEREO_MAP, (4.5, 3.5))]
    for n, blocks, limits in frames:
        for caches, limit in zip(CACHES, limits):
            yield (f"Eigen ÷ ours, {n} {KINDS[blocks]}, {caches}", "ratio", limit, True,
                   of_isas(lambda isa: times_eigen(results, blocks, n, caches, isa=isa)))  # fmt: skip
    for caches in CACHES:
        dense = lambda isa: times_dense(results, "blocks_and_select", STEREO_MAP, "377", "2005", caches, isa)
        yield f"2005 slots ÷ 377 matches, stereo with covariances, {caches}", "ratio", 1.15, False, of_isas(dense)


def strategy_cases(results):
    find = results.find
    of_isas = lambda value: [value(isa) for isa in isas(results)]
    for blocks, most, times_lazy in (("2_rows", 25, 14), ("3_rows_measurement", 35, 20)):
        lazy = lambda isa: find("lazy_greedy", blocks=blocks, isa=isa)
        yield f"`lazy_greedy`, {BLOCKS[blocks]}", "µs", most, False, [median(lazy(results.widest))]
        yield (f"Eigen ÷ `lazy_greedy`, {BLOCKS[blocks]}", "ratio", times_lazy, True,
               of_isas(lambda isa: ratio(find("eigen_lazy_scan", blocks=blocks), lazy(isa))))  # fmt: skip
    stochastic = lambda isa: find("stochastic_greedy", isa=isa)
    yield "`stochastic_greedy`, ε = 0.1", "µs", 15, False, [median(stochastic(results.widest))]
    yield ("Eigen ÷ `stochastic_greedy`, ε = 0.1", "ratio", 2.5, True,
           of_isas(lambda isa: ratio(find("eigen_stochastic"), stochastic(isa))))  # fmt: skip
    both = median(results.find_append("points_to_indices", "none"))
    yield "blocks and selection together, 2 rows", "µs", 30, False, [both]
    many = find("lazy_greedy", kind="many_calls")
    spread = math.nan if many is None else many["p99_us"] / many["median_us"]
    yield "`lazy_greedy`, 99th percentile ÷ median", "ratio", 2, False, [spread]
    slower = ratio(*(find(method, family="equal_gains") for method in ("lazy_greedy", "greedy")))
    yield "`lazy_greedy` ÷ `greedy`, equal gains", "ratio", 1.3, False, [slower]


def thread_cases(results):
    threads = thread_results.max_threads(results)
    if threads == 1:
        return
    for method, n, k, limit in (("greedy", "20000", "100", 1.7), ("lazy_greedy", "100000", "200", 1.5)):
        one, several = (thread_results.find(results, "threads", method, count, n, k) for count in (1, threads))
        yield f"1 thread ÷ {threads} threads, `{method}`, n = {n}", "ratio", limit, True, [ratio(one, several)]
    side_by_side = thread_results.side_by_side(results)
    yield f"throughput of {threads} selectors ÷ throughput of one", "ratio", 0.95 * threads, True, [side_by_side]
    slowest, _ = thread_results.chosen_costs(results)[-1]
    yield "`threads = 0` ÷ `threads = 1`, n ≤ 5000, slowest", "ratio", 1.03, False, [slowest]


def kernel_case():
    roofline = ROOT / "profiles/roofline.json"
    record = json_of(roofline) if roofline.is_file() else {}
    share = record.get("full_round_share_of_peak", math.nan)
    return "full round ÷ [peak of the core](profiles.md)", "ratio", 0.8, True, [share]


def row(case, unit, limit, is_lower, values):
    met = [value >= limit if is_lower else value <= limit for value in values if not math.isnan(value)]
    verdict = "–" if not met else "yes" if all(met) else "no" if not any(met) else "in part"
    cells = [number(value) for value in [*values, math.nan][:2]]
    return [case, unit, f"{'≥' if is_lower else '≤'} {limit:g}", *cells, verdict]


def targets(results):
    names = [*(ISAS[isa] for isa in isas(results)), "–"][:2]
    cases = [*tracker_cases(results), *strategy_cases(results), *thread_cases(results), kernel_case()]
    return table(["case", "unit", "target", *names, "met"], (row(*case) for case in cases))


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    rewrite(PAGE, "targets", targets(Results(sys.argv[1])))
    stamp(PAGE, "how_fast")


if __name__ == "__main__":
    main()
