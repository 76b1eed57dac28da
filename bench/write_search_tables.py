#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Runs maxlogdet_search_tables and writes its tables into docs/performance.md.

Usage: write_search_tables.py PROGRAM [denormals|targets]    with a name: that table alone
"""

import datetime
import os
import subprocess
import sys

from results import ROOT, cpu_model
from write_tables import replace_between


def facts_and_tables(lines):
    """The lines "KEY VALUE" before the first table, and the lines of each table, by name."""
    facts, tables, name = {}, {}, None
    for line in lines:
        if line.startswith("table "):
            name = line.split(" ", 1)[1]
            tables[name] = []
        elif name is None:
            key, value = line.split(" ", 1)
            facts[key] = value
        else:
            tables[name].append(line)
    return facts, tables


def main():
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    load = os.getloadavg()[0]  # before: the program itself makes one
    output = subprocess.run(sys.argv[1:], check=True, stdout=subprocess.PIPE, text=True).stdout
    facts, tables = facts_and_tables(output.splitlines())
    machine = (
        f"{cpu_model()}, {os.cpu_count()} cores, {facts['isa']}, {facts['compiler']}, one thread, "
        f"{datetime.date.today()}, load {load:.1f}; `bench/run`."
    )
    for name, lines in tables.items():
        replace_between(ROOT / "docs/performance.md", name, [*lines, "", machine])


if __name__ == "__main__":
    main()
