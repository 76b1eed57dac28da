#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Rewrites the tables of docs/tracker.md from what the stereo odometry wrote, and copies its picture beside them.

Usage: write_page.py RESULTS    RESULTS: the folder that ci/tracker_page fills
A table stands between the lines '<!-- begin NAME -->' and '<!-- end NAME -->'.
"""

import csv
import datetime
import json
import pathlib
import shutil
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "bench"))

from results import cpu_model  # noqa: E402
from write_tables import replace_between, table  # noqa: E402

PAGE = ROOT / "docs/tracker.md"
BATCHES = (5, 10, 20, 40, 100)
RPE, ROE = "rpe_m_per_s", "roe_deg_per_s"


def results_of(folder):
    return json.loads((folder / "summary.json").read_text())


def find(results, selector, budget=100):
    return next(e for e in results if e["selector"] == selector and e["budget"] in (budget, None))


def relative(results, selector, key, budget=100):
    return f"{find(results, selector, budget)[key] / find(results, 'inl')[key]:.2f}"


def markdown_of(folder, number):
    """The table with that number in a summary.md, as it is."""
    return (folder / "summary.md").read_text().strip().split("\n\n")[number].splitlines()


def machine():
    today = datetime.date.today().isoformat()
    load = pathlib.Path("/proc/loadavg").read_text().split()[0]
    return f"{cpu_model()}, one thread, {today}, load {load} at the end; `ci/tracker_page`."


def yes(holds):
    return "yes" if holds else "**no**"


def judged_rows(results):
    md, inl, active = (find(results, name) for name in ("md", "inl", "active"))
    rivals = [find(results, name) for name in ("random", "quality")]
    rows = []

    def judge(what, target, found, holds):
        rows.append([what, target, found, yes(holds)])

    tracked = min(e["tracked_percent"] for e in results)
    judge("frames tracked, worst selector", "100 %", f"{tracked:.0f} %", tracked > 99.999)
    for key, name in ((RPE, "RPE"), (ROE, "ROE")):
        share = md[key] / inl[key]
        judge(f"{name} of md / of inl", "≤ 1.05", f"{share:.3f}", share <= 1.05)
        others = [e[key] / inl[key] for e in rivals]
        judge(f"{name} of random, quality / of inl", f"> {share:.3f} (md)", f"{others[0]:.3f}, {others[1]:.3f}",
              share < min(others))
    speed = inl["ms"]["pose_optimization"] / md["ms"]["pose_optimization"]
    judge("pose optimisation, inl / md", "≥ 3", f"{speed:.1f}", speed >= 3)
    selection = md["ms"]["selection"]
    judge("selection, md", "≤ 0.1 ms", f"{selection:.3f} ms", selection <= 0.1)
    part = 100 * selection / md["ms"]["total"]
    judge("selection's part of the frame", "≤ 1 %", f"{part:.2f} %", part <= 1)
    saved = 100 * (1 - active["ms"]["matching"] / md["ms"]["matching"])
    judge("local-map matching that active saves against md", "≥ 30 %", f"{saved:.0f} %", saved >= 30)
    both = 100 * (1 - (active["ms"]["matching"] + active["ms_matching_the_rest"]) / md["ms"]["matching"])
    rows.append(["the same, with what keyframes match when the pose is known", "", f"{both:.0f} %", ""])
    share = active[RPE] / md[RPE]
    judge("RPE of active / of md", "about 1", f"{share:.3f}", share <= 1.05)
    return rows


def cost_rows(name, results):
    """What the stages that selection is meant to make cheaper cost, with and without what active's keyframes match."""
    inl = find(results, "inl")
    stages = lambda e: [e["ms"][stage] for stage in ("matching", "selection", "pose_optimization")]
    rows = []
    for one in ("inl", "md", "active"):
        e = find(results, one)
        together = sum(stages(e))
        target = "" if one != "active" else "≤ 0.5, yes" if together <= 0.5 * sum(stages(inl)) else "≤ 0.5, **no**"
        rows.append([name, one, *(f"{ms:.3f}" for ms in stages(e)), f"{together:.3f}",
                     f"{together / sum(stages(inl)):.2f}", target,
                     f"{(together + e['ms_matching_the_rest']) / sum(stages(inl)):.2f}",
                     f"{relative(results, one, RPE)} / {relative(results, one, ROE)}"])  # fmt: skip
    return rows


def main():
    folder = pathlib.Path(sys.argv[1])
    everything = results_of(folder / "all")
    replace_between(PAGE, "judged", table(["what", "target", "found", "holds"], judged_rows(everything)) + ["", machine()])
    replace_between(PAGE, "selectors", markdown_of(folder / "all", 0))
    replace_between(PAGE, "comparison", markdown_of(folder / "all", 1))

    rows = cost_rows("kitti_0039_a", results_of(folder / "second")) + cost_rows("kitti_clip_1", everything)
    header = ["clip", "selector", "matching (ms)", "selection (ms)", "pose opt. (ms)", "together (ms)", "of inl's", "target",
              "with keyframes' rest", "RPE / ROE, of inl's"]  # fmt: skip
    replace_between(PAGE, "cost", table(header, rows))

    rows = []
    for clip in ("kitti_0039_a", "kitti_clip_1"):
        runs = [results_of(folder / f"batch_{n}_{clip}") for n in BATCHES]
        shares = [[find(r, "active")[key] / find(r, "inl")[key] for r in runs] for key in (RPE, ROE)]
        rows.append([clip, *(f"{a:.2f} / {b:.2f}" for a, b in zip(*shares)),
                     " / ".join(f"{sum(s) / len(s):.2f}" for s in shares)])  # fmt: skip
    replace_between(PAGE, "batches", table(["clip", *(f"batches of {n}" for n in BATCHES), "mean"], rows))

    rivals = ["md", "active", "random", "quality"]
    settings = [(f"{n} keypoints an image", results_of(folder / f"features_{n}"), 100) for n in (1000, 1500)]
    settings += [("2000 keypoints, 10 runs: the table above", everything, 100)]
    settings += [(f"{n} keypoints an image", results_of(folder / f"features_{n}"), 100) for n in (2500, 3000)]
    budgets = results_of(folder / "budgets")
    settings += [(f"budget {k}", budgets, k) for k in (60, 80, 100, 150, 200)]
    settings += [("two rows a match (`--residuals monocular`)", results_of(folder / "monocular"), 100)]
    rows = [[name, f"{find(r, 'inl')['inliers']:.0f}",
             *(f"{relative(r, one, RPE, k)} / {relative(r, one, ROE, k)}" for one in rivals)]
            for name, r, k in settings]  # fmt: skip
    header = ["setting", "inliers", *rivals]
    replace_between(PAGE, "settings", table(header, rows))

    weightings = [("measurement_and_map", everything), ("measurement", results_of(folder / "measurement")),
                  ("map_bias", results_of(folder / "map_bias"))]  # fmt: skip
    rows = [[f"`{name}`", *(f"{relative(r, one, RPE)} / {relative(r, one, ROE)}" for one in ("md", "quality_md", "active"))]
            for name, r in weightings]  # fmt: skip
    replace_between(PAGE, "weightings", table(["blocks", "md", "quality_md", "active"], rows))

    stochastic = find(results_of(folder / "stochastic"), "md")
    greedy = find(everything, "md")
    rows = [[name, f"{e['ms']['selection']:.3f}", f"{e['efficiency']:.3f}", f"{e[RPE]:.4f}", f"{e[ROE]:.4f}"]
            for name, e in (("lazy_greedy", greedy), ("stochastic_greedy, ε = 0.1", stochastic))]  # fmt: skip
    replace_between(PAGE, "strategies", table(["search", "selection (ms)", "efficiency", "RPE (m/s)", "ROE (deg/s)"], rows))

    at_rest = [line.split() for line in (folder / "rest/md/trajectory_tum.txt").read_text().splitlines() if line[0] != "#"]
    drift = max(sum(float(x) ** 2 for x in line[1:4]) ** 0.5 for line in at_rest)
    active, md = (find(results_of(folder / "rest"), one) for one in ("active", "md"))
    keyframes = sum(row["keyframe"] == "1" for row in csv.DictReader(open(folder / "rest/md/frames.csv")))
    replace_between(PAGE, "rest", [f"Over {float(at_rest[-1][0]) - float(at_rest[0][0]):.1f} s the camera seems to move by "
                                   f"{1000 * drift:.1f} mm at most (`md`), and {keyframes} keyframe(s) are made: matching "
                                   f"takes {md['ms']['matching']:.2f} ms with `md`, {active['ms']['matching']:.2f} ms with `active`."])  # fmt: skip
    shutil.copy(folder / "all/trajectory.svg", ROOT / "docs/images/tracker_trajectory.svg")


main()
