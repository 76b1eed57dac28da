#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Rewrites the figures of frames in README.md and docs/.

Usage: write_pages.py evaluation RESULTS SET SET    from what `maxlogdet evaluate` wrote into RESULTS/SET
       write_pages.py wrong_matches FILE            from what maxlogdet_wrong_matches has printed
"""

import pathlib
import sys

from maxlogdet_tools.files import ROOT, json_of
from maxlogdet_tools.pages import paragraph, rewrite, stamp, table

PAGE = ROOT / "docs/trackers.md"
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


def write_evaluation(results, *names):
    sets = {name: json_of(pathlib.Path(results) / name / "evaluation.json") for name in names}
    rewrite(ROOT / "README.md", "worth", sentences(sets))
    rewrite(PAGE, "orb_slam2_same_frame", section(sets))
    stamp(ROOT / "README.md", "does_it_help")
    stamp(PAGE, "does_it_help")


def write_wrong_matches(file):
    page = ROOT / "docs/performance.md"
    *rows, sentences_of_rows = pathlib.Path(file).read_text().splitlines()
    rewrite(page, "wrong_matches", [*rows, *paragraph(sentences_of_rows)])
    stamp(page, "does_it_help --wrong")


if __name__ == "__main__":
    if len(sys.argv) not in (3, 5):
        sys.exit(__doc__)
    {"evaluation": write_evaluation, "wrong_matches": write_wrong_matches}[sys.argv[1]](*sys.argv[2:])
