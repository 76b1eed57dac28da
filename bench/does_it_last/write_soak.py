#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Writes the results of maxlogdet_soak into docs/performance.md and bench/results/soak.csv, or prints one line.

Usage: write_soak.py [--line] SOAK.json
"""

import datetime
import os
import sys

from maxlogdet_tools.files import json_of
from maxlogdet_tools.pages import rewrite, table
from maxlogdet_tools.project import ROOT, cpu_model
from records import record_run, unless_on_page, write_record


def microseconds(value):
    return f"{value:.0f}" if value >= 100 else f"{value:.1f}"


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
    pair = lambda *keys: [" / ".join(f"{phase[key]}" for key in keys) for phase in phases]
    grown = (p["resident_kib_at_the_end"] - p["resident_kib_at_a_tenth"] for p in phases)
    yield ["allocations in `select()` / in filling stores / malformed answers",
           *pair("allocations_in_select", "allocations_in_filling", "malformed")]  # fmt: skip
    yield ["resident KiB at 10 % / grown from there to the end",
           *(f"{p['resident_kib_at_a_tenth']} / {more:+d}" for p, more in zip(phases, grown))]  # fmt: skip
    yield ["minor / major page faults", *pair("minor_faults", "major_faults")]
    for classes in zip(*(phase["latency"] for phase in phases)):
        times = [" / ".join(microseconds(latency[key]) for key in LATENCIES) for latency in classes]
        yield [f"{classes[0]['class']}, µs: p50 / p99 / p99.9 / maximum", *times]


def lines_of(result):
    phases = result["phases"]
    usual = ("ok", "all_selected", "deadline_reached")
    statuses = result["statuses"]
    ended = ", ".join(f"`{name}` {statuses[name]}" for name in usual if name in statuses)
    others = [count for name, count in statuses.items() if name not in usual]
    reason = result["mlockall"]
    locked = [] if reason == "permitted" else [f"This machine does not permit mlockall: {reason}."]
    return [
        f"{result['selections']} selections, seed {result['seed']}: {ended}, {len(others)} other statuses "
        f"{sum(others)}.",
        *locked,
        "",
        *table(["", *(phase["phase"] for phase in phases)], phase_rows(phases)),
    ]


def machine(result):
    return (
        f"{cpu_model()}, {os.cpu_count()} cores, {result['isa']}, {result['compiler']}, maxlogdet {result['version']}, "
        f"{datetime.date.today()}, load {result['load_before']:.1f} before; `bench/run does_it_last`."
    )


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
    result = json_of(sys.argv[-1])
    if len(sys.argv) == 3:
        print(line_of(result))
        return
    page = ROOT / "docs/performance.md"
    rewrite(page, "soak", [*lines_of(result), *unless_on_page(page, machine(result))])
    record_run(["soak"], machine(result))
    write_record("soak.csv", ["phase", "what", "value"], record_rows(result))


if __name__ == "__main__":
    main()
