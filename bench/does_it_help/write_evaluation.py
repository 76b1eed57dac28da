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
PARTS = ["translation", "rotation"]
USUAL = 100


def row_of(data, selector, budget):
    return next(row for row in data["selectors"] if row["selector"] == selector and budget in (row["budget"], None))


def grown(data, selector, budget, part):
    return f"{row_of(data, selector, budget)[part + '_growth_percent']['value']:.0f}"


def growth_table(evaluations):
    header = ["recording", "matches (count)"] + [f"{kind}, {part} (%)" for part in PARTS for kind in ("selected", "random")]
    return table(header, [[name, f"{budget}", *(grown(data, selector, budget, part)
                                                for part in PARTS for selector in ("md", "random_gated"))]
                          for name, data in zip(RECORDINGS, evaluations) for budget in BUDGETS])


def section(sets):
    evaluations = list(sets.values())
    first, second = (f"`{name}`, has {data['frames']} frames with {data['inliers']:.0f} inliers on average."
                     for name, data in sets.items())
    correlations = [f"{data['cell_correlation']['value']:.2f}" for data in evaluations]
    return [
        *paragraph(f"The first recording, {first} The second, {second}",
                   "The table shows by how many percent the standard deviation of the pose is larger than with all inliers."),
        "", *growth_table(evaluations), "",
        *paragraph("Residuals of neighbouring inliers have a correlation of",
                   f"{correlations[0]} in the first recording and {correlations[1]} in the second."),
    ]


def sentences(sets):
    def growth(selector, budget=USUAL):
        first, second = ([grown(data, selector, budget, part) for part in PARTS] for data in sets.values())
        return (f"{first[0]} % in translation and {first[1]} % in rotation in the first recording, and by {second[0]} % and "
                f"{second[1]} % in the second.")

    first, second = sets.values()
    return paragraph(
        f"**In two recordings of ORB-SLAM2, {USUAL} selected matches increased the standard deviation of the pose by",
        f"{growth('md')}** With {USUAL} random matches, it increased by {growth('random_gated')}",
        "With `pose()`, which aligns all matches that the library accepts, without a selection, it increased by",
        f"{growth('aligned', None)}",
        f"Each increase is relative to the pose of all correct matches (*inliers*), of which a frame has {first['inliers']:.0f}",
        f"in the first recording and {second['inliers']:.0f} in the second. Both selections were made after the library had",
        "rejected outliers among all matches.")


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
