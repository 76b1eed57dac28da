#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Writes how far answers and bounds were from the best of all subsets into docs/trust.md.

Usage: write_exhaustive.py EXHAUSTIVE.csv    (of tests/core/exhaustive_test.cpp)
"""

import csv
import math
import sys

from results import ROOT
from write_tables import replace_between, table

OPTIMAL = 1e-10  # nats: what the test allows for its own rounding
TIGHT = 1e-6  # nats


def quantile(values, share):
    """Nearest rank."""
    return sorted(values)[max(0, math.ceil(share * len(values)) - 1)]


def share(value):
    return "1" if value >= 1 - 5e-13 else f"{math.floor(1e4 * value) / 1e4:.4f}"  # never rounded up to what it is not


def percent(part, whole):
    return f"{100 * part / whole:.1f} %"


def nats(value):
    return "0" if abs(value) < 1e-12 else f"{value:.1e}" if abs(value) < 1e-3 else f"{value:.3f}"


def in_order(rows, key):
    return list(dict.fromkeys(row[key] for row in rows))


def answer_rows(rows):
    for answer in in_order(rows, "answer"):
        for family in ["all", *in_order(rows, "family")]:
            found = [r for r in rows if r["answer"] == answer and family in ("all", r["family"])]
            shares = [float(r["share_of_optimum"]) for r in found]
            optimal = sum(float(r["distance_nats"]) <= OPTIMAL for r in found)
            yield [answer if family == "all" else "", family, share(min(shares)), share(quantile(shares, 0.01)),
                   share(quantile(shares, 0.5)), percent(optimal, len(found))]  # fmt: skip


def bound_rows(rows):
    for answer in in_order(rows, "answer"):
        for family in ["all", *in_order(rows, "family")]:
            distances = [float(r["distance_nats"]) for r in rows if r["answer"] == answer and family in ("all", r["family"])]
            tight = sum(distance <= TIGHT for distance in distances)
            yield [answer if family == "all" else "", family, *(nats(value) for value in (
                min(distances), quantile(distances, 0.01), quantile(distances, 0.5), quantile(distances, 0.99),
                max(distances))), percent(tight, len(distances))]  # fmt: skip


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    with open(sys.argv[1], newline="") as file:
        rows = list(csv.DictReader(file))
    answers = [r for r in rows if not r["answer"].startswith("upper_bound")]
    bounds = [r for r in rows if r["answer"].startswith("upper_bound")]
    problems = sum(r["answer"] == "greedy" for r in answers)
    large = sum(r["answer"] == "greedy" and int(r["n"]) >= 14 for r in answers)
    replace_between(ROOT / "docs/trust.md", "exhaustive", [
        f"{problems} problems (an instance and a budget that leaves a choice), {large} of them of 14 to 16 candidates.",
        "",
        "The gain of log det over the prior, as a share of the optimum's:",
        "",
        *table(["answer", "family", "least", "1 %", "median", "optimal"], answer_rows(answers)),
        "",
        f"`upper_bound` less the optimum, nats (tight: within {TIGHT:.0e}):",
        "",
        *table(["bound", "family", "least", "1 %", "median", "99 %", "most", "tight"], bound_rows(bounds)),
        "",
        "`bench/exhaustive`; the same on every machine.",
    ])  # fmt: skip


if __name__ == "__main__":
    main()
