#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Rewrites the benchmark tables of README.md and docs/performance.md from Google Benchmark's JSON.

Usage: write_tables.py BENCH.json
A table stands between the lines '<!-- begin NAME -->' and '<!-- end NAME -->'.
"""

import json
import pathlib
import platform
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
BLOCKS = ["map_bias, 2 rows", "map_bias, stereo, 3 rows", "measurement, stereo, 3 rows"]
HEADER = [
    "| strategy | n | k | blocks | median µs | p99 µs | max µs | Δ log det (nats) | gains evaluated |",
    "|---|---|---|---|---|---|---|---|---|",
]


def cpu_model():
    for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return platform.machine()


def row(result):
    _, strategy, n, k, blocks = result["name"].removesuffix("/manual_time").split("/")
    strategy = re.sub(r"_0p(\d+)$", r", ε = 0.\1", strategy)
    delta = round(result["delta_nats"], 4) + 0.0  # no -0.0000
    n, k, blocks = (text.split(":")[1] for text in (n, k, blocks))
    return {
        "n": int(n),
        "k": int(k),
        "line": f"| {strategy} | {n} | {k} | {BLOCKS[int(blocks)]} | {result['median_us']:.1f} | {result['p99_us']:.1f} "
        f"| {result['max_us']:.1f} | {delta:.4f} | {result['evaluations']:.0f} |",
    }


def replace_between(path, name, lines):
    text = path.read_text()
    begin, end = f"<!-- begin {name} -->", f"<!-- end {name} -->"
    if text.count(begin) != 1 or text.count(end) != 1:
        sys.exit(f"{path}: expected one line '{begin}' and one line '{end}'")
    head, rest = text.split(begin)
    path.write_text(head + begin + "\n" + "\n".join(lines) + "\n" + end + rest.split(end)[1])
    print(f"rewrote {name} in {path.relative_to(ROOT)}")


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    data = json.loads(pathlib.Path(sys.argv[1]).read_text())
    context = data["context"]
    rows = [row(result) for result in data["benchmarks"] if result["run_type"] == "iteration"]
    machine = (
        f"{cpu_model()}, {context['num_cpus']} cores, {context['maxlogdet_isa']}, {context['maxlogdet_compiler']}, "
        f"one thread, maxlogdet {context['maxlogdet_version']}, {context['date'][:10]}, load {context['load_avg'][0]:.1f}; "
        "`bench/run`."
    )
    main_rows = [r["line"] for r in rows if (r["n"], r["k"]) == (2000, 100)]
    replace_between(ROOT / "README.md", "latency", [machine, "", *HEADER, *main_rows])
    replace_between(ROOT / "docs/performance.md", "grid", [machine, "", *HEADER, *(r["line"] for r in rows)])


if __name__ == "__main__":
    main()
