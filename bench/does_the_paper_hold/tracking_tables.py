# SPDX-License-Identifier: MIT
"""Section V: tables of `maxlogdet simulate budget` and `maxlogdet simulate euroc`."""

import re

from maxlogdet_tools.pages import table
from maxlogdet_tools.pictures.quantiles import mean
from simulated import Experiment, estimate, record

VARIANTS = [
    ("euroc_default", "as above (`map_bias` blocks)"),
    ("euroc_measurement", "`measurement` blocks"),
    ("euroc_both", "`measurement_and_map` blocks"),
    ("euroc_bias", "three times the keyframe errors (0.1 m, 0.6 deg, 3 %)"),
    ("euroc_scale", "keyframes wrong in scale alone (5 %)"),
    ("euroc_outliers", "30 % wrong matches"),
    ("euroc_few", "at most 300 matches a frame"),
    ("euroc_stochastic", "stochastic greedy, ε = 0.1 (the paper's)"),
]
# The parts that the page shows; bench/does_the_paper_hold/results has everything.
SHOWN_BUDGETS = ["80", "120", "200", "inl", "all_weighted"]
SHOWN_VARIANTS = ["euroc_default", "euroc_bias", "euroc_scale", "euroc_few", "euroc_stochastic"]
SHOWN_TIMES = ["quality", "observability", "md", "inl", "all", "all_weighted"]

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


def without_percent(cell):
    return cell.replace(" %", "")


def budget_table(budget):
    rows = []
    for row in budget.rows("Errors by budget")[1:]:
        if row[0] in SHOWN_BUDGETS:
            rows.append([row[0], row[1], *(without_percent(cell) for cell in row[4:])])
    return table(["features", "median ATE (m) [quartiles]", "ATE against inl (%)", "RPE (%)", "ROE (%)"], rows)


def sequences_better(euroc):
    """{selector: number of sequences in which it is better than `all`, in RPE and in ROE}."""
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
        lines.append([dict(VARIANTS)[folder], *(without_percent(cell) for cell in found)])
    cells = Experiment(results, "euroc_stochastic").cells("Difference of `md`")["observability"]
    found = ", ".join(f"{error} {cells[error]}" for error in ("RPE", "ROE", "ATE"))
    return [*table(["md, RPE and ROE (%)", "against all", "against all_weighted"], lines), "",
            f"With stochastic greedy, as `observability` is searched, md against `observability`: {found}."]


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
    for folder, selectors in [("euroc", ["md", "quality_md"]), *((folder, ["md"]) for folder, _ in VARIANTS)]:
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
        "euroc_beside_paper": beside_paper_table(euroc),
        "euroc_variants": tracking_variants_table(results),
        "euroc_times": times_table(Experiment(results, "euroc_time")),
    }
