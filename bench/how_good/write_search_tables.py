#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Runs maxlogdet_search_tables, records its tables in bench/results, and shows a part in docs/performance.md.

Usage: write_search_tables.py PROGRAM [NAME]    NAME: only that table, as the program calls it
"""

import datetime
import os
import subprocess
import sys

from maxlogdet_tools.pages import paragraph, rewrite, table
from maxlogdet_tools.project import ROOT, cpu_model
from records import record_run, unless_on_page, write_record

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


def facts_and_tables(lines):
    """The lines "KEY VALUE" before the first table, and the rows of each table by name, as dictionaries."""
    facts, tables, name = {}, {}, None
    for line in lines:
        if line.startswith("table "):
            name = line.split(" ", 1)[1]
            tables[name] = []
        elif name is None:
            key, value = line.split(" ", 1)
            facts[key] = value
        elif line.startswith("| "):  # a cell may hold two numbers
            cells = [part for cell in line.strip("| ").split(" | ") for part in cell.split(", ")]
            tables[name].append(dict(zip(COLUMNS[name], cells)))
    return facts, {name: rows[1:] for name, rows in tables.items()}  # without the header


def in_order(rows, key):
    return list(dict.fromkeys(row[key] for row in rows))


def picked(rows, columns):
    return ([row[column] for column in columns] for row in rows)


def extremes(rows, columns):
    """'MINIMUM to MAXIMUM' of some columns."""
    values = sorted((row[column] for row in rows for column in columns), key=float)
    return " to ".join(value.replace("-0.0000", "+0.0000") for value in (values[0], values[-1]))


def exchange(tables):
    rows = [row for row in tables["exchange"] if row["k"] in ("6", "20", "100")]
    columns = {"n": "n", "k": "k", "mean gain, 1 sweep": "gain_1_sweep", "4 sweeps": "gain_4_sweeps",
               "largest": "max_gain", "frames improved": "improved", "µs without": "us",
               "more µs, 1 sweep": "more_us_1_sweep", "more µs, 4 sweeps": "more_us_4_sweeps"}  # fmt: skip
    return table(list(columns), picked(rows, columns.values()))


def stopping(tables):
    header = ["strategy", "n", "µs without", "more µs, both deviations", "efficiency", "the same, slowest frame"]
    columns = ["strategy", "n", "us", "more_us_deviations", "more_us_efficiency", "max_more_us_efficiency"]
    return table(header, picked(tables["stopping"], columns))


def deadline(tables):
    header = ["n", "k", "µs without a limit", "µs with 1 ns", "nats lost, mean", "worst", "by random ones, mean", "worst"]
    return table(header, picked(tables["deadline"], COLUMNS["deadline"]))


def backward(tables):
    rows = tables["backward"]
    shares = ["0.3", "0.5", "0.6", "0.7", "0.9"]
    cells = {(row["n"], row["share"]): f"{row['ratio']} ({row['max_ratio']})" for row in rows}
    header = ["n", *(f"k = {share} n" for share in shares)]
    lines = table(header, ([n, *(cells[n, share] for share in shares)] for n in in_order(rows, "n")))
    few, many = ([r for r in rows if (float(r["share"]) < 0.7) == is_few] for is_few in (True, False))
    deltas = [extremes(part, ["min_delta_nats", "max_delta_nats"]) for part in (few, many)]
    return [*lines, "", f"Δ log det of single frames, nats: {deltas[0]} below k = 0.7 n, {deltas[1]} from there on."]


def largest(rows, *columns):
    return max((row[column] for row in rows for column in columns), key=float)


def certificates(tables):
    rows = [row for row in tables["certificates"] if "equal" not in row["family"]]
    equal = [row for row in tables["certificates"] if "equal" in row["family"]]
    columns = [f"{gap}_k_{k}" for k in ("20", "100") for gap in GAPS]
    of = lambda family: [row for row in rows if row["family"] == family]
    lines = [[family, *(largest(of(family), column) for column in columns)] for family in in_order(rows, "family")]
    sizes = tables["largest_gaps"]
    for n in in_order(sizes, "n"):
        if n != "2000":  # the largest of the rows above
            lines.append([f"all, n = {n}", *(row[gap] for row in sizes if row["n"] == n for gap in GAPS)])
    header = ["family", "k = 20: gap", "1 pass", "8 passes", "k = 100: gap", "1 pass", "8 passes"]
    return [
        *table(header, lines),
        "",
        *paragraph(
            f"With k = 100 the bound adds {extremes(rows, ['bound_us'])} µs to a selection, a pass",
            f"{extremes(rows, ['pass_us'])} µs. With equal and nearly equal gains the largest gap is",
            f"{largest(equal, *columns)}, and times drown in the noise of the selection.",
        ),
    ]


def relaxed(tables):
    rows = tables["relaxed"]
    speed_ups, deltas = CELLS[::2], CELLS[1::2]
    sizes = in_order(rows, "n")
    of = lambda family, n: [row for row in rows if (row["family"], row["n"]) == (family, n)]
    cells = lambda family: (extremes(of(family, n), columns) for n in sizes for columns in (speed_ups, deltas))
    header = ["family", *(f"{what}n = {n}" for n in sizes for what in ("speed-up, ", "Δ log det, "))]
    over_n = [row for row in tables["relaxed_over_n"] if row["n"] in ("2000", "10000", "20000", "50000")]
    frames = tables["relaxed_frames"]
    means = ", ".join(f"{row['mean_delta_nats']} ({row['family']})" for row in frames)
    below = sum(int(row["below_minus_0.001"]) for row in frames)
    return [
        *table(header, ([family, *cells(family)] for family in in_order(rows, "family"))),
        "",
        *paragraph(
            f"On EuRoC-like frames with 2 rows and k = {' / '.join(BUDGETS)} the speed-up is",
            ", ".join(f"{' / '.join(row[column] for column in speed_ups)} at n = {row['n']}" for row in over_n) + ".",
            f"Over 20 other frames of each family (n = 1000 to 20000, {frames[0]['selections']} selections) the mean",
            f"Δ log det is {means};",
            f"the range is {extremes(frames, ['min_delta_nats', 'max_delta_nats'])}, with {below} below -0.001.",
        ),
    ]


def denormals(tables):
    rows = tables["denormals"]
    ratios = lambda row: " / ".join(row[f"{strategy}_ratio"] for strategy in STRATEGIES)
    parts = [f"{ratios(row)} ({row['candidates']}, {row['blocks'].replace('_', ' ')})"
             for row in rows if "denormal" in row["candidates"]]  # fmt: skip
    return paragraph(f"Ratios of `greedy` / `lazy_greedy` / `stochastic_greedy`: {', '.join(parts)}.")


# The tables of each section of the page.
SECTIONS = {
    exchange: ["exchange"],
    stopping: ["stopping"],
    deadline: ["deadline"],
    backward: ["backward"],
    certificates: ["certificates", "largest_gaps"],
    relaxed: ["relaxed", "relaxed_over_n", "relaxed_frames"],
    denormals: ["denormals"],
}


def main():
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    load = os.getloadavg()[0]  # before the program loads the machine itself
    output = subprocess.run(sys.argv[1:], check=True, stdout=subprocess.PIPE, text=True).stdout
    facts, tables = facts_and_tables(output.splitlines())
    for name, rows in tables.items():
        write_record(f"{name}.csv", COLUMNS[name], (row.values() for row in rows))
    machine = (
        f"{cpu_model()}, {os.cpu_count()} cores, {facts['isa']}, {facts['compiler']}, one thread, "
        f"{datetime.date.today()}, load {load:.1f}; `bench/run how_fast`."
    )
    page = ROOT / "docs/performance.md"
    for section, names in SECTIONS.items():
        if all(name in tables for name in names):
            rewrite(page, section.__name__, [*section(tables), *unless_on_page(page, machine)])
            record_run(names, machine)


if __name__ == "__main__":
    main()
