#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Rewrites the tables of docs/profiles.md from the records beside this script.

Usage: write_tables.py [perf|callgrind|roofline]...    default: all
"""

import collections
import re
import sys

from maxlogdet_tools.files import ROOT, json_of
from maxlogdet_tools.pages import paragraph, rewrite, stamp, table

PAGE = ROOT / "docs/profiles.md"
RECORDS = ROOT / "profiles"


def plain_name(symbol):
    """The name of a function without its namespace, template arguments, arguments and type."""
    symbol = symbol.replace("(anonymous namespace)::", "").replace("operator()", "call")
    while "<" in symbol and (shorter := re.sub(r"<[^<>]*>", "", symbol)) != symbol:
        symbol = shorter
    return symbol.split("(")[0].split()[-1].removeprefix("maxlogdet::")


def strategies_of(record, function):
    """Of each strategy in a record: its name, the gains evaluated, the other lines, and the cells of the function with the
    largest share. `function`: matches a line with a share and a function."""
    body = "\n".join(line for line in (RECORDS / record).read_text().splitlines() if not line.startswith("#"))
    for first, *lines in (block.splitlines() for block in body.strip().split("\n\n")):
        name, gains = re.fullmatch(r"(\w+): .*, (\d+) gains evaluated, \w+", first).groups()  # of one_selection
        shares = collections.Counter()
        for found in filter(None, (re.fullmatch(function, line) for line in lines)):
            shares[plain_name(found[2])] += float(found[1])
        [(largest, share)] = shares.most_common(1)
        yield name, int(gains), lines, [f"`{largest}`", f"{share:.0f}"]


def perf():
    rows = []
    for name, _, lines, largest in strategies_of("perf.txt", r" +([0-9.]+)%  (?:\[.\] )?(.*)"):
        time = next(line.split()[0] for line in lines if line.endswith("us of processor time"))
        rows.append([name, f"{float(time):.1f}", *largest])
    return table(["strategy", "time, µs", "largest function", "its share, %"], rows)


def callgrind():
    rows = []
    function = r" *[0-9,]+ \( ?([0-9.]+)%\) +(?:[^ ]+: )?(.*\(.*)"
    for name, gains, lines, largest in strategies_of("callgrind.txt", function):
        total = int(next(line.split()[0] for line in lines if line.endswith("PROGRAM TOTALS")).replace(",", ""))
        rows.append([name, f"{total / 1e3:.0f}", f"{total / gains:.1f}", *largest])
    return table(["strategy", "instructions, thousand", "a gain, count", "largest function", "its share, %"], rows)


def roofline():
    record = json_of(RECORDS / "roofline.json")
    rounds = record["full_round"]
    rows = ([f"{r['rows']}", f"{r['ns_per_gain']:.2f}", f"{100 * r['share_of_peak']:.0f}",
             f"{100 * r['share_of_slots']:.0f}"] for r in rounds)  # fmt: skip
    return [
        *table(["rows", "a gain, ns", "of the peak, %", "of the slots, %"], rows),
        "",
        *paragraph(f"Loads from the L2 cache reach {record['l2_gb_s']:.0f} GB/s, and these rounds take at most",
                   f"{max(r['gb_s'] for r in rounds):.0f} GB/s."),
    ]  # fmt: skip


TABLES = {"perf": perf, "callgrind": callgrind, "roofline": roofline}


def main():
    names = sys.argv[1:] or list(TABLES)
    if any(name not in TABLES for name in names):
        sys.exit(__doc__)
    for name in names:
        rewrite(PAGE, name, TABLES[name]())
        stamp(PAGE, f"profiles {name}")


if __name__ == "__main__":
    main()
