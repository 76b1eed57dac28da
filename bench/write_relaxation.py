#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Runs maxlogdet_relaxation and writes its tables into docs/performance.md.

Usage: write_relaxation.py PROGRAM
"""

import datetime
import subprocess
import sys

from results import ROOT, cpu_model
from write_tables import replace_between


def main():
    output = subprocess.run([sys.argv[1]], check=True, capture_output=True, text=True).stdout
    head, *tables = output.split("table ")
    facts = dict(line.split(" ", 1) for line in head.splitlines())
    machine = f"{cpu_model()}, {facts['isa']}, {facts['compiler']}, one thread, {datetime.date.today()}; `bench/run`."
    for table in tables:
        name, *lines = table.splitlines()
        replace_between(ROOT / "docs/performance.md", name, [machine, ""] + lines)


if __name__ == "__main__":
    main()
