#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Rewrites the tables of docs/profiles.md from the records beside this script.

Usage: write_tables.py [perf|callgrind|roofline]...    default: all
"""

import collections
import re
import sys

from maxlogdet_tools.files import json_of
from maxlogdet_tools.pages import paragraph, rewrite, table
from maxlogdet_tools.project import ROOT
from maxlogdet_tools.runs import stamp

PAGE = ROOT / "docs/profiles.md"
RECORDS = ROOT / "profiles"


def plain_name(symbol):
    """The name of a function without its namespace, template arguments, arguments and type."""
    symbol = symbol.replace("(anonymous namespace)", "").replace("operator()", "call")
    kept, depth = "", 0
    for letter in symbol:
        depth += letter == "<"
        if depth == 0:
            kept += letter
        depth -= letter == ">"
    words = kept.split("(")[0].split()
    return words[-1].removeprefix("::").removeprefix("maxlogdet::") if words else symbol


def read_record(path):
    """The header as a dictionary, and the lines of each strategy, of which the first is the output of the program."""
    lines = path.read_text().splitlines()
    header = dict(line[2:].split(": ", 1) for line in lines if line.startswith("# "))
    body = "\n".join(line for line in lines if not line.startswith("#"))
    return header, [block.splitlines() for block in body.strip().split("\n\n")]


def program_line(line):
    """Strategy and gains evaluated of a line that one_selection printed."""
    match = re.fullmatch(r"(\w+): .*, (\d+) gains evaluated, \w+", line)
    if not match:
        sys.exit(f"expected a line of one_selection, not: {line}")
    return match.groups()


def largest(functions):
    """The two functions of the largest shares in (name, per cent) pairs, equal names added, and their shares."""
    total = collections.Counter()
    for name, share in functions:
        total[name] += share
    return [cell for name, share in total.most_common(2) for cell in (f"`{name}`", f"{share:.0f}")]


LARGEST = ["first function", "its share, %", "second function", "its share, %"]


def perf():
    header, blocks = read_record(RECORDS / "perf.txt")
    rows = []
    for first, *lines in blocks:
        time = next(m[1] for m in (re.fullmatch(r" +([0-9.]+)  us of processor time", line) for line in lines) if m)
        samples = [re.fullmatch(r" +([0-9.]+)%  (?:\[.\] )?(.*)", line) for line in lines]
        functions = largest((plain_name(m[2]), float(m[1])) for m in samples if m)
        rows.append([program_line(first)[0], f"{float(time):.1f}", *functions])
    return [*paragraph(f"Sampled by {header['events'].split(':')[0]}."), "",
            *table(["strategy", "processor time, µs", *LARGEST], rows)]


def callgrind():
    _, blocks = read_record(RECORDS / "callgrind.txt")
    rows = []
    for first, *lines in blocks:
        strategy, gains = program_line(first)
        parts = [re.fullmatch(r" *([0-9,]+) \( ?([0-9.]+)%\) +(?:[^ ]+: )?(.*)", line) for line in lines]
        parts = [m for m in parts if m]
        total = int(parts[0][1].replace(",", ""))
        functions = largest((plain_name(m[3]), float(m[2])) for m in parts[1:])
        rows.append([strategy, f"{total / 1e3:.0f}", f"{total / int(gains):.1f}", *functions[:2]])
    return table(["strategy", "thousand instructions", "instructions a gain", *LARGEST[:2]], rows)


def roofline():
    record = json_of(RECORDS / "roofline.json")
    cells = lambda r: [f"{r['rows']}", r["isa"], f"{r['ns_per_gain']:.2f}", f"{r['gflops']:.0f}",
                       f"{100 * r['share_of_peak']:.0f}", f"{100 * r['share_of_slots']:.0f}"]  # fmt: skip
    return table(["rows", "instruction set", "a gain, ns", "GFLOP/s", "of the peak, %", "of the slots, %"],
                 map(cells, record["full_round"]))


TABLES = {"perf": perf, "callgrind": callgrind, "roofline": roofline}


def main():
    names = sys.argv[1:] or list(TABLES)
    if any(name not in TABLES for name in names):
        sys.exit(__doc__)
    for name in names:
        rewrite(PAGE, name, TABLES[name]())
    stamp(PAGE, "bench/run profiles")


if __name__ == "__main__":
    main()
