#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Draws what `maxlogdet simulate NAME --output FOLDER` wrote, an .svg and a .png of each picture, into the same folder.

Usage: draw_experiment.py FOLDER...
"""

import sys

from maxlogdet_tools.files import arguments, json_of
from maxlogdet_tools.gnuplot import draw_both
from maxlogdet_tools.pictures import epsilon, metrics, robustness, selection, tracking

EXPERIMENTS = {
    "metrics": metrics.pictures,
    "epsilon": epsilon.pictures,
    "budget": tracking.budget,
    "euroc": tracking.euroc,
    "robustness": robustness.pictures,
}


def pictures_of(folder):
    """{name: picture} of every experiment whose results are in the folder."""
    names = [name for name in EXPERIMENTS if (folder / f"{name}.json").exists()]
    if not names:
        sys.exit(f"{folder}: expected the results of `maxlogdet simulate`, {', '.join(f'{name}.json' for name in EXPERIMENTS)}")
    pictures = {}
    for name in names:
        results = json_of(folder / f"{name}.json")
        if results["table"]:
            pictures.update(EXPERIMENTS[name](results["settings"], results["table"]))
    scene = folder / "metrics_scene.json"
    if "metrics" in names and scene.exists():
        pictures["metrics_scene"] = selection.picture(json_of(scene))
    return pictures


for one in arguments(__doc__):
    for title, picture in pictures_of(one).items():
        draw_both(picture, one / title)
