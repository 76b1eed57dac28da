#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Rewrites the tables of docs/profiles.md from the records beside this script.

Usage: write_tables.py [perf|callgrind|roofline]...    default: all
"""

import collections
import re
import sys

from maxlogdet_tools.files import json_of
from maxlogdet_tools.pages import rewrite, table
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


def blocks_of(path):
    """The lines of each strategy of a record, of which the first is the output of the program."""
    body = "\n".join(line for line in path.read_text().splitlines() if not line.startswith("#"))
    return [block.splitlines() for block in body.strip().split("\n\n")]


def program_line(line):
    """Strategy and gains evaluated of a line that one_selection printed."""
    match = re.fullmatch(r"(\w+): .*, (\d+) gains evaluated, \w+", line)
    if not match:
        sys.exit(f"expected a line of one_selection, not: {line}")
    return match.groups()


def largest(functions):
    """The function of the largest share in (name, per cent) pairs, equal names added, and its share."""
    total = collections.Counter()
    for name, share in functions:
        total[name] += share
    [(name, share)] = total.most_common(1)
    return [f"`{name}`", f"{share:.0f}"]


LARGEST = ["largest function", "its share, %"]


def perf():
    rows = []
    for first, *lines in blocks_of(RECORDS / "perf.txt"):
        time = next(m[1] for m in (re.fullmatch(r" +([0-9.]+)  us of processor time", line) for line in lines) if m)
        samples = [re.fullmatch(r" +([0-9.]+)%  (?:\[.\] )?(.*)", line) for line in lines]
        functions = largest((plain_name(m[2]), float(m[1])) for m in samples if m)
        rows.append([program_line(first)[0], f"{float(time):.1f}", *functions])
    return table(["strategy", "time, µs", *LARGEST], rows)


def callgrind():
    rows = []
    for first, *lines in blocks_of(RECORDS / "callgrind.txt"):
        strategy, gains = program_line(first)
        parts = [re.fullmatch(r" *([0-9,]+) \( ?([0-9.]+)%\) +(?:[^ ]+: )?(.*)", line) for line in lines]
        parts = [m for m in parts if m]
        total = int(parts[0][1].replace(",", ""))
        functions = largest((plain_name(m[3]), float(m[2])) for m in parts[1:])
        rows.append([strategy, f"{total / 1e3:.0f}", f"{total / int(gains):.1f}", *functions])
    return table(["strategy", "instructions, thousand", "a gain, count", *LARGEST], rows)


def roofline():
    record = json_of(RECORDS / "roofline.json")
    cells = lambda r: [f"{r['rows']}", r["isa"], f"{r['ns_per_gain']:.2f}", f"{100 * r['share_of_peak']:.0f}",
                       f"{100 * r['share_of_slots']:.0f}"]  # fmt: skip
    return table(["rows", "instruction set", "a gain, ns", "of the peak, %", "of the slots, %"],
                 map(cells, (r for r in record["full_round"] if r["isa"] != "sse2")))


TABLES = {"perf": perf, "callgrind": callgrind, "roofline": roofline}


def main():
    names = sys.argv[1:] or list(TABLES)
    if any(name not in TABLES for name in names):
        sys.exit(__doc__)
    for name in names:
        rewrite(PAGE, name, TABLES[name]())
    stamp(PAGE, "profiles")


if __name__ == "__main__":
    main()
