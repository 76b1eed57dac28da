# SPDX-License-Identifier: MIT
"""Section III: tables of `maxlogdet_simulate metrics`."""

from maxlogdet_tools.pages import table
from maxlogdet_tools.pictures.quantiles import mean
from simulated import BETTER, OPEN, WORSE, Experiment, brief, estimate, record

WEIGHTINGS = ["measurement", "map_bias", "measurement_and_map"]
RIVALS = ["max_trace", "min_condition", "max_min_eigenvalue", "random"]
PANELS = [(noise, column) for noise in ("1", "2") for column in ("rms_translation_m", "rms_rotation_deg")]
VARIANTS = [
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


def means_over_sizes(rows, weighting, column, noise):
    chosen = [r for r in rows if r["weighting"] == weighting and r["noise_px"] == noise]
    selectors = dict.fromkeys(r["selector"] for r in chosen)
    return {s: mean(float(r[column]) for r in chosen if r["selector"] == s) for s in selectors}


def comparison_table(metrics):
    """Of the paper's blocks, at the first noise."""
    rows = metrics.rows("Mean over subset sizes", "`map_bias`")[1:]
    return table(["selector", "translation (m)", "rotation (deg)"],
                 ([f"`{selector}`", brief(metres), brief(degrees)] for selector, metres, degrees, *_ in rows))


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
    """(scene, blocks, {selectors: how often max_log_det is better, open, worse}) of each variant."""
    for folder, weighting, what in VARIANTS:
        cells = Experiment(results, folder).cells("Mean over subset sizes", f"`{weighting}`")
        groups = {"metrics and random": RIVALS, "all": ["all"], "all_weighted": ["all_weighted"]}
        yield what, weighting, {name: count_signs(cells, selectors) for name, selectors in groups.items()}


def lowest_rows(metrics):
    """The metrics with the lowest and the second lowest mean over all subset sizes."""
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


def record_all(results):
    metrics = Experiment(results, "metrics")
    record("metrics_means", ["blocks", "selector", "noise_px", "error", "mean_below_200", "ci95",
                                "verdict_of_max_log_det", "within_5_percent_of_all_from", "below_all_from"],
              comparison_rows(metrics))
    record("metrics_lowest", ["blocks", "noise_px", "error", "lowest", "mean", "second_lowest", "second_mean"],
              lowest_rows(metrics))
    record("metrics_aligned_means", ["selector", *(f"{column}_{noise}px" for noise, column in PANELS)],
              aligned_means(metrics, "measurement"))
    record("metrics_theory", ["selector", "bias_amplification", "expected_m", "measured_m", "measured_m_ci95",
                                 "expected_deg", "measured_deg", "measured_deg_ci95"],
              ([s, gain, meters, *estimate(m)[:2], degrees, *estimate(d)[:2]]
               for s, gain, meters, m, degrees, d in metrics.rows("Theory", "`measurement`")[1:]))
    record("metrics_variants", ["scene", "blocks", "max_log_det_against", "better", "open", "worse"],
              ([what, weighting, name, *n] for what, weighting, counts in metric_variants(results)
               for name, n in counts.items()))


def tables(results):
    return {"metrics_comparison": comparison_table(Experiment(results, "metrics"))}
