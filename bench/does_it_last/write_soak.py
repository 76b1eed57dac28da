#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Writes the results of maxlogdet_soak into docs/performance.md and results/soak.csv, or prints one line.

Usage: write_soak.py [--line] SOAK.json
"""

import pathlib
import sys

from maxlogdet_tools.files import json_of, write_csv
from maxlogdet_tools.pages import rewrite, table
from maxlogdet_tools.project import ROOT
from maxlogdet_tools.runs import stamp

RESULTS = pathlib.Path(__file__).parent / "results"
PAGE = ROOT / "docs/performance.md"


def microseconds(value):
    return f"{value:.0f}" if value >= 100 else f"{value:.1f}"


FRAME = "ordinary frame"
LATENCIES = ["p50_us", "p99_us", "p999_us", "max_us"]


def record_rows(result):
    """(phase, what, value) of every count."""
    yield from (("both", status, count) for status, count in result["statuses"].items())
    for phase in result["phases"]:
        yield from ((phase["phase"], key, value) for key, value in phase.items() if key not in ("phase", "latency"))
        for latency in phase["latency"]:
            yield from ((phase["phase"], f"{latency['class']}, {key}", latency[key]) for key in ("calls", *LATENCIES))


def phase_rows(phases):
    """A row per count, a column per phase."""
    counts = {"allocations in `select()`, count": "allocations_in_select", "malformed selections, count": "malformed"}
    for label, key in counts.items():
        yield [label, *(f"{phase[key]}" for phase in phases)]
    yield ["growth of memory after the first tenth, KiB", *(f"{grown_kib(phase)}" for phase in phases)]
    frames = [next(latency for latency in phase["latency"] if latency["class"] == FRAME) for phase in phases]
    for label, key in {"median": "p50_us", "maximum": "max_us"}.items():
        yield [f"{FRAME}, {label}, µs", *(microseconds(frame[key]) for frame in frames)]


def grown_kib(phase):
    return phase["resident_kib_at_the_end"] - phase["resident_kib_at_a_tenth"]


def lines_of(result):
    phases = result["phases"]
    reason = result["mlockall"]
    locked = [] if reason == "permitted" else ["", f"This machine does not permit `mlockall`: {reason}."]
    header = ["result", *(f"{phase['selections']} selections, {phase['phase']}" for phase in phases)]
    return [*table(header, phase_rows(phases)), *locked]


def line_of(result):
    phases = result["phases"]
    total = lambda key: sum(phase[key] for phase in phases)
    frame = max((latency for phase in phases for latency in phase["latency"] if latency["class"] == FRAME),
                key=lambda latency: latency["p99_us"])  # fmt: skip
    grown = sum(map(grown_kib, phases))
    return (f"{result['selections']} selections, {total('allocations_in_select')} allocations, {grown} KiB grown, "
            f"{total('major_faults')} major faults; a frame p50 {microseconds(frame['p50_us'])}, "
            f"p99 {microseconds(frame['p99_us'])} us")  # fmt: skip


def main():
    if len(sys.argv) not in (2, 3) or sys.argv[1:-1] not in ([], ["--line"]):
        sys.exit(__doc__)
    result = json_of(sys.argv[-1])
    if len(sys.argv) == 3:
        print(line_of(result))
        return
    rewrite(PAGE, "soak", lines_of(result))
    stamp(PAGE, "does_it_last")
    write_csv(RESULTS / "soak.csv", ["phase", "what", "value"], record_rows(result))


if __name__ == "__main__":
    main()
