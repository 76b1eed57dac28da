#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Runs maxlogdet_search_tables, records its tables in results, and shows a part in docs/performance.md.

Usage: write_search_tables.py PROGRAM [NAME]    NAME: only that table, as the program calls it
"""

import pathlib
import subprocess
import sys

from maxlogdet_tools.files import write_csv
from maxlogdet_tools.pages import paragraph, rewrite, table
from maxlogdet_tools.project import ROOT
from maxlogdet_tools.runs import stamp

RESULTS = pathlib.Path(__file__).parent / "results"
PAGE = ROOT / "docs/performance.md"
BUDGETS = ["60", "100", "200", "500"]
CELLS = [f"{what}_k_{k}" for k in BUDGETS for what in ("speed_up", "delta_nats")]
GAPS = ["gap", "gap_1_pass", "gap_8_passes"]
STRATEGIES = ["greedy", "lazy_greedy", "stochastic_greedy"]
COLUMNS = {
    "denormals": ["blocks", "candidates", *(f"{strategy}_{what}" for strategy in STRATEGIES
                                            for what in ("us", "ratio"))],
    "exchange": ["n", "k", "gain_1_sweep", "gain_2_sweeps", "gain_4_sweeps", "max_gain", "improved", "us",
                 "more_us_1_sweep", "more_us_2_sweeps", "more_us_4_sweeps"],
    "backward": ["n", "share", "lazy_greedy_us", "backward_greedy_us", "ratio", "min_ratio", "max_ratio",
                 "min_delta_nats", "max_delta_nats"],
    "stopping": ["strategy", "n", "k", "us", "more_us_deviations", "more_us_efficiency", "min_more_us_efficiency",
                 "max_more_us_efficiency"],
    "deadline": ["n", "k", "us", "us_without_time", "lost_nats", "max_lost_nats", "random_lost_nats",
                 "max_random_lost_nats"],
    "certificates": ["family", "blocks", *(f"{gap}_k_{k}" for k in ("20", "100") for gap in GAPS), "bound_us",
                     "pass_us"],
    "largest_gaps": ["k", "n", *GAPS],
    "relaxed": ["family", "blocks", "n", *CELLS],
    "relaxed_over_n": ["n", *CELLS],
    "relaxed_frames": ["family", "selections", "min_delta_nats", "mean_delta_nats", "max_delta_nats",
                       "below_minus_0.001"],
}  # fmt: skip


def tables_of(lines):
    """The rows of each table by name, as dictionaries; other lines stand before the first table."""
    tables, name = {}, None
    for line in lines:
        if line.startswith("table "):
            name = line.split(" ", 1)[1]
            tables[name] = []
        elif line.startswith("| "):  # a cell may hold two numbers
            cells = [part for cell in line.strip("| ").split(" | ") for part in cell.split(", ")]
            tables[name].append(dict(zip(COLUMNS[name], cells)))
    return {name: rows[1:] for name, rows in tables.items()}  # without the header


def in_order(rows, key):
    return list(dict.fromkeys(row[key] for row in rows))


def picked(rows, columns):
    return ([row[column] for column in columns] for row in rows)


def largest(rows, *columns):
    return max((row[column] for row in rows for column in columns), key=float)


def smallest(rows, *columns):
    return min((row[column] for row in rows for column in columns), key=float).replace("-0.0000", "+0.0000")


def exchange(tables):
    rows = [row for row in tables["exchange"] if row["n"] == "2000" and row["k"] in ("6", "20", "100")]
    header = ["k", "`lazy_greedy`, mean, µs", "one sweep: additional, mean, µs", "one sweep: added log det, mean, nats"]
    return table(header, picked(rows, ["k", "us", "more_us_1_sweep", "gain_1_sweep"]))


def stopping(tables):
    rows = [row for row in tables["stopping"] if row["strategy"] == "lazy_greedy"]
    header = ["n", "no target, mean, µs", "translation and rotation sigma: additional, mean, µs",
              "efficiency: additional, mean, µs"]  # fmt: skip
    return table(header, picked(rows, ["n", "us", "more_us_deviations", "more_us_efficiency"]))


def deadline(tables):
    rows = [row for row in tables["deadline"] if row["k"] == "100"]
    header = ["n", "no limit, mean, µs", "limit of 1 ns, mean, µs", "filled: loss, mean, nats",
              "filled: loss, largest, nats", "random: loss, mean, nats"]  # fmt: skip
    return table(header, picked(rows, ["n", "us", "us_without_time", "lost_nats", "max_lost_nats", "random_lost_nats"]))


def backward(tables):
    shares = ["0.5", "0.7", "0.9"]
    rows = tables["backward"]
    faster = {(row["n"], row["share"]): f"{1 / float(row['ratio']):.1f}" for row in rows}
    header = ["n", *(f"k = {share} n (ratio)" for share in shares)]
    many = [row for row in rows if float(row["share"]) >= 0.7]
    lower = f"{max(-float(smallest(many, 'min_delta_nats')), 0):g}"
    return [
        *table(header, ([n, *(faster[n, share] for share in shares)] for n in ("200", "2000"))),
        "",
        *paragraph(
            f"In every problem with k ≥ 0.7 n, `lazy_greedy` took at least {1 / float(largest(many, 'max_ratio')):.1f}",
            f"times as long as `backward_greedy`. The largest loss of `backward_greedy` was {lower} nats.",
        ),
    ]


def certificates(tables):
    gaps = next(row for row in tables["largest_gaps"] if row["n"] == "2000" and row["k"] == "100")
    added = [row for row in tables["certificates"] if "equal" not in row["family"]]
    return paragraph(
        f"In the 16 problems with n = 2000 and k = 100, computing the bound took {smallest(added, 'bound_us')} to",
        f"{largest(added, 'bound_us')} µs, and each pass took {smallest(added, 'pass_us')} to",
        f"{largest(added, 'pass_us')} µs. `upper_bound` exceeded the log det of `lazy_greedy` by at most",
        f"{gaps['gap']} nats without passes, and by at most {gaps['gap_8_passes']} nats after 8 passes.",
    )


def relaxed(tables):
    rows = [row for row in tables["relaxed"] if "equal" not in row["family"]]
    of = lambda n: [row for row in rows if row["n"] == n]
    cells = lambda found: [pick(found, *columns)
                           for columns in (CELLS[::2], CELLS[1::2]) for pick in (smallest, largest)]  # fmt: skip
    header = ["n", *(f"`lazy_greedy` ÷ `relaxed`, {which} (ratio)" for which in ("smallest", "largest")),
              "log det minus that of `lazy_greedy`, lowest, nats", "the same, highest, nats"]  # fmt: skip
    return table(header, ([n, *cells(of(n))] for n in in_order(rows, "n")))


# The tables of each section of the page; the others are only recorded.
SECTIONS = {
    exchange: ["exchange"],
    stopping: ["stopping"],
    deadline: ["deadline"],
    backward: ["backward"],
    certificates: ["certificates", "largest_gaps"],
    relaxed: ["relaxed"],
}


def main():
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    output = subprocess.run(sys.argv[1:], check=True, stdout=subprocess.PIPE, text=True).stdout
    tables = tables_of(output.splitlines())
    for name, rows in tables.items():
        write_csv(RESULTS / f"{name}.csv", COLUMNS[name], (row.values() for row in rows))
    for section, names in SECTIONS.items():
        if all(name in tables for name in names):
            rewrite(PAGE, section.__name__, section(tables))
    if len(sys.argv) == 2:
        stamp(PAGE, "how_good")


if __name__ == "__main__":
    main()
