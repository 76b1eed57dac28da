#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Rewrites the tables of docs/tracker.md from the results of the stereo odometry, and copies its picture.

Usage: write_page.py RESULTS [--mean-budgets SET/N]    RESULTS: the folder that ci/tracker_page fills
examples/stereo_odometry/results/*.csv get all rows and columns of tables that the page shortens. --mean-budgets only
prints how many matches each target selected on average.
"""

import datetime
import math
import pathlib
import shutil
import statistics
import sys

from maxlogdet_tools.files import json_of, rows_of, write_csv
from maxlogdet_tools.pages import paragraph, rewrite, table
from maxlogdet_tools.project import ROOT, cpu_model
from summaries import (ROE, RPE, SETS, both, changes, contestants, entry_of, every, find, geometric_mean, interval,
                       ratio, results_of)  # fmt: skip

PAGE = ROOT / "docs/tracker.md"
RECORDS = ROOT / "examples/stereo_odometry/results"
BATCHES = (5, 10, 20, 40, 100)
BLOCKS = ("measurement", "measurement_and_map", "map_bias")
WEIGHTS = ("measurement", "measurement_and_map")
STREETS = ("kitti_clip_1", "kitti_0039_a")
# The parts that the page shows; the records have everything.
SHOWN = [("kitti_clip_1", 30), ("kitti_clip_1", 100),
         ("kitti_0039_a", 30), ("kitti_0039_a", 100), ("kitti_0039_a", 200), ("tum_fr1_rpy_a", 100)]  # fmt: skip
SHOWN_TARGETS = [(name, level) for name in STREETS for level in (0.5, 0.7)]
HIDDEN = ("quality_md", "all_weighted")
STAGES = ("matching", "selection", "pose_optimization")


def record(name, header, rows):
    write_csv(RECORDS / name, header, rows)


def origin(results):
    """The machine of the numbers, and the day of the last one."""
    newest = max(path.stat().st_mtime for path in results.rglob("summary.json"))
    day = datetime.date.fromtimestamp(newest).isoformat()
    return f"{cpu_model()}, one thread, recorded {day}; `ci/tracker_page`."


# Every set, every selector.


def error_records(summary):
    """A line per set, selector and budget, for the record."""
    for name, runs in summary.items():
        for selector, budget in [*contestants(runs), ("inl", None)]:
            at = {"selector": selector, "budget": budget}
            mean = lambda value: statistics.fmean(value(entry_of(r, **at)) for r in runs)
            shares = [f"{ratio(runs, key, **at):.3f}" for key in (RPE, ROE)]
            halves = ["", ""] if selector == "inl" else [
                f"{interval(runs, error, **at)[1] / 100:.3f}" for error in ("rpe", "roe")]
            yield [name, selector, budget or "all", shares[0], halves[0], shares[1], halves[1],
                   f"{mean(lambda e: e[RPE]):.4f}", f"{mean(lambda e: e[ROE]):.3f}",
                   f"{mean(lambda e: e['inliers']):.0f}", f"{mean(lambda e: e['selected']):.0f}",
                   "" if selector == "active" else f"{mean(lambda e: e['efficiency']):.3f}",
                   *(f"{mean(lambda e: e['ms'][stage]):.3f}" for stage in STAGES)]  # fmt: skip


def set_rows(summary):
    for name, runs in summary.items():
        mean = lambda key: statistics.fmean(find(r, "inl")[key] for r in runs)
        yield [name, SETS[name], f"{mean(RPE):.3f}", f"{mean(ROE):.2f}", f"{mean('inliers'):.0f}"]


def error_rows(summary):
    """A row per selector with its errors at the shown budgets; and the intervals."""
    selectors = dict.fromkeys(selector for selector, _ in contestants(summary[STREETS[0]]))
    for selector in (s for s in selectors if s not in HIDDEN):
        has_budget = find(summary[STREETS[0]][0], selector)["budget"] is not None
        cells = [both(summary[name], selector=selector, budget=budget if has_budget else None)
                 if has_budget or budget == 100 else "" for name, budget in SHOWN]
        yield [f"`{selector}`", *cells]
    yield ["± (median)", *(half_widths(summary[name], budget) for name, budget in SHOWN)]


def half_widths(runs, budget):
    """The median half width of the 95 % intervals of all selectors with that budget."""
    selectors = [selector for selector, k in contestants(runs) if k == budget]
    median = lambda error: statistics.median(interval(runs, error, selector=s, budget=budget)[1] for s in selectors)
    return f"{median('rpe') / 100:.2f} / {median('roe') / 100:.2f}"


def write_errors(results, summary):
    header = ["set", "selector", "budget", "rpe_ratio", "rpe_ci95", "roe_ratio", "roe_ci95", RPE, ROE,
              "inliers", "selected", "efficiency", *(f"{stage}_ms" for stage in STAGES)]  # fmt: skip
    record("errors.csv", header, error_records(summary))
    rewrite(PAGE, "sets", table(["set", "images", "RPE (m/s)", "ROE (deg/s)", "inliers"], set_rows(summary)))
    lines = table(["selector", *(f"{name}, {budget}" for name, budget in SHOWN)], error_rows(summary))
    rewrite(PAGE, "errors", lines + ["", origin(results)])


# Goals, met and missed.


def error_goal(summary, selector, budget, target):
    """{set: (result, whether the goal is met)} of the larger of both errors, relative to inl."""
    found = {}
    for name, runs in summary.items():
        worst = max(ratio(runs, key, selector=selector, budget=budget) for key in (RPE, ROE))
        found[name] = (f"{worst:.3f}", worst <= target)
    return found


def chance_goal(summary, selector):
    """The same of the error farthest above its interval, compared with random selection and buckets."""
    found = {}
    for name, runs in summary.items():
        against = [interval(runs, error, rival, selector=selector, budget=100)
                   for rival in ("random", "bucket") for error in ("rpe", "roe")]
        percent, half = max(against, key=lambda d: d[0] - d[1])
        found[name] = (f"{percent:+.0f} ± {half:.0f} %", percent <= half)
    return found


def excess_goal(summary, selector, rival, target):
    excess = lambda one: statistics.fmean(ratio(runs, key, selector=one, budget=30) - 1
                                          for runs in summary.values() for key in (RPE, ROE))
    share = excess(selector) / excess(rival)
    return {"mean of all": (f"{share:.2f}", share <= target)}


def active_goal(summary):
    found = {}
    for name, runs in summary.items():
        worst = max(ratio(runs, key, selector="active", budget=100) / ratio(runs, key, selector="md", budget=100)
                    for key in (RPE, ROE))
        found[name] = (f"{worst:.3f}", worst <= 1.05)
    return found


def goals(summary):
    """(goal, selector, result on each set)"""
    for selector in ("md", "md_cells"):
        yield "100, errors at most 1.05 of `inl`'s", selector, error_goal(summary, selector, 100, 1.05)
        yield "200, errors at most 1.02 of `inl`'s", selector, error_goal(summary, selector, 200, 1.02)
        yield "100, not above `random` or `bucket` beyond the interval", selector, chance_goal(summary, selector)
        for rival, share, text in (("random", 1 / 2, "half"), ("bucket", 2 / 3, "two thirds")):
            yield (f"30, mean excess over `inl` at most {text} of `{rival}`'s", selector,
                   excess_goal(summary, selector, rival, share))
    yield "100, errors at most 1.05 of `md`'s", "active", active_goal(summary)


def write_goals(summary):
    rows, lines = [], []
    for goal, selector, found in goals(summary):
        rows += [[goal.replace("`", ""), selector, name, text, "yes" if holds else "no"]
                 for name, (text, holds) in found.items()]
        if selector != "md_cells":
            shown = ", ".join(text if holds else f"**{text}**" for text, holds in found.values())
            lines.append(f"- `{selector}`, {goal}: {shown}")
    record("goals.csv", ["goal", "selector", "set", "found", "holds"], rows)
    rewrite(PAGE, "goals", lines)


# Blocks, weights, and their noise.


def weights_records(results):
    """(set, blocks, weights, RPE, ROE) of md relative to inl with the same weights, and of inl with weights to without."""
    runs = {(blocks, weights): every(results, f"weights/{blocks}/{weights}")
            for blocks in BLOCKS for weights in WEIGHTS}
    for name in SETS:
        for (blocks, weights), of in runs.items():
            yield [name, blocks, weights, *both(of[name], selector="md").split(" / ")]
        plain, weighted = (runs["measurement", weights][name] for weights in WEIGHTS)
        yield [name, "inl weighted, of unweighted", WEIGHTS[1], *changes(weighted, plain, "inl").split(" / ")]


def write_weights(results):
    records = list(weights_records(results))
    record("weights.csv", ["set", "blocks", "weights", "rpe_ratio", "roe_ratio"], records)
    cells = {(name, blocks, weights): " / ".join(errors) for name, blocks, weights, *errors in records}
    columns = [(name, weights) for name in STREETS for weights in WEIGHTS]
    rows = [[blocks, *(cells.get((name, blocks, weights), "") for name, weights in columns)]
            for blocks in dict.fromkeys(record[1] for record in records)]
    rewrite(PAGE, "weights", table(["blocks", *(f"{name}: `{weights}`" for name, weights in columns)], rows))


def write_noise(results):
    models = json_of(results / "noise/models.json")
    names = [name for name in SETS if name in models["nothing"]]
    rows = [[x, *(f"{models[x][s]['mean_nll'] - models['nothing'][s]['mean_nll']:+.3f}" for s in names)]
            for x in models if x != "nothing"]
    rewrite(PAGE, "models", table(["x", *names], rows))

    constant = every(results, "noise/constant")
    rows = []
    for label, folder in (("fitted to the other sets", "held_out"), ("estimated online", "online")):
        runs = every(results, f"noise/{folder}")
        rows.append([label, *(changes(runs[name], constant[name], one) for name in runs for one in ("inl", "md"))])
    header = ["motion noise"] + [f"{name}: `{one}`" for name in constant for one in ("inl", "md")]
    rewrite(PAGE, "noise", table(header, rows))


# Targets of the efficiency.


def fixed_ratio(targets, fixed, level, key):
    """The error of md with a fixed budget, the mean number that the target selected in the same run."""
    shares = []
    for run, other in zip(targets, fixed):
        taken = entry_of(run, selector="md", target_efficiency=level)["selected"]
        e = entry_of(other, selector="md", budget=max(20, round(taken)))
        shares.append(e[key] / find(other, "inl")[key])
    return geometric_mean(shares)


def target_records(results):
    """{(set, target): share of the matches, mean, minimum and maximum of a frame, errors, those of a fixed budget}"""
    targets, fixed = every(results, "targets"), every(results, "fixed")
    records = {}
    for name, runs in targets.items():
        for level in sorted({e["target_efficiency"] for e in runs[0] if e["target_efficiency"]}):
            at = {"selector": "md", "target_efficiency": level}
            share = statistics.fmean(entry_of(r, **at)["selected"] / find(r, "inl")["selected"] for r in runs)
            numbers = [statistics.fmean(entry_of(r, **at)[key] for r in runs)
                       for key in ("selected", "selected_min", "selected_max")]
            errors = [ratio(runs, key, **at) for key in (RPE, ROE)]
            records[name, level] = [share, *numbers, *errors,
                                    *(fixed_ratio(runs, fixed[name], level, key) for key in (RPE, ROE))]  # fmt: skip
    return records


def write_targets(results):
    records = target_records(results)
    record("targets.csv", ["set", "target", "share", "mean", "min", "max", "rpe_ratio", "roe_ratio",
                              "fixed_rpe_ratio", "fixed_roe_ratio"],
              ([*key, *(f"{x:.{0 if 0 < i < 4 else 3}f}" for i, x in enumerate(record))]
               for key, record in records.items()))  # fmt: skip
    rows = []
    for name, level in SHOWN_TARGETS:
        share, mean, low, high, *errors = records[name, level]
        rows.append([name, f"{level}", f"{100 * share:.0f} %", f"{mean:.0f}", f"{low:.0f} to {high:.0f}",
                     *(f"{a:.2f} / {b:.2f}" for a, b in (errors[:2], errors[2:]))])  # fmt: skip
    header = ["set", "target", "of the matches", "mean", "per frame", "RPE / ROE", "fixed budget"]
    rewrite(PAGE, "targets", table(header, rows))


def mean_budgets(folder):
    """The mean numbers of matches that the targets selected, as an argument of --budget."""
    budgets = {max(20, round(e["selected"])) for e in results_of(folder) if e["target_efficiency"] is not None}
    return ",".join(str(k) for k in sorted(budgets))


# Active matching.


def cost_rows(name, results):
    """Times of the stages that selection makes cheaper, with and without the matches that active's keyframes add."""
    total = lambda e: sum(e["ms"][stage] for stage in STAGES)
    all_inliers = total(find(results, "inl"))
    for one in ("inl", "md", "active"):
        e = find(results, one)
        share = "" if one == "inl" else f"{total(e) / all_inliers:.2f}"
        rest = f"{(total(e) + e['ms_matching_the_rest']) / all_inliers:.2f}" if one == "active" else ""
        yield [name, f"`{one}`", *(f"{e['ms'][stage]:.3f}" for stage in STAGES), share, rest]


def write_active(results):
    rows = [*cost_rows("kitti_0039_a", results_of(results / "second")),
            *cost_rows("kitti_clip_1", results_of(results / "all"))]
    header = ["set", "selector", "matching (ms)", "selection (ms)", "pose opt. (ms)", "sum, of `inl`'s",
              "with keyframes' rest"]  # fmt: skip
    rewrite(PAGE, "cost", table(header, rows))
    rows = [[name, *(both([results_of(results / f"batch_{n}_{name}")], selector="active") for n in BATCHES)]
            for name in ("kitti_0039_a", "kitti_clip_1")]
    rewrite(PAGE, "batches", table(["set", *(f"{n}" for n in BATCHES)], rows))


# KITTI clip 1, and a camera at rest.


def clip_record(run, e):
    """Everything in summary.json about a selector, except the intervals against selectors other than inl."""
    against = [f"{e['against']['inl'][error][key]:.1f}" if e["selector"] != "inl" else ""
               for error in ("rpe", "roe") for key in ("percent", "ci95")]
    efficiency = "" if e["efficiency"] is None else f"{e['efficiency']:.3f}"
    return [run, e["selector"], f"{e['ate_m']:.3f}", f"{e[RPE]:.4f}", f"{e[ROE]:.4f}", *against,
            f"{e['rpe_1s_m_per_s']:.4f}", f"{e['roe_1s_deg_per_s']:.4f}", f"{e['tracked_percent']:.1f}",
            *(f"{e['ms'][stage]:.3f}" for stage in ("base", *STAGES, "total")),
            f"{e['inliers']:.0f}", f"{e['selected']:.0f}", efficiency]  # fmt: skip


def beyond(run, error):
    """The selectors whose error is higher or lower than inl's beyond the interval, as text."""
    found = {1: [], -1: []}
    for e in (e for e in run if e["selector"] not in ("inl", "all_weighted")):
        percent, half = (e["against"]["inl"][error][key] for key in ("percent", "ci95"))
        if abs(percent) > half:
            found[math.copysign(1, percent)].append(f"`{e['selector']}`")
    return ", ".join(f"{word} with {', '.join(found[sign])}" for sign, word in ((1, "higher"), (-1, "lower"))
                     if found[sign]) or "no different"


def write_clip(results):
    runs = {name: results_of(results / name) for name in ("all", "stochastic", "monocular")}
    record("kitti_clip_1.csv",
              ["run", "selector", "ate_m", RPE, ROE, "rpe_percent", "rpe_ci95", "roe_percent", "roe_ci95",
               "rpe_1s_m_per_s", "roe_1s_deg_per_s", "tracked_percent",
               *(f"{stage}_ms" for stage in ("base", *STAGES, "total")), "inliers", "selected", "efficiency"],
              (clip_record(name, e) for name, run in runs.items() for e in run))  # fmt: skip
    greedy, stochastic = (find(runs[name], "md") for name in ("all", "stochastic"))
    of = lambda e: (f"{e['ms']['selection']:.3f} ms, efficiency {e['efficiency']:.3f}, RPE {e[RPE]:.4f} m/s and "
                    f"ROE {e[ROE]:.4f} deg/s")
    rewrite(PAGE, "clip", paragraph(
        f"Beyond the 95 % interval, compared with `inl`, RPE is {beyond(runs['all'], 'rpe')}; "
        f"ROE is {beyond(runs['all'], 'roe')}. Lazy greedy takes {of(greedy)}; "
        f"stochastic greedy, ε = 0.1, {of(stochastic)}."))  # fmt: skip
    shutil.copy(results / "all/trajectory.svg", ROOT / "docs/images/tracker_trajectory.svg")


def write_rest(results):
    lines = (results / "rest/md/trajectory_tum.txt").read_text().splitlines()
    poses = [line.split() for line in lines if line[0] != "#"]
    drift = max(math.hypot(*(float(x) for x in pose[1:4])) for pose in poses)
    active, md = (find(results_of(results / "rest"), one) for one in ("active", "md"))
    keyframes = sum(row["keyframe"] == "1" for row in rows_of(results / "rest/md/frames.csv"))
    rewrite(PAGE, "rest", paragraph(
        f"Over {float(poses[-1][0]) - float(poses[0][0]):.1f} s the camera seems to move by {1000 * drift:.1f} mm at "
        f"most (`md`), and {keyframes} keyframe(s) are made: matching takes {md['ms']['matching']:.2f} ms with `md`, "
        f"{active['ms']['matching']:.2f} ms with `active`."))  # fmt: skip


def main():
    results = pathlib.Path(sys.argv[1])
    if "--mean-budgets" in sys.argv:
        print(mean_budgets(results / "targets" / sys.argv[3]))
        return
    summary = every(results, "summary")
    if set(summary) != set(SETS):
        sys.exit(f"{results}/summary: expected the sets {', '.join(SETS)}; tracker_page records them")
    write_errors(results, summary)
    write_goals(summary)
    write_weights(results)
    write_noise(results)
    write_targets(results)
    write_active(results)
    write_clip(results)
    write_rest(results)


main()
