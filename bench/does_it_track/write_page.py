#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Rewrites the tables of docs/odometry.md from the results of the stereo odometry, and docs/images/matches.png.

Usage: write_page.py RESULTS    RESULTS: the folder that bench/run does_it_track fills
bench/does_it_track/results/*.csv get all rows and columns of tables that the page shortens.
"""

import pathlib
import shutil
import sys

from maxlogdet_tools.files import json_of, write_csv
from maxlogdet_tools.pages import paragraph, rewrite, table
from maxlogdet_tools.project import ROOT, shown
from maxlogdet_tools.runs import stamp

PAGE = ROOT / "docs/odometry.md"
PICTURE = ROOT / "docs/images/matches.png"
MAX_PICTURE = 250_000  # bytes
RECORDS = pathlib.Path(__file__).parent / "results"
SETS = {
    "kitti_clip_1": "stereo at 10 Hz, a straight road",
    "kitti_0039_a": "stereo at 10 Hz, a town",
    "tum_fr1_rpy_a": "RGB-D at 30 Hz, hand-held, mostly rotating",
}
KINDS = {"stereo": "measurement_and_map", "measurement": "measurement", "monocular": "measurement_and_map"}
LENGTHS = {"translation": "translation_mm", "rotation": "rotation_mrad"}
STATISTICS = ("median", "low", "high", "p90", "predicted")
STAGES = ("base", "matching", "selection", "pose_optimization", "total")


def find(entries, **which):
    return next(e for e in entries if all(e[key] == value for key, value in which.items()))


def listed(texts):
    return ", ".join(texts[:-1]) + " and " + texts[-1]


# All selectors on the same frames.


def with_interval(entry, key):
    names = (key, f"{key}_low", f"{key}_high")
    return [f"{entry[name]:.0f}" if key in entry else "" for name in names]


def same_frame_records(name, kind, evaluation):
    for e in evaluation["selectors"]:
        if e["selector"] == "own":
            continue
        lengths = [f"{e[key][x]:.4g}" for key in LENGTHS.values() for x in STATISTICS]
        worths = [*with_interval(e, "worth_random"), *with_interval(e, "worth_bucket")]
        truth = [f"{e['truth'][f'{x}_of_all{end}']:.3f}" for x in LENGTHS for end in ("", "_low", "_high")]
        yield [name, kind, e["selector"], e["budget"], e["frames"], *lengths, *worths, *truth]


def noise_record(name, kind, e):
    correlations = [f"{x:.3f}" for key in ("cell_correlation", "cell_correlation_selected")
                    for x in (e[key], e[f"{key}_interval"]["low"], e[f"{key}_interval"]["high"])]  # fmt: skip
    return [name, kind, f"{e['inliers']:.0f}", *correlations, *(f"{x:.3f}" for x in e["chi2_by_leverage"])]


def write_records_of_same_frames(results):
    records, noise = [], []
    for kind in KINDS:
        for name in SETS:
            evaluation = json_of(results / kind / name / "same_frame.json")
            records += same_frame_records(name, kind, evaluation)
            noise.append(noise_record(name, kind, evaluation))
    ends = ("", "_low", "_high")
    write_csv(RECORDS / "same_frame.csv",
              ["set", "kind", "selector", "budget", "frames",
               *(f"{x}_{y}" for x in LENGTHS.values() for y in STATISTICS),
               *(f"worth_{x}{end}" for x in ("random", "bucket") for end in ends),
               *(f"{x}_of_all{end}" for x in LENGTHS for end in ends)], records)  # fmt: skip
    write_csv(RECORDS / "noise_of_matches.csv",
              ["set", "kind", "inliers",
               *(f"{x}{end}" for x in ("correlation", "correlation_selected") for end in ends),
               *(f"chi2_tenth_{i}" for i in range(1, 11))], noise)  # fmt: skip


def write_findings(results):
    entries = [json_of(results / "stereo" / name / "same_frame.json")["selectors"] for name in SETS]
    worths = lambda selector: listed([f"{find(e, selector=selector, budget=100)['worth_random']:.0f}" for e in entries])
    shares = [find(e, selector="md_spread", budget=30)[key]["median"] /
              find(e, selector="random", budget=30)[key]["median"]
              for e in entries for key in LENGTHS.values()]  # fmt: skip
    rewrite(PAGE, "findings", paragraph(
        f"On three recordings, 100 matches selected with spread give the pose that {worths('md_spread')} random "
        f"matches give. 100 matches selected without spread are worth {worths('md')} random ones. With 30 matches and "
        f"spread, the pose deviates from the pose of all inliers {min(shares):.2f} to {max(shares):.2f} times as much "
        "as with random matches."))  # fmt: skip


def write_sets(results):
    rows = []
    for name, images in SETS.items():
        e = json_of(results / "stereo" / name / "same_frame.json")
        ratio = find(e["selectors"], selector="md", budget=100)["translation_mm"]["ratio"]
        rows.append([f"`{name}`", images, f"{e['inliers']:.0f}", f"{e['cell_correlation']:.2f}",
                     f"{e['cell_correlation_selected']:.2f}", f"{ratio:.1f}"])  # fmt: skip
    rewrite(PAGE, "sets", table(["recording", "images", "inliers (count)", "correlation, all (ratio)",
                                 "correlation, selected (ratio)", "excess (ratio)"], rows))  # fmt: skip


def write_worth(results):
    entries = [json_of(results / "stereo" / name / "same_frame.json")["selectors"] for name in SETS]
    worth = lambda e, selector, k: f"{find(e, selector=selector, budget=k)['worth_random']:.0f}"
    rows = [[f"`{selector}`", f"{k}", *(worth(e, selector, k) for e in entries)]
            for selector in ("md_spread", "md") for k in (30, 60, 100, 200)]
    rewrite(PAGE, "worth", table(["selector", "matches (count)", *(f"`{name}` (count)" for name in SETS)], rows))


def write_truth(results):
    entries = [json_of(results / "stereo" / name / "same_frame.json")["selectors"] for name in SETS]
    ratio = lambda e, selector: f"{find(e, selector=selector, budget=30)['truth']['translation_of_all']:.2f}"
    rows = [[f"`{selector}`", *(ratio(e, selector) for e in entries)] for selector in ("md_spread", "md", "random")]
    rewrite(PAGE, "truth", table(["selector", *(f"`{name}` (ratio)" for name in SETS)], rows))


def write_weights(results):
    rows = []
    for name in SETS:
        for kind in ("measurement", "stereo"):
            entries = json_of(results / kind / name / "same_frame.json")["selectors"]
            deviation = lambda which: find(entries, selector=which, budget=100)["translation_mm"]["median"]
            rows.append([f"`{name}`", f"`{KINDS[kind]}`", *(f"{deviation(x):.1f}" for x in ("md_spread", "random"))])
    rewrite(PAGE, "weights", table(["recording", "weighting", "`md_spread` (mm)", "`random` (mm)"], rows))


# The order of matching.


def write_matching(results):
    rows, records = [], []
    ratios = [(f"{x}_of_random_order", y) for x in LENGTHS for y in ("ratio", "low", "high")]
    for name in SETS:
        entries = json_of(results / "stereo" / name / "matching.json")
        for e in entries:
            lengths = [f"{e[key][x]:.4g}" for key in LENGTHS.values() for x in ("median", "low", "high")]
            of_random = [f"{e[key][x]:.3f}" if key in e else "" for key, x in ratios]
            records.append([name, e["order"], e["budget"], e["frames"], f"{e['searched']:.0f}", *lengths, *of_random])
        for k in (30, 100):
            active, random_order = (find(entries, order=order, budget=k) for order in ("active", "active_random"))
            rows.append([f"`{name}`", f"{k}", f"{active['searched']:.0f}", f"{random_order['searched']:.0f}",
                         *(f"{active[f'{x}_of_random_order']['ratio']:.2f}" for x in LENGTHS)])  # fmt: skip
    write_csv(RECORDS / "matching.csv",
              ["set", "order", "budget", "frames", "searched",
               *(f"{x}_{y}" for x in LENGTHS.values() for y in ("median", "low", "high")),
               *(key if y == "ratio" else f"{key}_{y}" for key, y in ratios)], records)  # fmt: skip
    rewrite(PAGE, "matching", table(["recording", "matches (count)", "searched, `active` (count)",
                                     "searched, `active_random` (count)", "translation (ratio)", "rotation (ratio)"],
                                    rows))  # fmt: skip


# Whole runs.


def write_whole_runs(results):
    records = []
    for name in SETS:
        for e in json_of(results / "stereo" / name / "summary.json"):
            ratios = [f"{e[key][x]:.3f}" for key in ("rpe_of_inl", "roe_of_inl") for x in ("mean", "low", "high")]
            times = [f"{e['ms'][stage]:.3f}" for stage in STAGES]
            records.append([name, e["selector"], e["budget"], e["runs"], f"{e['tracked_percent']:.1f}",
                            f"{e['rpe_m_per_s']:.4f}", f"{e['roe_deg_per_s']:.4f}", *ratios, *times,
                            f"{e['ms_matching_the_rest']:.3f}"])  # fmt: skip
    ratios = [f"{key}_of_inl{end}" for key in ("rpe", "roe") for end in ("", "_low", "_high")]
    write_csv(RECORDS / "whole_runs.csv",
              ["set", "selector", "budget", "runs", "tracked_percent", "rpe_m_per_s", "roe_deg_per_s", *ratios,
               *(f"ms_{stage}" for stage in STAGES), "ms_matching_the_rest"], records)  # fmt: skip


# What the noise of a match depends on.


def write_noise(results):
    models = json_of(results / "noise/models.json")
    records = [[x, name, f"{fit['a']:.5g}", f"{fit['b']:.5g}", f"{fit['mean_nll']:.4f}",
                f"{fit['mean_nll'] - models['nothing'][name]['mean_nll']:+.4f}"]
               for x, fits in models.items() for name, fit in fits.items()]  # fmt: skip
    write_csv(RECORDS / "noise_models.csv", ["x", "set", "a", "b", "mean_nll", "mean_nll_less_constant"], records)


def copy_picture(results):
    drawn = list(results.glob("picture/md_spread/overlay_*.png"))
    newest = max(drawn, key=lambda path: path.name)
    if newest.stat().st_size > MAX_PICTURE:
        sys.exit(f"{newest}: {newest.stat().st_size} bytes; expected at most {MAX_PICTURE}, as README.md shows it")
    shutil.copyfile(newest, PICTURE)
    print(f"wrote {shown(PICTURE)}")


def main():
    results = pathlib.Path(sys.argv[1])
    missing = [name for name in SETS if not (results / "stereo" / name / "same_frame.json").exists()]
    if missing:
        sys.exit(f"{results}/stereo: expected the sets {', '.join(missing)}; tracker_page records them")
    for write in (write_records_of_same_frames, write_findings, write_sets, write_worth, write_truth, write_weights,
                  write_matching, write_whole_runs, write_noise, copy_picture):  # fmt: skip
        write(results)
    stamp(PAGE, "does_it_track")


main()
