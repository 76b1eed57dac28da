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
STRATEGIES = ["greedy", "lazy_greedy", "stochastic_greedy"]
COLUMNS = {
    "denormals": ["blocks", "candidates", *(f"{strategy}_{what}" for strategy in STRATEGIES
                                            for what in ("us", "ratio"))],
    "stopping": ["strategy", "n", "k", "us", "more_us_deviations", "more_us_efficiency", "min_more_us_efficiency",
                 "max_more_us_efficiency"],
    "deadline": ["n", "k", "us", "us_without_time", "lost_nats", "max_lost_nats", "random_lost_nats",
                 "max_random_lost_nats"],
    "certificates": ["family", "blocks", "gap_k_20", "gap_k_100", "bound_us"],
    "largest_gaps": ["k", "n", "gap"],
}  # fmt: skip


def tables_of(lines):
    """The rows of each table by name, as dictionaries; other lines stand before the first table."""
    tables, name = {}, None
    for line in lines:
        if line.startswith("table "):
            name = line.split(" ", 1)[1]
            tables[name] = []
        elif line.startswith("| "):
            tables[name].append(dict(zip(COLUMNS[name], line.strip("| ").split(" | "))))
    return {name: rows[1:] for name, rows in tables.items()}  # without the header


def picked(rows, columns):
    return ([row[column] for column in columns] for row in rows)


def largest(rows, column):
    return max((row[column] for row in rows), key=float)


def smallest(rows, column):
    return min((row[column] for row in rows), key=float)


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


def certificates(tables):
    gaps = next(row for row in tables["largest_gaps"] if row["n"] == "2000" and row["k"] == "100")
    added = [row for row in tables["certificates"] if "equal" not in row["family"]]
    return paragraph(
        f"In the 16 problems with n = 2000 and k = 100, computing the bound took {smallest(added, 'bound_us')} to",
        f"{largest(added, 'bound_us')} µs, and `upper_bound` exceeded the log det of `lazy_greedy` by at most",
        f"{gaps['gap']} nats.",
    )


# The tables of each section of the page; the others are only recorded.
SECTIONS = {
    stopping: ["stopping"],
    deadline: ["deadline"],
    certificates: ["certificates", "largest_gaps"],
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
