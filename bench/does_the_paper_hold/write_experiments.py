#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Rewrites the tables of docs/experiments.md from the results of `maxlogdet_simulate`, copies its pictures, and records
the full tables in bench/does_the_paper_hold/results.

Usage: write_experiments.py RESULTS    RESULTS: the folder that bench/run does_the_paper_hold fills
"""

import pathlib
import shutil
import sys

import epsilon_tables
import metrics_tables
import tracking_tables
from maxlogdet_tools.pages import rewrite
from maxlogdet_tools.project import ROOT, shown
from maxlogdet_tools.runs import stamp

PAGE = ROOT / "docs/experiments.md"
SECTIONS = [metrics_tables, tracking_tables, epsilon_tables]
PICTURES = ["metrics/metrics_map_bias.svg"]  # that the page shows


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    results = pathlib.Path(sys.argv[1])
    for section in SECTIONS:
        for name, lines in section.tables(results).items():
            rewrite(PAGE, name, lines)
        section.record_all(results)
    stamp(PAGE, "does_the_paper_hold")
    for picture in PICTURES:
        target = ROOT / "docs/images" / pathlib.Path(picture).name
        shutil.copy(results / picture, target)
        print(f"copied {shown(target)}")


if __name__ == "__main__":
    main()
