#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Writes the distances of answers and bounds from the best of all subsets: by family of instances into results,
over all families into docs/trust.md.

Usage: write_exhaustive.py EXHAUSTIVE.csv    (of tests/core/exhaustive_test.cpp)
"""

import math
import pathlib
import sys

from maxlogdet_tools.files import rows_of, write_csv
from maxlogdet_tools.pages import paragraph, rewrite, table
from maxlogdet_tools.project import ROOT
from maxlogdet_tools.runs import stamp

RESULTS = pathlib.Path(__file__).parent / "results"
PAGE = ROOT / "docs/trust.md"
OPTIMAL = 1e-10  # nats: the tolerance of the test for its own rounding
TIGHT = 1e-6  # nats


def quantile(values, share):
    """Nearest-rank quantile."""
    return sorted(values)[max(0, math.ceil(share * len(values)) - 1)]


def share(value):
    return "1" if value >= 1 - 5e-13 else f"{math.floor(1e4 * value) / 1e4:.4f}"  # rounded down


def percent(part, whole):
    return f"{100 * part / whole:.1f}"


def nats(value):
    return "0" if abs(value) < 1e-12 else f"{value:.1e}" if abs(value) < 1e-3 else f"{value:.3f}"


def in_order(rows, key):
    return list(dict.fromkeys(row[key] for row in rows))


def by_family(rows):
    """(answer, family, rows) for each answer; the first family is `all`."""
    for answer in in_order(rows, "answer"):
        for family in ["all", *in_order(rows, "family")]:
            yield answer, family, [r for r in rows if r["answer"] == answer and family in ("all", r["family"])]


def answer_summaries(rows):
    for answer, family, found in by_family(rows):
        shares = [float(r["share_of_optimum"]) for r in found]
        optimal = sum(float(r["distance_nats"]) <= OPTIMAL for r in found)
        yield {"answer": answer, "family": family, "minimum": share(min(shares)),
               "one_percent": share(quantile(shares, 0.01)), "median": share(quantile(shares, 0.5)),
               "optimal_percent": percent(optimal, len(found))}  # fmt: skip


def bound_summaries(rows):
    for bound, family, found in by_family(rows):
        distances = [float(r["distance_nats"]) for r in found]
        tight = sum(distance <= TIGHT for distance in distances)
        yield {"bound": bound, "family": family, "minimum": nats(min(distances)),
               "one_percent": nats(quantile(distances, 0.01)), "median": nats(quantile(distances, 0.5)),
               "99_percent": nats(quantile(distances, 0.99)), "maximum": nats(max(distances)),
               "tight_percent": percent(tight, len(distances))}  # fmt: skip


def record(name, summaries):
    write_csv(RESULTS / f"{name}.csv", summaries[0].keys(), (summary.values() for summary in summaries))


def short(text):
    """A number of nats in a few digits."""
    value = float(text)
    return text if value < 1e4 else f"{value:.0e}".replace("e+0", "e").replace("e+", "e")


def page_lines(answers, bounds, problems, large):
    alike = {}  # answers with the same figures share a row
    for s in (s for s in answers if s["family"] == "all"):
        cells = (s["minimum"], s["one_percent"], s["optimal_percent"])
        alike.setdefault(cells, []).append(s["answer"])
    answer_rows = [[", ".join(names), *cells] for cells, names in alike.items()]
    distances = ["median", "99_percent", "maximum"]
    bound_rows = [[*(short(s[c]) for c in distances), s["tight_percent"]] for s in bounds if s["family"] == "all"]
    return [
        *paragraph(
            "A problem is an instance with a budget that leaves a choice.",
            f"Of the {problems} problems, {large} have 14 to 16 candidates.",
            "Shares are of the optimum's gain over the prior."),
        "",
        *table(["strategy", "lowest share (ratio)", "1 % quantile (ratio)", "optimal (%)"], answer_rows),
        "",
        *paragraph(f"The next table gives `upper_bound` less the optimum. A bound is tight within {TIGHT:.0e} nats."),
        "",
        *table(["median (nats)", "99 % quantile (nats)", "maximum (nats)", "tight (%)"], bound_rows),
    ]


def write(answers, bounds, problems, large):
    record("exhaustive_answers", answers)
    record("exhaustive_bounds", bounds)
    rewrite(PAGE, "exhaustive", page_lines(answers, bounds, problems, large))
    stamp(PAGE, "how_good")


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    rows = rows_of(sys.argv[1])
    answers = [r for r in rows if not r["answer"].startswith("upper_bound")]
    bounds = [r for r in rows if r["answer"].startswith("upper_bound")]
    problems = sum(r["answer"] == "greedy" for r in answers)
    large = sum(r["answer"] == "greedy" and int(r["n"]) >= 14 for r in answers)
    write(list(answer_summaries(answers)), list(bound_summaries(bounds)), problems, large)


if __name__ == "__main__":
    main()
