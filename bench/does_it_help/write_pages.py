#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Rewrites the tables of recorded frames in README.md and docs/trackers.md, from what `maxlogdet evaluate` wrote.

Usage: write_pages.py RESULTS    RESULTS/NAME/evaluation.json for each recording
"""

import pathlib
import sys

from maxlogdet_tools.files import ROOT, json_of
from maxlogdet_tools.pages import paragraph, rewrite, stamp, table

PAGE = ROOT / "docs/trackers.md"
RECORDINGS = {
    "orb_slam2_frames": "ORB-SLAM2, road",
    "orb_slam2_frames_0039": "ORB-SLAM2, town",
    "orb_slam3_frames_0039": "ORB-SLAM3, town",
    "lk_vo_frames_0039": "textbook odometry, town",
    "stereo_vo": "`examples/stereo_vo`, town",
}
TOWN = {"orb_slam2_frames_0039": "ORB-SLAM2", "orb_slam3_frames_0039": "ORB-SLAM3",
        "lk_vo_frames_0039": "textbook odometry"}
BUDGETS = [100, 200]
PARTS = ["translation", "rotation"]
USUAL = 100
BASELINES = {"bucket_gated": "in buckets", "random_gated": "random"}


def row_of(data, selector, budget=None):
    return next(row for row in data["selectors"] if row["selector"] == selector and budget in (row["budget"], None))


def growth(data, part, selector, budget=None):
    return row_of(data, selector, budget)[f"{part}_growth_percent"]["value"]


def both_parts(data, *selection):
    return "/".join(f"{growth(data, part, *selection):.0f}" for part in PARTS)


def span(values):
    return f"{min(values):.0f} to {max(values):.0f} %"


def section(evaluations):
    rows = [[f"{RECORDINGS[name]} ({data['inliers']:.0f})", both_parts(data, "aligned"),
             *(both_parts(data, "md", budget) for budget in BUDGETS),
             *(both_parts(data, selector, USUAL) for selector in BASELINES)]
            for name, data in evaluations.items()]  # fmt: skip
    ungated = [span([growth(data, part, "md_ungated", USUAL) for data in evaluations.values()]) for part in PARTS]
    wrong = [row_of(data, "md_ungated", USUAL)["wrong_percent"]["value"] for data in evaluations.values()]
    correlations = [data["cell_correlation"]["value"] for data in evaluations.values()]
    return [
        *table(["frames of (inliers)", "`pose()`", *(f"{budget} selected" for budget in BUDGETS),
                *(f"{USUAL} {name}" for name in BASELINES.values())], rows),
        "",
        *paragraph(f"Without rejection, {span(wrong)} of {USUAL} selected matches are wrong, and the growth is",
                   f"{ungated[0]} in translation and {ungated[1]} in rotation. Residuals of neighbouring inliers have a",
                   f"correlation of {min(correlations):.2f} to {max(correlations):.2f}."),
    ]  # fmt: skip


def worth(evaluations):
    """The table of README.md."""
    rows = []
    for name, tracker in TOWN.items():
        data = evaluations[name]
        rows.append([tracker, f"{data['inliers']:.0f}", both_parts(data, "aligned"),
                     *(both_parts(data, selector, USUAL) for selector in ("md", *BASELINES))])
    return [
        *paragraph(
            "Three trackers recorded their matches on the same drive of 12 s. The best estimate of a pose is that of a robust",
            "optimiser with all inliers ([details](docs/evaluate.md#what-is-measured)). By how many percent is the standard",
            "deviation of others larger, in translation / rotation? Matches were chosen among the library's inliers; *in",
            "buckets* means random ones, one of each image cell in turn."),
        "",
        *table(["tracker", "inliers (count)", "`pose()` (%)", f"{USUAL} selected (%)",
                *(f"{USUAL} {name} (%)" for name in BASELINES.values())], rows),
    ]  # fmt: skip


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    evaluations = {name: json_of(pathlib.Path(sys.argv[1]) / name / "evaluation.json") for name in RECORDINGS}
    for page, name, lines in ((ROOT / "README.md", "worth", worth(evaluations)),
                              (PAGE, "recorded_frames", section(evaluations))):
        rewrite(page, name, lines)
        stamp(page, "does_it_help")


if __name__ == "__main__":
    main()
