#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Rewrites the tables of docs/experiments.md from the results of `maxlogdet simulate`, copies its pictures, and records
the full tables in bench/does_the_paper_hold/results.

Usage: write_experiments.py RESULTS    RESULTS: the folder that bench/run does_the_paper_hold fills
"""

import pathlib
import shutil
import sys

import epsilon_tables
import metrics_tables
import robustness_tables
import tracking_tables
from maxlogdet_tools.pages import rewrite
from maxlogdet_tools.project import ROOT, shown

SECTIONS = [metrics_tables, tracking_tables, robustness_tables, epsilon_tables]
PICTURES = ["metrics", "budget", "epsilon", "euroc", "robustness"]


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    results = pathlib.Path(sys.argv[1])
    for section in SECTIONS:
        for name, lines in section.tables(results).items():
            rewrite(ROOT / "docs/experiments.md", name, lines)
        section.record_all(results)
    for experiment in PICTURES:
        for picture in sorted((results / experiment).glob(f"{experiment}*.svg")):
            target = ROOT / "docs/images" / picture.name
            shutil.copy(picture, target)
            print(f"copied {shown(target)}")


if __name__ == "__main__":
    main()
