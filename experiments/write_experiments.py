#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Rewrites the tables of docs/experiments.md from what `maxlogdet simulate` wrote, and copies its pictures beside them.

Usage: write_experiments.py RESULTS    RESULTS: the folder that ci/experiments fills
A table stands between the lines '<!-- begin NAME -->' and '<!-- end NAME -->'.
"""

import csv
import pathlib
import re
import shutil
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "bench"))

from write_tables import replace_between, table  # noqa: E402

PAGE = ROOT / "docs/experiments.md"
RIVALS = ["max_trace", "min_condition", "max_min_eigenvalue", "random"]
PANELS = [(noise, column) for noise in ("1", "2") for column in ("rms_translation_m", "rms_rotation_deg")]
BETTER, WORSE, OPEN = "▲", "▼", "·"

METRIC_VARIANTS = [
    ("metrics", "measurement", "as above"),
    ("metrics", "map_bias", "as above"),
    ("metrics", "measurement_and_map", "as above"),
    ("metrics_volume", "measurement", "depths uniform in space, 2 to 20 m: most points far"),
    ("metrics_inverse", "measurement", "depths uniform in 1/z, 2 to 20 m: most points near"),
    ("metrics_near", "measurement", "depths uniform, 2 to 10 m"),
    ("metrics_prior", "measurement", "prior I instead of 1e-5 I"),
    ("metrics_unbiased", "measurement", "map error without bias"),
    ("metrics_unbiased", "map_bias", "map error without bias"),
]
TRACKING_VARIANTS = [
    ("euroc_default", "as above (`map_bias` blocks)"),
    ("euroc_measurement", "`measurement` blocks"),
    ("euroc_both", "`measurement_and_map` blocks"),
    ("euroc_bias", "three times the keyframe errors (0.1 m, 0.6 deg, 3 %)"),
    ("euroc_scale", "keyframes wrong in scale alone (5 %)"),
    ("euroc_outliers", "30 % wrong matches"),
    ("euroc_few", "at most 300 matches a frame"),
    ("euroc_stochastic", "stochastic greedy, ε = 0.1, as the paper"),
]

# Zhao & Vela's own figures: averages of tables II (RPE in m/s, ROE in deg/s) and III (ATE in m), and table IV (ms).
PAPER_SEQUENCES = ["MH_01_easy", "MH_02_easy", "MH_03_medium", "MH_04_difficult", "MH_05_difficult", "V1_01_easy",
                   "V2_01_easy", "V2_02_medium"]
PAPER_RELATIVE = {
    "quality": (0.047, 0.30),
    "bucket": (0.051, 0.32),
    "observability": (0.048, 0.35),
    "md": (0.042, 0.29),
    "quality_md": (0.032, 0.26),
    "inl": (0.059, 0.35),
    "all": (0.061, 0.32),
}
PAPER_ABSOLUTE = {"all": 0.31, "inl": 0.27, "quality_md": 0.13}
PAPER_MS = {
    "quality": ("0.00", "0.35"),
    "bucket": ("0.11", "0.34"),
    "observability": ("2.6", "0.32"),
    "md": ("3.0", "0.40"),
    "quality_md": ("1.5", "0.34"),
    "inl": ("-", "2.4"),
    "all": ("-", "2.6"),
}


class Experiment:
    """One folder of results: the tables of its NAME.md by their headings, and its CSV files."""

    def __init__(self, results, folder):
        self.folder = pathlib.Path(results) / folder
        self.name = folder.split("_")[0]
        text = (self.folder / f"{self.name}.md").read_text()
        self.sections = re.findall(r"^([^|\n].*)\n\n((?:\|.*\n)+)", text, flags=re.MULTILINE)

    def table(self, *words):
        """Lines of the one table whose heading has all these words."""
        found = [lines for heading, lines in self.sections if all(word in heading for word in words)]
        if len(found) != 1:
            sys.exit(f"{self.folder}: expected one table about {words}, found {len(found)}")
        return found[0].rstrip("\n").split("\n")

    def cells(self, *words):
        """The same as a dictionary from a row's first cell to its cells by column."""
        rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in self.table(*words)]
        return {row[0]: dict(zip(rows[0], row)) for row in rows[2:]}

    def csv(self, file):
        with open(self.folder / file, newline="") as lines:
            return list(csv.DictReader(lines))

    def seconds(self):
        return float((self.folder / "seconds").read_text())


def mean(values):
    values = list(values)
    return sum(values) / len(values)


# Section III.


def means_over_sizes(rows, weighting, column, noise):
    chosen = [r for r in rows if r["weighting"] == weighting and r["noise_px"] == noise]
    selectors = dict.fromkeys(r["selector"] for r in chosen)
    return {s: mean(float(r[column]) for r in chosen if r["selector"] == s) for s in selectors}


def lowest_table(metrics, weightings):
    rows = metrics.csv("metrics.csv")
    lines = []
    for weighting in weightings:
        cells = [f"`{weighting}`"]
        for noise, column in PANELS:
            means = means_over_sizes(rows, weighting, column, noise)
            order = sorted(["max_log_det", *RIVALS], key=means.get)
            unit = "m" if column.endswith("_m") else "deg"
            cells.append(f"{order[0]} {means[order[0]]:.4f}, then {order[1]} {means[order[1]]:.4f} ({unit})")
        lines.append(cells)
    return table(["blocks", "translation, 1 px", "rotation, 1 px", "translation, 2 px", "rotation, 2 px"], lines)


def aligned_table(metrics, weighting):
    rows = metrics.csv("metrics_aligned.csv")
    lines = []
    for selector in ["max_log_det", *RIVALS, "all", "all_weighted"]:
        means = [means_over_sizes(rows, weighting, column, noise)[selector] for noise, column in PANELS]
        lines.append([selector, *(f"{value:.4f}" for value in means)])
    return table(["selector", "translation, 1 px (m)", "rotation, 1 px (deg)", "translation, 2 px (m)",
                  "rotation, 2 px (deg)"], lines)


def signs(cells, selectors):
    text = "".join(cell[-1] for s in selectors for name, cell in cells[s].items() if name != "selector")
    return " ".join(f"{text.count(sign)} {sign}" for sign in (BETTER, OPEN, WORSE) if sign in text)


def metric_variants_table(results):
    lines = []
    for folder, weighting, what in METRIC_VARIANTS:
        cells = Experiment(results, folder).cells("Mean over subset sizes", f"`{weighting}`")
        lines.append([what, f"`{weighting}`", signs(cells, RIVALS), signs(cells, ["all"]),
                      signs(cells, ["all_weighted"])])
    return table(["scene and assumptions", "blocks", "against the other metrics and random (16)", "against all (4)",
                  "against all_weighted (4)"], lines)


# Robustness.


def robustness_rows(results, folder, budget):
    rows = Experiment(results, folder).csv("robustness.csv")
    return {(r["disturbance"], r["selector"]): r for r in rows if r["budget"] == budget}


def difference(row, error):
    value, ci95 = (float(row[f"{prefix}md_{error}_percent"]) for prefix in ("", "ci95_"))
    sign = OPEN if not abs(value) > ci95 else BETTER if value < 0 else WORSE
    return f"{value:.1f} ± {ci95:.1f} {sign}"


def tau_table(results):
    lines = []
    for tau, folder in [("0.1", "robustness_tau_0.1"), ("0.25", "robustness_tau_0.25"), ("0.5", "robustness"),
                        ("1", "robustness_tau_1"), ("2", "robustness_tau_2")]:
        rows = robustness_rows(results, folder, "60")
        lines.append([tau, *(", ".join(difference(rows[key], error) for error in ("translation", "rotation"))
                             for key in [("none", "shared_cells"), ("patches", "shared_cells"),
                                         ("none", "shared_keyframes"), ("batches", "shared_keyframes")])])
    return table(["τ (px)", "md against shared_cells, none", "patches", "md against shared_keyframes, none", "batches"],
                 lines)


def robustness_tables(results):
    with_60 = "60 of 500 matches"
    experiment = lambda folder: Experiment(results, folder)
    return {
        "robustness_levels": experiment("robustness").table("RMS errors", with_60),
        "robustness": experiment("robustness").table("Difference", with_60),
        "robustness_kitti": experiment("robustness_kitti").table("Difference", with_60),
        "robustness_gate": experiment("robustness_gate").table("Difference", with_60),
        "robustness_tau": tau_table(results),
    }


# Section V.


def beside_paper_table(euroc):
    rows = [r for r in euroc.csv("euroc.csv") if r["sequence"] in PAPER_SEQUENCES]
    average = lambda s, column: mean(float(r[column]) for r in rows if r["selector"] == s)
    change = lambda value, reference: f"{100 * (value / reference - 1):+.0f} %"
    lines = []
    for selector, (rpe, roe) in PAPER_RELATIVE.items():
        ours = [change(average(selector, c), average("all", c)) for c in ("rpe_m_per_s", "roe_deg_per_s", "ate_m")]
        papers = [change(rpe, PAPER_RELATIVE["all"][0]), change(roe, PAPER_RELATIVE["all"][1])]
        ate = PAPER_ABSOLUTE.get(selector)
        papers.append("-" if ate is None else change(ate, PAPER_ABSOLUTE["all"]))
        lines.append([selector, *(cell for pair in zip(ours, papers) for cell in pair)])
    return table(["against all", "RPE", "paper", "ROE", "paper", "ATE", "paper"], lines)


def times_table(timed):
    lines = []
    for selector, cells in timed.cells("wall time").items():
        papers = PAPER_MS.get(selector, ("-", "-"))
        lines.append([selector, cells["outlier rejection"], cells["selection"], papers[0], cells["pose optimisation"],
                      papers[1], cells["total"], cells["used"]])
    return table(["ms a frame", "outlier rejection", "selection", "paper", "pose optimisation", "paper", "total",
                  "matches used"], lines)


def tracking_variants_table(results):
    rivals = ["quality", "bucket", "quality_md", "random", "inl", "all", "all_weighted"]
    lines = []
    for folder, what in TRACKING_VARIANTS:
        cells = Experiment(results, folder).cells("Difference of `md`")
        lines.append([what, *(f"{cells[r]['RPE']}, {cells[r]['ROE']}" for r in rivals)])
    return table(["md, RPE and ROE, against", *rivals], lines)


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    results = sys.argv[1]
    metrics, budget, epsilon, euroc = (Experiment(results, name) for name in ("metrics", "budget", "epsilon", "euroc"))
    weightings = ["measurement", "map_bias", "measurement_and_map"]
    of_each = lambda *words: [line for w in weightings
                              for line in [f"`{w}` blocks:", "", *metrics.table(*words, f"`{w}`"), ""]][:-1]
    tables = {
        "metrics_lowest": lowest_table(metrics, weightings),
        "metrics_comparison": of_each("Mean over subset sizes"),
        "metrics_aligned": aligned_table(metrics, "measurement"),
        "metrics_crossing": of_each("from which on"),
        "metrics_theory": metrics.table("Theory", "`measurement`"),
        "metrics_variants": metric_variants_table(results),
        "metrics_seconds": [f"`simulate metrics` with all its defaults took {metrics.seconds():.0f} s."],
        "budget": budget.table("Errors by budget"),
        "euroc_relative": euroc.table("Relative errors"),
        "euroc_averages": euroc.table("Means over sequences"),
        "euroc_absolute": euroc.table("Absolute trajectory error"),
        "euroc_beside_paper": beside_paper_table(euroc),
        "euroc_md": euroc.table("Difference of `md`"),
        "euroc_quality_md": euroc.table("Difference of `quality_md`"),
        "euroc_stochastic": Experiment(results, "euroc_stochastic").table("Difference of `md`"),
        "euroc_times": times_table(Experiment(results, "euroc_time")),
        "euroc_variants": tracking_variants_table(results),
        "epsilon_grid": epsilon.table("Over the whole grid"),
        "epsilon_paper": epsilon.table("n = 1000"),
        **robustness_tables(results),
    }
    for name, lines in tables.items():
        replace_between(PAGE, name, lines)
    for experiment in (metrics, budget, epsilon, euroc, Experiment(results, "robustness")):
        for picture in sorted(experiment.folder.glob(f"{experiment.name}*.svg")):
            shutil.copy(picture, ROOT / "docs/images" / picture.name)
            print(f"copied docs/images/{picture.name}")


if __name__ == "__main__":
    main()
