#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Rewrites the tables of docs/odometry.md from the results of the stereo odometry.

Usage: write_page.py RESULTS    RESULTS: the folder that bench/run does_it_track fills
bench/does_it_track/results/*.csv get all rows and columns of tables that the page shortens.
"""

import datetime
import pathlib
import sys

from maxlogdet_tools.files import json_of, write_csv
from maxlogdet_tools.pages import paragraph, rewrite, table
from maxlogdet_tools.project import ROOT, cpu_model

PAGE = ROOT / "docs/odometry.md"
RECORDS = ROOT / "bench/does_it_track/results"
SETS = {
    "kitti_clip_1": "a straight road, 51 stereo pairs at 10 Hz",
    "kitti_0039_a": "a town, 120 stereo pairs at 10 Hz",
    "tum_fr1_rpy_a": "hand-held RGB-D, mostly rotating, blur and rolling shutter, 120 pairs at 30 Hz",
}
BUDGETS = (30, 60, 100, 150, 200)
SELECTORS = ("md_spread", "md", "md_cells", "bucket", "random", "quality")
LENGTHS = {"translation": "translation_mm", "rotation": "rotation_mrad"}


def origin(results):
    """The machine of the numbers, and the day of the last one."""
    newest = max(path.stat().st_mtime for path in results.rglob("summary.json"))
    day = datetime.date.fromtimestamp(newest).isoformat()
    return f"{cpu_model()}, one thread, recorded {day}; `bench/run does_it_track`."


def interval(value, low, high, digits=2):
    return f"{value:.{digits}f} ({low:.{digits}f} to {high:.{digits}f})"


def spread(entry, digits=2, value="median"):
    return interval(entry[value], entry["low"], entry["high"], digits)


def find(entries, **which):
    return next(e for e in entries if all(e[key] == value for key, value in which.items()))


# All selectors on the same frames.


def deviation(entry):
    return " / ".join(spread(entry[key], digits) for key, digits in (("translation_mm", 1), ("rotation_mrad", 2)))


def worth(entry):
    return interval(entry["worth_random"], entry["worth_random_low"], entry["worth_random_high"], 0)


def ratio(entry):
    return " / ".join(f"{entry[key]['ratio']:.1f}" for key in LENGTHS.values())


def same_frame_table(evaluation, selectors):
    of = lambda selector: [find(evaluation["selectors"], selector=selector, budget=k) for k in BUDGETS]
    rows = [[f"`{selector}`", *(deviation(e) for e in of(selector))] for selector in selectors]
    for selector in ("md_spread", "md"):
        rows.append([f"random matches worth `{selector}`'s", *(worth(e) for e in of(selector))])
    rows.append(["`md`, measured / predicted", *(ratio(e) for e in of("md"))])
    return table(["selector", *(f"{k} matches" for k in BUDGETS)], rows)


def same_frame_records(name, evaluation):
    for e in evaluation["selectors"]:
        if e["selector"] == "own":
            continue
        lengths = [f"{e[key][x]:.4g}" for key in LENGTHS.values() for x in ("median", "low", "high", "p90", "predicted")]
        worths = [f"{e[key]:.0f}" if key in e else "" for key in ("worth_random", "worth_bucket")]
        truth = [f"{e['truth'][f'{x}_of_all{end}']:.3f}" for x in LENGTHS for end in ("", "_low", "_high")]
        yield [name, e["selector"], e["budget"], e["frames"], *lengths, *worths, *truth]


def write_same_frames(results):
    records = []
    for kind in ("stereo", "monocular", "measurement"):
        for name in SETS:
            evaluation = json_of(results / kind / name / "same_frame.json")
            records += same_frame_records(f"{name}, {kind}", evaluation)
            if kind == "stereo":
                rewrite(PAGE, name, same_frame_table(evaluation, SELECTORS))
    statistics = [f"{x}_{y}" for x in LENGTHS.values() for y in ("median", "low", "high", "p90", "predicted")]
    truths = [f"{x}_of_all{end}" for x in LENGTHS for end in ("", "_low", "_high")]
    write_csv(RECORDS / "same_frame.csv",
              ["set", "selector", "budget", "frames", *statistics, "worth_random", "worth_bucket", *truths], records)  # fmt: skip


def write_findings(results):
    entries = [json_of(results / "stereo" / name / "same_frame.json")["selectors"] for name in SETS]
    worths = lambda selector: ", ".join(f"{find(e, selector=selector, budget=100)['worth_random']:.0f}" for e in entries)
    shares = lambda rival: [find(e, selector="md_spread", budget=30)[key]["median"] /
                            find(e, selector=rival, budget=30)[key]["median"]
                            for e in entries for key in LENGTHS.values()]  # fmt: skip
    rewrite(PAGE, "findings", paragraph(
        f"**100 matches of `md_spread` are worth {worths('md_spread')} random ones on the three sets; 100 of plain `md` "
        f"are worth {worths('md')}.** With 30 matches `md_spread` deviates by {min(shares('random')):.2f} to "
        f"{max(shares('random')):.2f} of what `random` does, and by {min(shares('bucket')):.2f} to "
        f"{max(shares('bucket')):.2f} of what `bucket` does, over sets, translation and rotation."))  # fmt: skip


def write_noise_of_matches(results):
    rows = []
    for name in SETS:
        e = json_of(results / "stereo" / name / "same_frame.json")
        chi2 = e["chi2_by_leverage"]
        correlation = lambda key: interval(e[key], e[f"{key}_interval"]["low"], e[f"{key}_interval"]["high"])
        rows.append([name, SETS[name], f"{e['inliers']:.0f}", f"{chi2[0]:.2f} ... {chi2[-1]:.2f}",
                     correlation("cell_correlation"), correlation("cell_correlation_selected")])  # fmt: skip
    header = ["set", "images", "inliers", "chi2, lowest to highest tenth of leverage", "correlation of all",
              "correlation of `md`'s 100"]  # fmt: skip
    rewrite(PAGE, "sets", table(header, rows))


def write_monocular(results):
    rows = []
    for name in SETS:
        entries = json_of(results / "monocular" / name / "same_frame.json")["selectors"]
        rows += [[name, f"`{selector}`", *(deviation(find(entries, selector=selector, budget=k)) for k in (30, 100, 200))]
                 for selector in ("md_spread", "random")]
    rewrite(PAGE, "monocular", table(["set", "selector", "30 matches", "100 matches", "200 matches"], rows))


def write_weights(results):
    rows = []
    for name in SETS:
        for weights, kind in (("measurement", "measurement"), ("measurement_and_map", "stereo")):
            e = json_of(results / kind / name / "same_frame.json")
            chi2 = e["chi2_by_leverage"]
            find_at_100 = lambda selector: find(e["selectors"], selector=selector, budget=100)
            truth = find_at_100("md")["truth"]
            of_all = [truth[key] / truth[f"{x}_of_all"] for x, key in LENGTHS.items()]
            rows.append([name, f"`{weights}`", f"{chi2[0]:.2f} ... {chi2[-1]:.2f}", deviation(find_at_100("md_spread")),
                         deviation(find_at_100("random")), f"{of_all[0]:.1f} / {of_all[1]:.2f}"])  # fmt: skip
    header = ["set", "blocks and weights", "chi2, lowest to highest tenth", "`md_spread`, 100 (mm / mrad)",
              "`random`, 100 (mm / mrad)", "error of all inliers (mm / mrad)"]  # fmt: skip
    rewrite(PAGE, "weights", table(header, rows))


def write_truth(results):
    entries = {name: json_of(results / "stereo" / name / "same_frame.json")["selectors"] for name in SETS}
    of = lambda truth, x: interval(truth[f"{x}_of_all"], truth[f"{x}_of_all_low"], truth[f"{x}_of_all_high"])
    cell = lambda e: " / ".join(of(e["truth"], x) for x in LENGTHS)
    rows = [[f"`{selector}`", f"{k}", *(cell(find(entries[name], selector=selector, budget=k)) for name in SETS)]
            for k in (30, 100) for selector in ("md_spread", "md", "random")]
    rewrite(PAGE, "truth", table(["selector", "matches", *SETS], rows))


# The order of matching.


def write_matching(results):
    rows, records = [], []
    for name in SETS:
        entries = json_of(results / "stereo" / name / "matching.json")
        for e in entries:
            lengths = [f"{e[key][x]:.4g}" for key in LENGTHS.values() for x in ("median", "low", "high")]
            records.append([name, e["order"], e["budget"], e["frames"], f"{e['searched']:.0f}", *lengths])
        for k in (30, 100):
            active, random_order = (find(entries, order=order, budget=k) for order in ("active", "active_random"))
            rows.append([name, f"{k}", f"{active['searched']:.0f} / {random_order['searched']:.0f}",
                         *(spread(active[f"{x}_of_random_order"], value="ratio") for x in LENGTHS)])  # fmt: skip
    header = ["set", "order", "budget", "frames", "searched"]
    write_csv(RECORDS / "matching.csv",
              [*header, *(f"{x}_{y}" for x in LENGTHS.values() for y in ("median", "low", "high"))], records)  # fmt: skip
    header = ["set", "matches", "points searched, information / random", "translation, of random order's",
              "rotation, of random order's"]  # fmt: skip
    rewrite(PAGE, "matching", table(header, rows))


def write_times(results):
    rows = []
    for name in SETS:
        entries = json_of(results / "stereo" / name / "summary.json")
        for selector in ("inl", "active", "active_random"):
            e = find(entries, selector=selector)
            ms = e["ms"]
            rest = e["ms_matching_the_rest"]
            total = ms["matching"] + ms["selection"] + ms["pose_optimization"] + rest
            rows.append([name, f"`{selector}`", f"{ms['matching']:.2f}", f"{ms['selection']:.2f}", f"{rest:.2f}",
                         f"{total:.2f}"])  # fmt: skip
    header = ["set", "selector", "matching (ms)", "selection (ms)", "rest at keyframes (ms)",
              "sum with pose optimisation (ms)"]  # fmt: skip
    rewrite(PAGE, "times", table(header, rows))


# Whole runs.


def write_whole_runs(results):
    summaries = {name: json_of(results / "stereo" / name / "summary.json") for name in SETS}
    cell = lambda e: " / ".join(spread(e[f"{key}_of_inl"], value="mean") for key in ("rpe", "roe"))
    rows = [[f"`{selector}`", *(cell(find(summaries[name], selector=selector)) for name in SETS)]
            for selector in ("md", "active", "active_random", "random", "all")]
    inl = [find(summaries[name], selector="inl") for name in SETS]
    rows.append(["`inl`, m/s / deg/s", *(f"{e['rpe_m_per_s']:.3f} / {e['roe_deg_per_s']:.2f}" for e in inl)])
    rewrite(PAGE, "whole_runs", [*table(["selector", *SETS], rows), "", origin(results)])


# What the noise of a match depends on.


def write_noise(results):
    models = json_of(results / "noise/models.json")
    rows = [[x, *(f"{models[x][s]['mean_nll'] - models['nothing'][s]['mean_nll']:+.3f}" for s in SETS)]
            for x in models if x != "nothing"]
    rewrite(PAGE, "models", table(["x", *SETS], rows))


def main():
    results = pathlib.Path(sys.argv[1])
    missing = [name for name in SETS if not (results / "stereo" / name / "same_frame.json").exists()]
    if missing:
        sys.exit(f"{results}/stereo: expected the sets {', '.join(missing)}; tracker_page records them")
    for write in (write_noise_of_matches, write_findings, write_same_frames, write_truth, write_monocular,
                  write_weights, write_matching, write_times, write_whole_runs, write_noise):  # fmt: skip
        write(results)


main()
