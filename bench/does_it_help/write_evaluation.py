#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Rewrites what README.md and docs/trackers.md say of ORB-SLAM2's frames, from what `maxlogdet evaluate` wrote.

Usage: write_evaluation.py RESULTS SET SET    RESULTS: the folder that bench/run does_it_help fills
"""

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
NOISE_BUDGET = 100  # of EvaluationOptions


def row_of(data, selector, budget):
    return next(row for row in data["selectors"] if (row["selector"], row["budget"]) == (selector, budget))


def worth(data, budget):
    """How many random matches the selected ones equal, and the 95 % interval of that number."""
    row = row_of(data, "md", budget)
    return f"{row['worth_random']:.0f}", f"{row['worth_random_low']:.0f} to {row['worth_random_high']:.0f}"


def worth_table(evaluations):
    header = ["selected (count)"]
    for name in RECORDINGS:
        header += [f"random, {name} (count)", f"95 % interval, {name} (count)"]
    return table(header, [[f"{budget}", *(cell for data in evaluations for cell in worth(data, budget))]
                          for budget in BUDGETS])


def section(sets):
    evaluations = list(sets.values())
    first, second = (f"`{name}`, has {data['frames']} frames with {data['inliers']:.0f} inliers on average."
                     for name, data in sets.items())
    among_all, among_selected = ([f"{data[key]:.2f}" for data in evaluations]
                                 for key in ("cell_correlation", "cell_correlation_selected"))
    return [
        *paragraph(f"The first recording, {first} The second, {second}",
                   "The table shows how many random matches are as good as the selected ones."),
        "", *worth_table(evaluations), "",
        *paragraph("Residuals of neighbouring inliers have a correlation of",
                   f"{among_all[0]} in the first recording and {among_all[1]} in the second.",
                   f"Among {NOISE_BUDGET} selected inliers it is",
                   f"{among_selected[0]} in the first and {among_selected[1]} in the second."),
    ]


def sentences(sets):
    first, second = sets.values()
    (at_first, interval_at_first), (at_second, interval_at_second) = worth(first, USUAL), worth(second, USUAL)
    return paragraph(
        f"**In ORB-SLAM2, {USUAL} selected matches were as good as {at_first} random ones in one recording (95 % interval",
        f"{interval_at_first}), and as {at_second} in another ({interval_at_second}).**",
        f"A frame has {first['inliers']:.0f} correct matches (*inliers*) in the first recording and {second['inliers']:.0f}",
        "in the second. As good means that the pose is as near to the pose computed from all inliers. Nearness is measured by",
        "the median distance between the two positions, times the median angle between the two rotations.")


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
