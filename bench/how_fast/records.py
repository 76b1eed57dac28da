# SPDX-License-Identifier: MIT
"""The records of the benchmarks in bench/results: everything that was measured, of which the pages show a part."""

import csv

from maxlogdet_tools.files import write_csv
from maxlogdet_tools.project import ROOT

RECORDS = ROOT / "bench/results"


def write_record(name, header, rows):
    write_csv(RECORDS / name, header, rows)


def record_run(tables, line):
    """Records in runs.csv where, how and when the tables of a page were measured, a line per table."""
    path = RECORDS / "runs.csv"
    rows = dict(csv.reader(path.read_text().splitlines()[1:])) if path.is_file() else {}
    rows.update((name, line) for name in tables)
    write_record("runs.csv", ["table", "run"], sorted(rows.items()))


def unless_on_page(page, line):
    """A run's line, unless the page's first run was on the same machine: runs.csv has every line."""
    machine = ",".join(line.split(",")[:4])  # processor, cores, instruction set, compiler
    return [] if machine in page.read_text().split("<!-- end latency -->")[0] else ["", line]
