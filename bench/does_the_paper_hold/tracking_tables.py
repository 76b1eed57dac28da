# SPDX-License-Identifier: MIT
"""Section V: tables of `maxlogdet_simulate budget` and `maxlogdet_simulate euroc`."""

import re

from maxlogdet_tools.pages import table
from simulated import Experiment, brief, estimate, record

VARIANTS = ["euroc_default", "euroc_measurement", "euroc_both", "euroc_bias", "euroc_scale", "euroc_outliers",
            "euroc_few", "euroc_stochastic"]
# The parts that the page shows; results has everything.
SHOWN_BUDGETS = ["80", "200"]
SHOWN_TIMES = ["observability", "md", "inl", "all"]

# Zhao & Vela's own figures: averages of table II (RPE in m/s, ROE in deg/s), and table IV (ms).
PAPER_RELATIVE = {
    "quality": (0.047, 0.30),
    "bucket": (0.051, 0.32),
    "observability": (0.048, 0.35),
    "md": (0.042, 0.29),
    "quality_md": (0.032, 0.26),
    "inl": (0.059, 0.35),
    "all": (0.061, 0.32),
}
PAPER_MS = {
    "quality": ("0.00", "0.35"),
    "bucket": ("0.11", "0.34"),
    "observability": ("2.6", "0.32"),
    "md": ("3.0", "0.40"),
    "quality_md": ("1.5", "0.34"),
    "inl": ("-", "2.4"),
    "all": ("-", "2.6"),
}


def budget_table(budget):
    rows = [[row[0], *(brief(cell) for cell in row[4:])]
            for row in budget.rows("Errors by budget")[1:] if row[0] in SHOWN_BUDGETS]
    return table(["features", *(f"{error} against `inl` (%)" for error in ("ATE", "RPE", "ROE"))], rows)


def tracking_table(euroc):
    """Beside the paper's averages."""
    rows = []
    for other, cells in euroc.cells("Difference of `md`").items():
        papers = ["-", "-"]
        if other in PAPER_RELATIVE:
            papers = [f"{100 * (md / its - 1):.0f}" for md, its in zip(PAPER_RELATIVE["md"], PAPER_RELATIVE[other])]
        rows.append([f"`{other}`", brief(cells["RPE"]), papers[0], brief(cells["ROE"]), papers[1], brief(cells["ATE"])])
    return table(["`md` against", "RPE (%)", "RPE in the paper (%)", "ROE (%)", "ROE in the paper (%)", "ATE (%)"], rows)


def times_table(timed):
    rows = []
    for selector, cells in timed.cells("wall time").items():
        if selector in SHOWN_TIMES:
            rows.append([f"`{selector}`", cells["outlier rejection"], cells["selection"],
                         PAPER_MS.get(selector, ["-"])[0], cells["pose optimisation"], cells["total"]])
    return table(["selector", "outlier rejection (ms)", "selection (ms)", "selection in the paper (ms)",
                  "pose optimisation (ms)", "total (ms)"], rows)


def times_rows(timed):
    for row in timed.rows("wall time")[1:]:
        yield [*row, *("" if ms == "-" else ms for ms in PAPER_MS.get(row[0], ("", "")))]


def sequence_rows(euroc):
    """The rows of the sequences, without the summaries below them."""
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
    for folder, selectors in [("euroc", ["md", "quality_md"]), *((folder, ["md"]) for folder in VARIANTS)]:
        for selector in selectors:
            header, *rows = Experiment(results, folder).rows(f"Difference of `{selector}`")
            for other, *cells in rows:
                for error, cell in zip(header[1:], cells):
                    yield [folder, selector, other, error, *estimate(cell)]


def budget_rows(budget):
    for features, *cells in budget.rows("Errors by budget")[1:]:
        quartiles = [number for cell in cells[:3] for number in re.findall(r"[\d.]+", cell)]
        yield [features, *quartiles, *(part for cell in cells[3:] for part in estimate(cell))]


def record_all(results):
    budget, euroc = (Experiment(results, name) for name in ("budget", "euroc"))
    quartiles = [f"{e}_{what}" for e in ("ate_m", "rpe_m_per_s", "roe_deg_per_s")
                 for what in ("median", "lower_quartile", "upper_quartile")]
    claims = [f"{e}_{what}" for e in ("ate", "rpe", "roe") for what in ("against_inl_percent", "ci95", "verdict")]
    record("budget_summary", ["features", *quartiles, *claims], budget_rows(budget))
    record("euroc_sequences", ["sequence", "selector", "rpe_m_per_s", "roe_deg_per_s", "ate_m"],
              sequence_rows(euroc))
    means = [name for e in ("rpe_m_per_s", "roe_deg_per_s", "ate_m") for name in (e, f"{e}_ci95")]
    against = [f"{e}_{what}" for e in ("rpe", "roe") for what in (
        "sequences_worse_than_all", "sequences_better_than_all", "mean_loss_there", "mean_gain_there")]
    record("euroc_means", ["selector", *means, *against], mean_rows(euroc))
    record("euroc_differences", ["experiment", "selector", "against", "error", "difference_percent", "ci95",
                                    "verdict"], claim_rows(results))
    timed = Experiment(results, "euroc_time")
    stages = [name.replace(" ", "_") for name in timed.rows("wall time")[0]]
    record("euroc_times", [*stages, "selection_of_paper", "pose_optimisation_of_paper"], times_rows(timed))


def tables(results):
    euroc = Experiment(results, "euroc")
    return {
        "budget": budget_table(Experiment(results, "budget")),
        "euroc": tracking_table(euroc),
        "euroc_times": times_table(Experiment(results, "euroc_time")),
    }
