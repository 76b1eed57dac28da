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

PAGE = ROOT / "docs/profiles.md"
RECORDS = ROOT / "profiles"
MIN_SHARE = 3.0  # per cent, of the listed functions; the records have the others


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


def caption(header):
    return f"{header['machine']}, {header['compiler']}, {header['date']}; `{header['command']}`: {header['events']}."


def program_line(line):
    """Strategy, gains evaluated and instruction set of a line that one_selection printed."""
    match = re.fullmatch(r"(\w+): .*, (\d+) gains evaluated, (\w+)", line)
    if not match:
        sys.exit(f"expected a line of one_selection, not: {line}")
    return match.groups()


def shares(functions):
    """'name 76.2, other 20.8' of (name, per cent) pairs, equal names added, in descending order."""
    total = collections.Counter()
    for name, share in functions:
        total[name] += share
    return ", ".join(f"`{name}` {share:.1f}" for name, share in total.most_common() if share >= MIN_SHARE)


def perf():
    header, blocks = read_record(RECORDS / "perf.txt")
    rows, events = [], []
    for first, *lines in blocks:
        counts = dict(reversed(m.groups()) for m in (re.fullmatch(r" +([0-9.]+)  (\S.*)", line) for line in lines) if m)
        samples = [re.fullmatch(r" +([0-9.]+)%  (?:\[.\] )?(.*)", line) for line in lines]
        events = events or list(counts)
        strategy, _, isa = program_line(first)
        functions = shares((plain_name(m[2]), float(m[1])) for m in samples if m)
        values = [f"{float(counts[event]):.1f}" if event in counts else "" for event in events]
        rows.append([strategy, *values, functions])
    none = [i for i, event in enumerate(events, 1) if all(row[i] == "0.0" for row in rows)]
    titles = ["strategy", *events, "% of samples, by function"]
    kept = [i for i in range(len(titles)) if i not in none]
    zero = [f"0.0 in each: {', '.join(titles[i] for i in none)}."] if none else []
    return [*paragraph(caption(header), f"{isa}.", *zero), "",
            *table([titles[i] for i in kept], ([row[i] for i in kept] for row in rows))]  # fmt: skip


def callgrind():
    header, blocks = read_record(RECORDS / "callgrind.txt")
    rows = []
    for first, *lines in blocks:
        strategy, gains, _ = program_line(first)
        parts = [re.fullmatch(r" *([0-9,]+) \( ?([0-9.]+)%\) +(?:[^ ]+: )?(.*)", line) for line in lines]
        parts = [m for m in parts if m]
        total = int(parts[0][1].replace(",", ""))
        functions = shares((plain_name(m[3]), float(m[2])) for m in parts[1:])
        rows.append([strategy, f"{total:,}", f"{total / int(gains):.1f}", functions])
    titles = ["strategy", "instructions", "per gain evaluated", "% of instructions, by function"]
    return [*paragraph(caption(header)), "", *table(titles, rows)]


def roofline():
    record = json_of(RECORDS / "roofline.json")
    peaks = ", ".join(f"{isa} {peak:.0f}" for isa, peak in record["peak_gflops"].items())
    roofs = ", ".join(sorted({r["roof"] for r in record["full_round"]}))
    cells = lambda r: [f"{r['rows']}", r["isa"], f"{r['ns_per_gain']:.2f}", f"{r['gflops']:.1f}",
                       f"{r['gflops_median']:.1f}", f"{100 * r['share_of_peak']:.0f}",
                       f"{100 * r['share_of_slots']:.0f}", f"{r['intensity']:.2f}"]  # fmt: skip
    titles = ["rows", "ISA", "ns / gain", "GFLOP/s", "median", "% of peak", "% of FMA slots", "flop / byte"]
    return [
        *paragraph(
            f"{record['machine']}, {record['compiler']}, {record['date']}; `{record['command']}`: best of",
            f"{record['turns']} turns; full round of {record['candidates']}, {record['arithmetic']}.",
            f"Peak of float32 multiply-adds, GFLOP/s: {peaks}.",
            f"Loads: L1 {record['l1_gb_s']:.0f} GB/s ({record['l1_array_bytes'] // 1024} KiB),",
            f"L2 {record['l2_gb_s']:.0f} GB/s ({record['l2_array_bytes'] // 1024} KiB). Roof: {roofs}.",
        ),
        "",
        *table(titles, map(cells, record["full_round"])),
    ]


TABLES = {"perf": perf, "callgrind": callgrind, "roofline": roofline}


def main():
    names = sys.argv[1:] or list(TABLES)
    if any(name not in TABLES for name in names):
        sys.exit(__doc__)
    for name in names:
        rewrite(PAGE, name, TABLES[name]())


if __name__ == "__main__":
    main()
