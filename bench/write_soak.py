#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Writes what maxlogdet_soak found into docs/performance.md, or prints it in one line.

Usage: write_soak.py [--line] SOAK.json
"""

import datetime
import json
import os
import pathlib
import sys

from results import ROOT, cpu_model
from write_tables import replace_between, table


def microseconds(value):
    return f"{value:.0f}" if value >= 100 else f"{value:.1f}"


def memory_rows(phases):
    for phase in phases:
        grown = phase["resident_kib_at_the_end"] - phase["resident_kib_at_a_tenth"]
        yield [phase["phase"], f"{phase['selections']}", f"{phase['seconds']:.0f}", f"{phase['allocations_in_select']}",
               f"{phase['allocations_in_filling']}", f"{phase['resident_kib_at_a_tenth']}", f"{grown:+d}",
               f"{phase['minor_faults']}", f"{phase['major_faults']}", f"{phase['malformed']}"]  # fmt: skip


def latency_rows(phases):
    for phase in phases:
        for latency in phase["latency"]:
            times = [microseconds(latency[key]) for key in ("p50_us", "p99_us", "p999_us", "max_us")]
            yield [latency["class"], phase["phase"], f"{latency['calls']}", *times]


def lines_of(result):
    phases = result["phases"]
    statuses = ", ".join(f"`{name}` {count}" for name, count in result["statuses"].items())
    locked = "" if result["mlockall"] == "permitted" else f"This machine does not permit mlockall: {result['mlockall']}."
    return [
        f"{result['selections']} selections, seed {result['seed']}. How they ended: {statuses}.",
        *([locked] if locked else []),
        "",
        *table(["", "selections", "seconds", "allocations in `select()`", "in filling stores", "resident KiB at 10 %",
                "growth until the end, KiB", "minor faults", "major faults", "malformed"], memory_rows(phases)),  # fmt: skip
        "",
        *table(["latency", "", "calls", "p50 µs", "p99 µs", "p99.9 µs", "max µs"], latency_rows(phases)),
        "",
        f"{cpu_model()}, {os.cpu_count()} cores, {result['isa']}, {result['compiler']}, maxlogdet {result['version']}, "
        f"{datetime.date.today()}, load {result['load_before']:.1f} before; `bench/soak`.",
    ]


def line_of(result):
    phases = result["phases"]
    total = lambda key: sum(phase[key] for phase in phases)
    frame = max((latency for phase in phases for latency in phase["latency"] if latency["class"] == "ordinary frame"),
                key=lambda latency: latency["p99_us"])  # fmt: skip
    grown = total("resident_kib_at_the_end") - total("resident_kib_at_a_tenth")
    return (f"{result['selections']} selections, {total('allocations_in_select')} allocations, {grown} KiB grown, "
            f"{total('major_faults')} major faults; a frame p50 {microseconds(frame['p50_us'])}, "
            f"p99 {microseconds(frame['p99_us'])} us")  # fmt: skip


def main():
    if len(sys.argv) not in (2, 3) or sys.argv[1:-1] not in ([], ["--line"]):
        sys.exit(__doc__)
    result = json.loads(pathlib.Path(sys.argv[-1]).read_text())
    if len(sys.argv) == 3:
        print(line_of(result))
        return
    replace_between(ROOT / "docs/performance.md", "soak", lines_of(result))


if __name__ == "__main__":
    main()
