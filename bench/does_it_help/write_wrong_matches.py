#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Runs maxlogdet_wrong_matches, records its table in results, and shows a part in docs/performance.md.

Usage: write_wrong_matches.py PROGRAM FOLDER [STEP]
"""

import csv
import pathlib
import subprocess
import sys

from maxlogdet_tools.files import write_csv
from maxlogdet_tools.pages import paragraph, rewrite, table
from maxlogdet_tools.project import ROOT
from maxlogdet_tools.runs import stamp

RESULTS = pathlib.Path(__file__).parent / "results"
PAGE = ROOT / "docs/performance.md"
POSES = {
    "aligned": "aligned pose",
    "full": "all matches",
    "selected": "60 selected after alignment",
    "known": "60 selected inliers",
    "unaligned": "60 selected without alignment",
}
RANDOM = "random pixels"
USUAL = "0.2"  # m that the predicted pose is off; the record has all rows
SHOWN = ["0", "0.2", "0.4"]  # shares of random pixels


def label(row):
    return f"{100 * float(row['share']):.0f} % {row['wrong']}" if float(row["share"]) > 0 else "none"


def percents(rows, column):
    values = [float(row[column]) for row in rows]
    return f"{min(values):.1f} to {max(values):.1f} %"


def section(rows):
    usual = [row for row in rows if row["off_m"] == USUAL]
    random, others = ([row for row in usual if (row["wrong"] == RANDOM) == is_random] for is_random in (True, False))
    change = max(abs(float(other["aligned_median_mm"]) - float(row["aligned_median_mm"]))
                 for row in usual for other in rows if label(other) == label(row))
    cell = lambda row, pose: f"{float(row[pose + '_median_mm']):.1f} ({float(row[pose + '_p95_mm']):.1f})"
    return [
        *table(["wrong", *POSES.values()], [[label(row), *(cell(row, pose) for pose in POSES)]
                                            for row in usual if row in others or row["share"] in SHOWN]),
        "",
        *paragraph(
            f"Each row has {usual[0]['samples']} draws. Predictions off by 2 cm or 50 cm changed the first median by at",
            f"most {change:.1f} mm. Of 60 selected matches, {percents(random, 'wrong_of_60_percent')} were wrong with",
            f"random pixels, {percents(others, 'wrong_of_60_percent')} otherwise. The alignment rejected",
            f"{percents(usual, 'lost_percent')} of the inliers.",
        ),
    ]  # fmt: skip


def main():
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__)
    output = subprocess.run(sys.argv[1:], check=True, stdout=subprocess.PIPE, text=True).stdout
    rows = list(csv.DictReader(output.splitlines()))
    write_csv(RESULTS / "wrong_matches.csv", rows[0].keys(), (row.values() for row in rows))
    rewrite(PAGE, "wrong_matches", section(rows))
    stamp(PAGE, "does_it_help --wrong")


if __name__ == "__main__":
    main()
