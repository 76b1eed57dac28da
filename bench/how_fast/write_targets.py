#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Rewrites the table of performance targets and results in docs/maintenance.md.

Usage: write_targets.py BENCH.json    It also reads the record of profiles/run.
"""

import math
import sys

from maxlogdet_tools.files import json_of
from maxlogdet_tools.pages import rewrite, table
from maxlogdet_tools.project import ROOT
from maxlogdet_tools.runs import stamp
from results import ISAS, KINDS, MONOCULAR, STEREO, Results, ratio

PAGE = ROOT / "docs/maintenance.md"


def cases(results, isas):
    """(case, lower limit of a ratio, values by instruction set, what bounds it)"""
    frames = [("465", STEREO, "hot", 4, "float64 before full rank, blocks and updates"),
              ("465", STEREO, "cold", 3, "the first touch of code and data"),
              ("465", MONOCULAR, "cold", 4, "the first touch of code and data"),
              ("2000", STEREO, "hot", 4.5, "rounds before full rank, where no bound helps")]  # fmt: skip
    for n, matches, caches, limit, bound in frames:
        eigen = results.tracker("eigen_lazy_scan", matches, n, caches)
        values = [ratio(eigen, results.tracker("blocks_and_select", matches, n, caches, isa=isa)) for isa in isas]
        yield f"Eigen ÷ ours, {n} {KINDS[matches]}, {caches}", limit, values, bound
    eigen = results.grid("eigen_stochastic")
    values = [ratio(eigen, results.grid("stochastic_greedy", isa=isa)) for isa in isas]
    yield "Eigen ÷ `stochastic_greedy`, ε = 0.1", 2.5, values, "draws and updates, which Eigen pays, too"
    record = ROOT / "profiles/roofline.json"
    rounds = json_of(record)["full_round"] if record.is_file() else []
    shares = {r["isa"]: r["share_of_peak"] for r in rounds if r["rows"] == 2}
    yield ("full round ÷ [peak of the core](profiles.md)", 0.8, [shares.get(isas[0], math.nan)],
           "multiplications that have nothing to add")  # fmt: skip


def row(case, limit, values, bound):
    met = [value >= limit for value in values if not math.isnan(value)]
    verdict = "–" if not met else "yes" if all(met) else "no" if not any(met) else "in part"
    cells = ["–" if math.isnan(value) else f"{value:.3g}" for value in [*values, math.nan][:2]]
    return [case, f"≥ {limit:g}", *cells, verdict, bound]


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    results = Results(sys.argv[1])
    isas = [results.widest, *(["avx2"] if results.widest == "avx512" else [])]
    names = [*(ISAS[isa] for isa in isas), "–"][:2]
    rows = (row(*case) for case in cases(results, isas))
    rewrite(PAGE, "targets", table(["case (ratio)", "target", *names, "met", "what bounds it"], rows))
    stamp(PAGE, "how_fast")


if __name__ == "__main__":
    main()
