# SPDX-License-Identifier: MIT
"""The records of the benchmarks in bench/results: everything that was measured, of which the pages show a part."""

from maxlogdet_tools.files import write_csv
from maxlogdet_tools.project import ROOT

RECORDS = ROOT / "bench/results"


def write_record(name, header, rows):
    write_csv(RECORDS / name, header, rows)
