# SPDX-License-Identifier: MIT
"""What ci/tracker_page recorded, a summary.json for each set and number of keypoints; and ratios of its errors."""

import math
import statistics

from maxlogdet_tools.files import json_of

SETS = {
    "kitti_clip_1": "a straight road, 51 stereo pairs at 10 Hz",
    "kitti_0039_a": "a town, 120 stereo pairs at 10 Hz",
    "tum_fr1_rpy_a": "hand-held RGB-D, mostly rotating, blur and rolling shutter, 120 pairs at 30 Hz",
}
RPE, ROE = "rpe_m_per_s", "roe_deg_per_s"


def results_of(folder):
    return json_of(folder / "summary.json")


def entry_of(run, **which):
    return next(e for e in run if all(e[key] == value for key, value in which.items()))


def find(results, selector, budget=100):
    return next(e for e in results if e["selector"] == selector and e["budget"] in (budget, None))


def every(results, folder):
    """{set: [results of each number of keypoints]} of a folder that ci/tracker_page fills for every set."""
    return {name: [results_of(path) for path in sorted((results / folder / name).iterdir())]
            for name in SETS if (results / folder / name).is_dir()}


def geometric_mean(values):
    return math.exp(statistics.fmean(math.log(value) for value in values))


def ratio(runs, key, **which):
    """The ratio to inl in the same run, the geometric mean over runs."""
    return geometric_mean(entry_of(r, **which)[key] / find(r, "inl")[key] for r in runs)


def both(runs, **which):
    return f"{ratio(runs, RPE, **which):.2f} / {ratio(runs, ROE, **which):.2f}"


def interval(runs, error, against="inl", **which):
    """(difference, half width of its 95 % interval), percent, means over runs. Runs of one set are not independent, so
    they do not narrow the interval."""
    differences = [entry_of(r, **which)["against"][against][error] for r in runs]
    return [statistics.fmean(d[key] for d in differences) for key in ("percent", "ci95")]


def contestants(runs):
    """(selector, budget) of all contestants except inl."""
    return [(e["selector"], e["budget"]) for e in runs[0] if e["selector"] != "inl"]


def changes(runs, before, selector):
    """RPE and ROE relative to those of other runs of the same selector."""
    pairs = [(find(r, selector), find(b, selector)) for r, b in zip(runs, before)]
    return " / ".join(f"{geometric_mean(now[key] / then[key] for now, then in pairs):.2f}" for key in (RPE, ROE))
