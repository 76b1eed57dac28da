#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Rewrites what README.md and docs/trackers.md say of ORB-SLAM2's frames, from what `maxlogdet evaluate` wrote.

Usage: write_evaluation.py RESULTS SET SET    RESULTS: the folder that bench/run does_it_help fills
"""

import math
import pathlib
import sys

from maxlogdet_tools.files import json_of
from maxlogdet_tools.pages import paragraph, rewrite, table
from maxlogdet_tools.project import ROOT
from maxlogdet_tools.runs import stamp

PAGE = ROOT / "docs/trackers.md"
COMMAND = "does_it_help"
RECORDINGS = ["first recording", "second recording"]
BUDGETS = [30, 100, 200]
USUAL = 100


def row_of(data, selector, budget):
    return next(row for row in data["selectors"] if (row["selector"], row["budget"]) == (selector, budget))


def worth_table(evaluations):
    rows = [[f"{budget}", *(f"{row_of(data, 'md', budget)['worth_random']:.0f}" for data in evaluations)]
            for budget in BUDGETS]
    return table(["selected (count)", *(f"random, {name} (count)" for name in RECORDINGS)], rows)


def widest_interval(evaluations):
    """How many matches the farthest end of an interval is away from its figure."""
    rows = [row_of(data, "md", budget) for data in evaluations for budget in BUDGETS]
    below = [row["worth_random"] - row["worth_random_low"] for row in rows]
    above = [row["worth_random_high"] - row["worth_random"] for row in rows]
    return math.ceil(max(below + above))


def largest(evaluations, key):
    return f"{max(data[key] for data in evaluations):.2f}"


def section(sets):
    evaluations = list(sets.values())
    first, second = (f"`{name}`, with {data['inliers']:.0f} inliers a frame" for name, data in sets.items())
    return [
        *paragraph(f"The first recording is {first}, the second {second}.",
                   "The table shows how many random matches give a pose as near to the pose of all inliers as the",
                   "selected matches do."),
        "", *worth_table(evaluations), "",
        *paragraph(f"95 % intervals reach at most {widest_interval(evaluations)} matches above or below these figures.",
                   "Errors of neighbouring matches are correlated by at most",
                   f"{largest(evaluations, 'cell_correlation')}, those of selected neighbours by at most",
                   f"{largest(evaluations, 'cell_correlation_selected')}."),
    ]


def interval(row):
    return f"{row['worth_random_low']:.0f} to {row['worth_random_high']:.0f}"


def sentences(sets):
    first, second = (row_of(data, "md", USUAL) for data in sets.values())
    return paragraph(
        f"**With ORB-SLAM2, the camera pose from {USUAL} selected matches is as good as the pose from",
        f"{first['worth_random']:.0f} random matches on one recording,",
        f"and from {second['worth_random']:.0f} on another.**",
        "A good pose is near the pose of all inliers.",
        f"The 95 % intervals are {interval(first)} and {interval(second)} random matches.")


def main():
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    results = pathlib.Path(sys.argv[1])
    sets = {name: json_of(results / name / "evaluation.json") for name in sys.argv[2:]}
    rewrite(ROOT / "README.md", "worth", sentences(sets))
    rewrite(PAGE, "orb_slam2_same_frame", section(sets))
    stamp(ROOT / "README.md", COMMAND)
    stamp(PAGE, COMMAND)


if __name__ == "__main__":
    main()
