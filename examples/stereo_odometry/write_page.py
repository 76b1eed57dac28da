#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Rewrites the tables of docs/tracker.md from what the stereo odometry wrote, and copies its picture beside them.

Usage: write_page.py RESULTS    RESULTS: the folder that ci/tracker_page fills
A table stands between the lines '<!-- begin NAME -->' and '<!-- end NAME -->'.
"""

import csv
import datetime
import json
import math
import pathlib
import shutil
import statistics
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "bench"))

from results import cpu_model  # noqa: E402
from write_tables import replace_between, table  # noqa: E402

PAGE = ROOT / "docs/tracker.md"
BATCHES = (5, 10, 20, 40, 100)
BUDGETS = (30, 60, 100, 200)
SETS = ("kitti_clip_1", "kitti_0039_a", "tum_fr1_rpy_a")
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


def every(results, folder):
    """{set: [results of each number of keypoints]} of a folder that ci/tracker_page has filled everywhere."""
    return {name: [results_of(path) for path in sorted((results / folder / name).iterdir())]
            for name in SETS if (results / folder / name).is_dir()}


def ratio(runs, key, **which):
    """To inl's of the same run, the geometric mean over runs."""
    shares = [entry_of(r, **which)[key] / find(r, "inl")[key] for r in runs]
    return math.exp(statistics.fmean(math.log(share) for share in shares))


def entry_of(run, **which):
    return next(e for e in run if all(e[key] == value for key, value in which.items()))


def both(runs, **which):
    return f"{ratio(runs, RPE, **which):.2f} / {ratio(runs, ROE, **which):.2f}"


def interval(runs, error, against="inl", **which):
    """(difference, half width of its 95 % interval), percent, means over runs: runs of one set are no independent
    witnesses, so the interval gets no narrower."""
    differences = [entry_of(r, **which)["against"][against][error] for r in runs]
    return [statistics.fmean(d[key] for d in differences) for key in ("percent", "ci95")]


def with_interval(runs, **which):
    cells = []
    for error, key in (("rpe", RPE), ("roe", ROE)):
        _, half = interval(runs, error, **which)
        cells.append(f"{ratio(runs, key, **which):.2f} ± {half / 100:.2f}")
    return " / ".join(cells)


def summary_rows(runs):
    """A row a selector: errors at each budget, and stages at 100, ms."""
    rows = []
    names = dict.fromkeys(e["selector"] for e in runs[0] if e["selector"] != "inl")
    for name in names:
        has_budget = any(e["selector"] == name and e["budget"] for e in runs[0])
        cells = [with_interval(runs, selector=name, budget=k) if has_budget else "" for k in BUDGETS]
        if not has_budget:
            cells[-1] = with_interval(runs, selector=name) + " (all)"
        at = {"selector": name, "budget": 100 if has_budget else None}
        ms = [statistics.fmean(entry_of(r, **at)["ms"][stage] for r in runs)
              for stage in ("matching", "selection", "pose_optimization")]
        rows.append([f"`{name}`", *cells, " / ".join(f"{t:.2f}" for t in ms)])
    inl = [entry_of(r, selector="inl") for r in runs]
    mean = lambda key: statistics.fmean(e[key] for e in inl)
    ms = [statistics.fmean(e["ms"][stage] for e in inl) for stage in ("matching", "selection", "pose_optimization")]
    rows.append(["`inl`", *[""] * (len(BUDGETS) - 1), f"{mean(RPE):.3f} m/s, {mean(ROE):.2f} deg/s; {mean('inliers'):.0f} matches",
                 " / ".join(f"{t:.2f}" for t in ms)])
    return rows


def judged_rows(summary, name):
    """What is asked of a selector on every set: as good as all, and better than chance."""
    rows = []
    for which, runs in summary.items():
        for budget, target in ((100, 1.05), (200, 1.02)):
            shares = [ratio(runs, key, selector=name, budget=budget) for key in (RPE, ROE)]
            rows.append([which, f"RPE / ROE of {budget}, of inl's", f"≤ {target}", f"{shares[0]:.3f} / {shares[1]:.3f}",
                         yes(max(shares) <= target)])
        worse = []
        for rival in ("random", "bucket"):
            for error in ("rpe", "roe"):
                percent, half = interval(runs, error, rival, selector=name, budget=100)
                worse.append((percent, half))
        worst = max(worse, key=lambda d: d[0] - d[1])
        rows.append([which, "100 against `random` and `bucket`, the worst", "not above beyond the interval",
                     f"{worst[0]:+.0f} ± {worst[1]:.0f} %", yes(worst[0] <= worst[1])])
    excess = lambda one: statistics.fmean(ratio(runs, key, selector=one, budget=30) - 1
                                          for runs in summary.values() for key in (RPE, ROE))
    mine = excess(name)
    for rival, share in (("random", 1 / 2), ("bucket", 2 / 3)):
        rows.append(["all", f"excess over inl at 30, of `{rival}`'s", f"≤ {share:.2f}", f"{mine:.3f} / {excess(rival):.3f} = {mine / excess(rival):.2f}",
                     yes(mine <= share * excess(rival))])
    return rows


def active_rows(summary):
    rows = []
    for which, runs in summary.items():
        shares = [ratio(runs, key, selector="active", budget=100) / ratio(runs, key, selector="md", budget=100)
                  for key in (RPE, ROE)]
        rows.append([which, f"{shares[0]:.2f} / {shares[1]:.2f}", yes(max(shares) <= 1.05)])
    return rows


def weights_rows(results):
    rows = []
    unweighted = every(results, "weights/measurement/measurement")
    for blocks in ("measurement", "measurement_and_map", "map_bias"):
        for weights in ("measurement", "measurement_and_map"):
            runs = every(results, f"weights/{blocks}/{weights}")
            rows.append([f"`{blocks}`", f"`{weights}`", *(both(runs[name], selector="md") for name in runs)])
    weighted = every(results, "weights/measurement/measurement_and_map")
    gain = lambda name, key: math.exp(statistics.fmean(
        math.log(find(w, "inl")[key] / find(u, "inl")[key]) for w, u in zip(weighted[name], unweighted[name])))
    rows.append(["`inl`, weighted", "of `inl`, not weighted",
                 *(f"{gain(name, RPE):.2f} / {gain(name, ROE):.2f}" for name in unweighted)])
    return rows, list(unweighted)


def model_rows(results):
    models = json.loads((results / "noise/models.json").read_text())
    names = [name for name in SETS if name in models["nothing"]]
    return [[name, *(f"{models[name][s]['surprise'] - models['nothing'][s]['surprise']:+.3f}" for s in names)]
            for name in models if name != "nothing"], names


def noise_rows(results):
    constant = every(results, "noise/constant")
    rows = []
    for label, folder in (("0.5 px for all", "noise/constant"), ("motion, fitted to the other sets", "noise/held_out"),
                          ("motion, estimated as it goes", "noise/online")):
        runs = every(results, folder)
        cells = []
        for name in runs:
            for one in ("inl", "md"):
                shares = [math.exp(statistics.fmean(math.log(find(r, one)[key] / find(c, one)[key])
                                                    for r, c in zip(runs[name], constant[name]))) for key in (RPE, ROE)]
                cells.append(f"{shares[0]:.2f} / {shares[1]:.2f}")
        rows.append([label, *cells])
    header = ["noise"] + [f"{name}: `{one}`" for name in constant for one in ("inl", "md")]
    return header, rows


def target_rows(results):
    """For each set and target: how many, errors, and those of a fixed number, the mean of it."""
    targets, fixed = every(results, "targets"), every(results, "fixed")
    rows = []
    for name, runs in targets.items():
        levels = sorted({e["target_efficiency"] for e in runs[0] if e["target_efficiency"]})
        for level in levels:
            at = {"selector": "md", "target_efficiency": level}
            mean = lambda key: statistics.fmean(entry_of(r, **at)[key] for r in runs)
            share = statistics.fmean(entry_of(r, **at)["selected"] / find(r, "inl")["selected"] for r in runs)
            logs = {key: [] for key in (RPE, ROE)}
            for r, f in zip(runs, fixed[name]):
                budget = max(20, round(entry_of(r, **at)["selected"]))
                for key in logs:
                    logs[key].append(math.log(entry_of(f, selector="md", budget=budget)[key] / find(f, "inl")[key]))
            same = " / ".join(f"{math.exp(statistics.fmean(logs[key])):.2f}" for key in (RPE, ROE))
            rows.append([name, f"{level}", f"{100 * share:.0f} %", f"{mean('selected'):.0f}",
                         f"{mean('selected_min'):.0f} to {mean('selected_max'):.0f}", both(runs, **at), same])
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


def mean_budgets(folder):
    """What the targets have selected on the mean, as --budget takes it."""
    budgets = {max(20, round(e["selected"])) for e in results_of(folder) if e["target_efficiency"] is not None}
    return ",".join(str(k) for k in sorted(budgets))


def main():
    folder = pathlib.Path(sys.argv[1])
    if "--mean-budgets" in sys.argv:
        print(mean_budgets(folder / "targets" / sys.argv[3]))
        return
    summary = every(folder, "summary")
    for name, runs in summary.items():
        replace_between(PAGE, f"summary {name}", table(["selector", *(f"{k}" for k in BUDGETS), "ms of 100"], summary_rows(runs)))
    header = ["set", "what", "target", "found", "holds"]
    for name in ("md", "md_cells"):
        replace_between(PAGE, f"judged {name}", table(header, judged_rows(summary, name)) + ["", machine()])
    replace_between(PAGE, "active", table(["set", "RPE / ROE of `active`, of `md`'s", "≤ 1.05"], active_rows(summary)))
    rows, names = weights_rows(folder)
    replace_between(PAGE, "weights", table(["blocks of the selection", "weights of the optimiser", *names], rows))
    rows, names = model_rows(folder)
    replace_between(PAGE, "models", table(["variance a + b x, x being", *names], rows))
    replace_between(PAGE, "noise", table(*noise_rows(folder)))
    header = ["set", "target", "of the matches", "mean", "easiest to hardest frame", "RPE / ROE", "a fixed number"]
    replace_between(PAGE, "targets", table(header, target_rows(folder)))

    everything = results_of(folder / "all")
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
