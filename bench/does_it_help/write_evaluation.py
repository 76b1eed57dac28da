#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Rewrites what README.md and docs/trackers.md say of ORB-SLAM2's frames, from what `maxlogdet evaluate` wrote.

Usage: write_evaluation.py RESULTS SET...    RESULTS: the folder that bench/run does_it_help fills
"""

import pathlib
import sys

from maxlogdet_tools.files import json_of
from maxlogdet_tools.pages import paragraph, rewrite, table
from maxlogdet_tools.project import ROOT

BUDGETS = [30, 60, 100, 150, 200]
SELECTORS = {"md": "Max-logDet", "md_spread": "Max-logDet, spread", "bucket": "random over cells", "random": "random"}
USUAL = 100


def row_of(data, selector, budget):
    return next(row for row in data["selectors"] if (row["selector"], row["budget"]) == (selector, budget))


def deviation_table(data):
    header = ["translation (mm) / rotation (mrad)", *(f"{budget} matches" for budget in BUDGETS)]
    rows = []
    for selector, name in SELECTORS.items():
        cells = [row_of(data, selector, budget) for budget in BUDGETS]
        rows.append([name, *(f"{cell['translation_mm']['median']:.1f} / {cell['rotation_mrad']['median']:.2f}"
                             for cell in cells)])
    rows.append(["Max-logDet, predicted", *(
        f"{cell['translation_mm']['predicted']:.1f} / {cell['rotation_mrad']['predicted']:.2f}"
        for cell in (row_of(data, "md", budget) for budget in BUDGETS))])
    rows.append(["Max-logDet is worth random", *(
        f"{cell['worth_random']:.0f} ({cell['worth_random_low']:.0f} to {cell['worth_random_high']:.0f})"
        for cell in (row_of(data, "md", budget) for budget in BUDGETS))])
    return table(header, rows)


def noise_of(data):
    chi2 = data["chi2_by_leverage"]
    return (f"chi-squared by leverage is {min(chi2):.2f} to {max(chi2):.2f}, neighbours are correlated by "
            f"{data['cell_correlation']:.2f}, the selected ones by {data['cell_correlation_selected']:.2f}")


def section(sets):
    lines = []
    for name, data in sets.items():
        lines += ["", *paragraph(f"`{name}`: {data['frames']} frames with {data['inliers']:.0f} inliers of "
                                 f"{data['matches']:.0f} matches; {noise_of(data)}."), "", *deviation_table(data)]
    return lines[1:]


def worth(data):
    row = row_of(data, "md", USUAL)
    return f"{row['worth_random']:.0f} ({row['worth_random_low']:.0f} to {row['worth_random_high']:.0f})"


def sentence(sets):
    first, second = sets.values()
    return paragraph(
        f"**On frames of ORB-SLAM2, {USUAL} matches selected by Max-logDet give the pose that {worth(first)} random "
        f"matches give on one recording, and {worth(second)} on another** (95 % intervals).")


def main():
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    results = pathlib.Path(sys.argv[1])
    sets = {name: json_of(results / name / "evaluation.json") for name in sys.argv[2:]}
    rewrite(ROOT / "README.md", "worth", sentence(sets))
    rewrite(ROOT / "docs/trackers.md", "orb_slam2_same_frame", section(sets))


if __name__ == "__main__":
    main()
