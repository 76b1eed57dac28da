#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Rewrites "Where the time goes" of docs/performance.md from the records beside this script.

Usage: write_tables.py [perf|callgrind|roofline]...    default: all
"""

import collections
import re
import sys

from maxlogdet_tools.files import ROOT, json_of
from maxlogdet_tools.pages import paragraph, rewrite, stamp, table

PAGE = ROOT / "docs/performance.md"
RECORDS = ROOT / "profiles"


def plain_name(symbol):
    """The name of a function without its namespace, template arguments, arguments and type."""
    symbol = symbol.replace("(anonymous namespace)::", "").replace("operator()", "call")
    while "<" in symbol and (shorter := re.sub(r"<[^<>]*>", "", symbol)) != symbol:
        symbol = shorter
    return symbol.split("(")[0].split()[-1].removeprefix("maxlogdet::")


def strategies_of(record, function):
    """By the name of each strategy in a record: the other lines, and the share of each function. `function`: matches a
    line with a share and a function."""
    body = "\n".join(line for line in (RECORDS / record).read_text().splitlines() if not line.startswith("#"))
    strategies = {}
    for first, *lines in (block.splitlines() for block in body.strip().split("\n\n")):
        name = re.fullmatch(r"(\w+): .*, \d+ gains evaluated, \w+", first)[1]  # of one_selection
        shares = collections.Counter()
        for found in filter(None, (re.fullmatch(function, line) for line in lines)):
            shares[plain_name(found[2])] += float(found[1])
        strategies[name] = lines, shares
    return strategies


def strategies():
    """The time and the instructions of each strategy, and the function that takes the largest share of the time."""
    first_of = lambda lines, end: next(line.split()[0] for line in lines if line.endswith(end))
    counted = strategies_of("callgrind.txt", r" *[0-9,]+ \( ?([0-9.]+)%\) +(?:[^ ]+: )?(.*\(.*)")
    isa = re.search(r", (\w+), valgrind", (RECORDS / "callgrind.txt").read_text())[1]
    rows = []
    for name, (lines, shares) in strategies_of("perf.txt", r" +([0-9.]+)%  (?:\[.\] )?(.*)").items():
        [(largest, share)] = shares.most_common(1)
        instructions = int(first_of(counted[name][0], "PROGRAM TOTALS").replace(",", ""))
        rows.append([name, f"{float(first_of(lines, 'us of processor time')):.1f}", f"{instructions / 1e3:.0f}",
                     f"`{largest}`", f"{share:.0f}"])  # fmt: skip
    return table(["n = 2000, k = 100", "time, µs", f"thousand instructions ({isa})", "largest function",
                  "of the time, %"], rows)  # fmt: skip


def roofline():
    record = json_of(RECORDS / "roofline.json")
    of_two_rows = next(found for found in record["full_round"] if found["rows"] == 2)
    return paragraph(
        f"A full round evaluates a gain of two rows in {of_two_rows['ns_per_gain']:.2f} ns, at",
        f"{100 * of_two_rows['share_of_peak']:.0f} % of the core's peak of fused multiply-adds. It loads",
        f"{of_two_rows['gb_s']:.0f} of at most {record['l2_gb_s']:.0f} GB/s from the L2 cache.",
    )


TABLES = {"perf": strategies, "callgrind": strategies, "roofline": roofline}


def main():
    names = sys.argv[1:] or list(TABLES)
    if any(name not in TABLES for name in names):
        sys.exit(__doc__)
    for name in names:
        rewrite(PAGE, TABLES[name].__name__, TABLES[name]())
    stamp(PAGE, "profiles")


if __name__ == "__main__":
    main()
