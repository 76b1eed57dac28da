#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Rewrites the tables of docs/experiments.md from what `maxlogdet simulate` wrote, copies its pictures beside the page,
and records the full tables in experiments/results.

Usage: write_experiments.py RESULTS    RESULTS: the folder that ci/experiments fills
A table stands between the lines '<!-- begin NAME -->' and '<!-- end NAME -->'.
"""

import pathlib
import re
import shutil
import sys

from simulated import Experiment, estimate, write_csv

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "bench"))

from write_tables import replace_between, table  # noqa: E402

PAGE = ROOT / "docs/experiments.md"
WEIGHTINGS = ["measurement", "map_bias", "measurement_and_map"]
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
    ("euroc_stochastic", "stochastic greedy, ε = 0.1 (the paper's)"),
]
TAUS = ["0.1", "0.25", "0.5", "1", "2"]
FOLDER_OF_TAU = {tau: "robustness" if tau == "0.5" else f"robustness_tau_{tau}" for tau in TAUS}
ROBUSTNESS = list(dict.fromkeys(["robustness", "robustness_kitti", "robustness_gate", *FOLDER_OF_TAU.values()]))
# What the page shows of each table; experiments/results has all.
SHOWN_OF_THEORY = ["max_log_det", "max_trace", "random", "all"]
SHOWN_ALIGNED = ["max_log_det", "max_min_eigenvalue", "random", "all", "all_weighted"]
SHOWN_BUDGETS = ["80", "120", "200", "inl", "all_weighted"]
SHOWN_VARIANTS = ["euroc_default", "euroc_bias", "euroc_scale", "euroc_few", "euroc_stochastic"]
SHOWN_TIMES = ["quality", "observability", "md", "inl", "all", "all_weighted"]
SHOWN_TAUS = ["0.1", "0.25", "0.5", "2"]
SHOWN_EPSILONS = ["1", "0.1", "0.01"]

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


def mean(values):
    values = list(values)
    return sum(values) / len(values)


def without_percent(cell):
    return cell.replace(" %", "")


# Section III.


def means_over_sizes(rows, weighting, column, noise):
    chosen = [r for r in rows if r["weighting"] == weighting and r["noise_px"] == noise]
    selectors = dict.fromkeys(r["selector"] for r in chosen)
    return {s: mean(float(r[column]) for r in chosen if r["selector"] == s) for s in selectors}


def comparison_table(metrics):
    """With the first noise; selectors that look at no blocks stand once, with their verdicts on the first blocks."""
    lines = []
    for weighting in WEIGHTINGS[:2]:
        rows = metrics.rows("Mean over subset sizes", f"`{weighting}`")[1:]
        shown = [row for row in rows if row[0] in ["max_log_det", *RIVALS[:3]]]
        lines += [[f"`{weighting}`" if row is shown[0] else "", *row[:3]] for row in shown]
    rows = metrics.rows("Mean over subset sizes", f"`{WEIGHTINGS[0]}`")[1:]
    lines += [["-", *row[:3]] for row in rows if row[0] in ["random", "all", "all_weighted"]]
    return table(["blocks", "selector", "translation (m)", "rotation (deg)"], lines)


def aligned_means(metrics, weighting):
    """[selector, mean of each panel over all sizes]"""
    rows = metrics.csv("metrics_aligned.csv")
    for selector in ["max_log_det", *RIVALS, "all", "all_weighted"]:
        means = [means_over_sizes(rows, weighting, column, noise)[selector] for noise, column in PANELS]
        yield [selector, *(f"{value:.4f}" for value in means)]


def count_signs(cells, selectors):
    text = "".join(cell[-1] for s in selectors for name, cell in cells[s].items() if name != "selector")
    return [text.count(sign) for sign in (BETTER, OPEN, WORSE)]


def metric_variants(results):
    """(scene, blocks, {selectors: how often max_log_det is better, open, worse}) for each."""
    for folder, weighting, what in METRIC_VARIANTS:
        cells = Experiment(results, folder).cells("Mean over subset sizes", f"`{weighting}`")
        groups = {"metrics and random": RIVALS, "all": ["all"], "all_weighted": ["all_weighted"]}
        yield what, weighting, {name: count_signs(cells, selectors) for name, selectors in groups.items()}


def metric_variants_table(results):
    signs = lambda counts: " ".join(f"{n} {sign}" for n, sign in zip(counts, (BETTER, OPEN, WORSE)) if n > 0)
    rows = [[what, f"`{weighting}`", signs(counts["metrics and random"]), signs(counts["all"])]
            for what, weighting, counts in metric_variants(results)]
    header = ["scene and assumptions", "blocks", "against other metrics and random (16)", "against all (4)"]
    seconds = Experiment(results, "metrics").seconds()
    return [*table(header, rows), "", f"`simulate metrics` with all its defaults took {seconds:.0f} s."]


def lowest_rows(metrics):
    """Over all subset sizes: which metric has the lowest mean, and which the second lowest."""
    rows = metrics.csv("metrics.csv")
    for weighting in WEIGHTINGS:
        for noise, column in PANELS:
            means = means_over_sizes(rows, weighting, column, noise)
            order = sorted(["max_log_det", *RIVALS], key=means.get)
            yield [weighting, noise, column, *(cell for s in order[:2] for cell in (s, f"{means[s]:.4f}"))]


def comparison_rows(metrics):
    for weighting in WEIGHTINGS:
        crossings = {row[0]: row[1:] for row in metrics.rows("from which on", f"`{weighting}`")[1:]}
        for selector, *cells in metrics.rows("Mean over subset sizes", f"`{weighting}`")[1:]:
            for i, (noise, column) in enumerate(PANELS):
                crossing = crossings[selector][i].split(" / ") if selector in crossings else ["", ""]
                yield [weighting, selector, noise, column, *estimate(cells[i]), *crossing]


def record_metrics(metrics, results):
    write_csv("metrics_means", ["blocks", "selector", "noise_px", "error", "mean_below_200", "ci95",
                                "verdict_of_max_log_det", "within_5_percent_of_all_from", "below_all_from"],
              comparison_rows(metrics))
    write_csv("metrics_lowest", ["blocks", "noise_px", "error", "lowest", "mean", "second_lowest", "second_mean"],
              lowest_rows(metrics))
    write_csv("metrics_aligned_means", ["selector", *(f"{column}_{noise}px" for noise, column in PANELS)],
              aligned_means(metrics, "measurement"))
    write_csv("metrics_theory", ["selector", "bias_amplification", "expected_m", "measured_m", "measured_m_ci95",
                                 "expected_deg", "measured_deg", "measured_deg_ci95"],
              ([s, gain, meters, *estimate(m)[:2], degrees, *estimate(d)[:2]]
               for s, gain, meters, m, degrees, d in metrics.rows("Theory", "`measurement`")[1:]))
    write_csv("metrics_variants", ["scene", "blocks", "max_log_det_against", "better", "open", "worse"],
              ([what, weighting, name, *n] for what, weighting, counts in metric_variants(results)
               for name, n in counts.items()))


# Robustness.


def differences(results, folder):
    return Experiment(results, folder).cells("Difference", "with 60 of 500 matches")


def robustness_table(results):
    shown = [("robustness", "none"), ("robustness", "batches"), ("robustness_kitti", "batches"),
             ("robustness", "patches")]
    levels = []
    for folder, disturbance in shown:
        cells = Experiment(results, folder).cells("RMS errors", "with 60 of 500 matches")[disturbance]
        levels.append(f"{cells['md (m)']}, {cells['md (deg)']}")
    found = [differences(results, folder)[disturbance] for folder, disturbance in shown]
    return table(["", "`none`", "`batches`", "`batches`, KITTI-like", "`patches`"],
                 [["md itself (m, deg)", *levels],
                  *(["against " + other, *(cells[other] for cells in found)] for other in list(found[0])[1:])])


def tau_table(results):
    rows = []
    for tau in SHOWN_TAUS:
        cells = differences(results, FOLDER_OF_TAU[tau])
        rows.append([tau, cells["none"]["shared_keyframes"], cells["batches"]["shared_keyframes"]])
    return table(["τ (px)", "`none`", "`batches`"], rows)


def robustness_difference_rows(results):
    for folder in ROBUSTNESS:
        experiment = Experiment(results, folder)
        for heading, _ in experiment.sections:
            budget = re.search(r"with (\d+) of", heading)
            if not heading.startswith("Difference"):
                continue
            for disturbance, cells in experiment.cells(heading).items():
                for other, cell in list(cells.items())[1:]:
                    both = [value for part in cell.split(", ") for value in estimate(part)]
                    yield [folder, disturbance, budget[1], other, *both]


def robustness_error_rows(results):
    columns = ["rms_translation_m", "ci95_translation_m", "rms_rotation_deg", "ci95_rotation_deg"]
    for folder in ROBUSTNESS:
        for row in Experiment(results, folder).csv("robustness.csv"):
            which = [row[c] for c in ("disturbance", "selector", "budget")]
            yield [folder, *which, *(f"{float(row[c]):.5g}" for c in columns)]


def record_robustness(results):
    errors = ["rms_translation_m", "translation_ci95", "rms_rotation_deg", "rotation_ci95"]
    write_csv("robustness_errors", ["experiment", "disturbance", "selector", "budget", *errors],
              robustness_error_rows(results))
    both = [f"{error}_{what}" for error in ("translation", "rotation") for what in ("percent", "ci95", "verdict")]
    write_csv("robustness_differences", ["experiment", "disturbance", "budget", "md_against", *both],
              robustness_difference_rows(results))


# Section V.


def budget_table(budget):
    rows = []
    for row in budget.rows("Errors by budget")[1:]:
        if row[0] in SHOWN_BUDGETS:
            rows.append([row[0], row[1], *(without_percent(cell) for cell in row[4:])])
    return table(["features", "median ATE (m) [quartiles]", "ATE against inl (%)", "RPE (%)", "ROE (%)"], rows)


def sequences_better(euroc):
    """{selector: in how many sequences it is better than `all`, in RPE and in ROE}."""
    header, *rows = euroc.rows("Relative errors")
    return dict(zip(header[1:], rows[-3][1:]))


def tracking_table(euroc):
    claims = euroc.cells("Difference of `md`")
    better = sequences_better(euroc)
    rows = []
    for selector, *means in euroc.rows("Means over sequences")[1:]:
        claimed = [without_percent(claims[selector][e]) if selector in claims else "" for e in ("RPE", "ROE", "ATE")]
        count = "" if selector == "all" else ", ".join(better[selector].split())
        rows.append([selector, *(estimate(cell)[0] for cell in means), count, *claimed])
    return table(["selector", "RPE (m/s)", "ROE (deg/s)", "ATE (m)", "sequences better than all: RPE, ROE",
                  "md against it: RPE (%)", "ROE (%)", "ATE (%)"], rows)


def beside_paper_table(euroc):
    rows = [r for r in euroc.csv("euroc.csv") if r["sequence"] in PAPER_SEQUENCES]
    average = lambda s, column: mean(float(r[column]) for r in rows if r["selector"] == s)
    change = lambda value, reference: f"{100 * (value / reference - 1):+.0f}"
    lines = []
    for selector, (rpe, roe) in PAPER_RELATIVE.items():
        if selector == "all":
            continue
        ours = [change(average(selector, c), average("all", c)) for c in ("rpe_m_per_s", "roe_deg_per_s", "ate_m")]
        papers = [change(rpe, PAPER_RELATIVE["all"][0]), change(roe, PAPER_RELATIVE["all"][1])]
        ate = PAPER_ABSOLUTE.get(selector)
        papers.append("-" if ate is None else change(ate, PAPER_ABSOLUTE["all"]))
        lines.append([selector, *(cell for pair in zip(ours, papers) for cell in pair)])
    return table(["against all, %", "RPE", "paper", "ROE", "paper", "ATE", "paper"], lines)


def times_table(timed):
    rows = []
    for selector, cells in timed.cells("wall time").items():
        if selector in SHOWN_TIMES:
            papers = PAPER_MS.get(selector, ("-", "-"))
            rows.append([selector, cells["outlier rejection"], cells["selection"], papers[0],
                         cells["pose optimisation"], papers[1], cells["total"]])
    return table(["ms a frame", "outlier rejection", "selection", "paper", "pose optimisation", "paper", "total"], rows)


def times_rows(timed):
    for row in timed.rows("wall time")[1:]:
        yield [*row, *("" if ms == "-" else ms for ms in PAPER_MS.get(row[0], ("", "")))]


def tracking_variants_table(results):
    lines = []
    for folder in SHOWN_VARIANTS:
        cells = Experiment(results, folder).cells("Difference of `md`")
        found = [f"{cells[rival]['RPE']}, {cells[rival]['ROE']}" for rival in ("all", "all_weighted")]
        lines.append([dict(TRACKING_VARIANTS)[folder], *(without_percent(cell) for cell in found)])
    cells = Experiment(results, "euroc_stochastic").cells("Difference of `md`")["observability"]
    found = ", ".join(f"{error} {cells[error]}" for error in ("RPE", "ROE", "ATE"))
    return [*table(["md, RPE and ROE (%)", "against all", "against all_weighted"], lines), "",
            f"With stochastic greedy, as `observability` is searched, md against `observability`: {found}."]


def sequence_rows(euroc):
    """Without the summaries below the sequences."""
    plain = lambda cell: cell.replace("*", "")
    header, *relative = euroc.rows("Relative errors")
    absolute = euroc.cells("Absolute trajectory error")
    for sequence, *cells in relative[:-5]:
        for selector, cell in zip(header[1:], cells):
            yield [sequence, selector, *plain(cell).split(), plain(absolute[sequence][selector])]


def mean_rows(euroc):
    header, *rows = euroc.rows("Relative errors")
    summaries = {s: [row[i].split() for row in rows[-4:]] for i, s in enumerate(header) if i > 0}
    for selector, *means in euroc.rows("Means over sequences")[1:]:
        against = [pair[kind] for kind in (0, 1) for pair in summaries[selector]]
        yield [selector, *(part for cell in means for part in estimate(cell)[:2]),
               *("" if value == "-" else value for value in against)]


def claim_rows(results):
    for folder, selectors in [("euroc", ["md", "quality_md"]), *((folder, ["md"]) for folder, _ in TRACKING_VARIANTS)]:
        for selector in selectors:
            header, *rows = Experiment(results, folder).rows(f"Difference of `{selector}`")
            for other, *cells in rows:
                for error, cell in zip(header[1:], cells):
                    yield [folder, selector, other, error, *estimate(cell)]


def budget_rows(budget):
    for features, *cells in budget.rows("Errors by budget")[1:]:
        quartiles = [number for cell in cells[:3] for number in re.findall(r"[\d.]+", cell)]
        yield [features, *quartiles, *(part for cell in cells[3:] for part in estimate(cell))]


def record_tracking(results, budget, euroc):
    quartiles = [f"{e}_{what}" for e in ("ate_m", "rpe_m_per_s", "roe_deg_per_s")
                 for what in ("median", "lower_quartile", "upper_quartile")]
    claims = [f"{e}_{what}" for e in ("ate", "rpe", "roe") for what in ("against_inl_percent", "ci95", "verdict")]
    write_csv("budget_summary", ["features", *quartiles, *claims], budget_rows(budget))
    write_csv("euroc_sequences", ["sequence", "selector", "rpe_m_per_s", "roe_deg_per_s", "ate_m"],
              sequence_rows(euroc))
    means = [name for e in ("rpe_m_per_s", "roe_deg_per_s", "ate_m") for name in (e, f"{e}_ci95")]
    against = [f"{e}_{what}" for e in ("rpe", "roe") for what in (
        "sequences_worse_than_all", "sequences_better_than_all", "mean_loss_there", "mean_gain_there")]
    write_csv("euroc_means", ["selector", *means, *against], mean_rows(euroc))
    write_csv("euroc_differences", ["experiment", "selector", "against", "error", "difference_percent", "ci95",
                                    "verdict"], claim_rows(results))
    timed = Experiment(results, "euroc_time")
    stages = [name.replace(" ", "_") for name in timed.rows("wall time")[0]]
    write_csv("euroc_times", [*stages, "selection_of_paper", "pose_optimisation_of_paper"], times_rows(timed))


# Section IV.

EPSILON_COLUMNS = ["ε", "1 − 1/e − ε", "minimum f / f(greedy)", "minimum f / bound", "mean gap (nats)",
                   "features differing (%)", "× fewer gains", "× faster than greedy", "× faster than lazy greedy"]
EPSILON_SETS = [("all", "Over the whole grid"), ("n = 1000, k = 100", "n = 1000")]


def epsilon_table(epsilon):
    lines = []
    for name, heading in EPSILON_SETS:
        rows = [row for row in epsilon.rows(heading)[1:] if row[0] in SHOWN_EPSILONS]
        lines += [[name if row is rows[0] else "", *row[:3], *row[4:]] for row in rows]
    return table(["n, k", *EPSILON_COLUMNS[:3], *EPSILON_COLUMNS[4:]], lines)


def record_epsilon(epsilon):
    write_csv("epsilon_summary", ["n and k", *EPSILON_COLUMNS],
              ([name, *row] for name, heading in EPSILON_SETS for row in epsilon.rows(heading)[1:]))


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    results = sys.argv[1]
    metrics, budget, epsilon, euroc = (Experiment(results, name) for name in ("metrics", "budget", "epsilon", "euroc"))
    header, *theory = metrics.rows("Theory", "`measurement`")
    tables = {
        "metrics_comparison": comparison_table(metrics),
        "metrics_aligned": table(["selector", "translation (m)", "rotation (deg)"],
                                 (row[:3] for row in aligned_means(metrics, "measurement") if row[0] in SHOWN_ALIGNED)),
        "metrics_theory": table(header, (row for row in theory if row[0] in SHOWN_OF_THEORY)),
        "metrics_variants": metric_variants_table(results),
        "budget": budget_table(budget),
        "euroc": tracking_table(euroc),
        "euroc_beside_paper": beside_paper_table(euroc),
        "euroc_variants": tracking_variants_table(results),
        "euroc_times": times_table(Experiment(results, "euroc_time")),
        "robustness": robustness_table(results),
        "robustness_tau": tau_table(results),
        "epsilon": epsilon_table(epsilon),
    }
    for name, lines in tables.items():
        replace_between(PAGE, name, lines)
    record_metrics(metrics, results)
    record_tracking(results, budget, euroc)
    record_robustness(results)
    record_epsilon(epsilon)
    for experiment in (metrics, budget, epsilon, euroc, Experiment(results, "robustness")):
        for picture in sorted(experiment.folder.glob(f"{experiment.name}*.svg")):
            shutil.copy(picture, ROOT / "docs/images" / picture.name)
            print(f"copied docs/images/{picture.name}")


if __name__ == "__main__":
    main()
