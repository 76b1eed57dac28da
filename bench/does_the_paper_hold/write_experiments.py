#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Rewrites the tables and the picture of docs/experiments.md from bench/does_the_paper_hold/results.

Usage: write_experiments.py [FOLDER]    FOLDER: what bench/run does_the_paper_hold fills; its CSV files become the results
"""
import pathlib
import shutil
import sys

from maxlogdet_tools.files import rows_of
from maxlogdet_tools.gnuplot import draw
from maxlogdet_tools.pages import rewrite, table
from maxlogdet_tools.pictures import metrics
from maxlogdet_tools.project import ROOT, shown
from maxlogdet_tools.runs import stamp

PAGE = ROOT / "docs/experiments.md"
RESULTS = pathlib.Path(__file__).resolve().parent / "results"
FILES = {
    "metrics": "metrics/metrics.csv",
    "metrics_means": "metrics/metrics_means.csv",
    "metrics_unbiased": "unbiased/metrics_means.csv",
    "budget": "budget/budget.csv",
    "euroc_sequences": "euroc/euroc_sequences.csv",
    "euroc_means": "euroc/euroc_means.csv",
    "euroc_differences": "euroc/euroc_differences.csv",
    "time": "time/time.csv",
    "epsilon": "epsilon/epsilon.csv",
}
SIGNS = {"better": "▲", "worse": "▼", "open": "·", "": ""}

# Zhao & Vela's own figures: averages of table II (RPE in m/s, ROE in deg/s), and table IV (ms).
PAPER_ERRORS = {
    "quality": (0.047, 0.30),
    "bucket": (0.051, 0.32),
    "observability": (0.048, 0.35),
    "md": (0.042, 0.29),
    "quality_md": (0.032, 0.26),
    "inl": (0.059, 0.35),
    "all": (0.061, 0.32),
}
PAPER_SELECTION_MS = {"quality": "0.00", "bucket": "0.11", "observability": "2.6", "md": "3.0", "quality_md": "1.5"}


def results(name):
    return rows_of(RESULTS / f"{name}.csv")


def with_sign(value, verdict):
    return f"{value} {SIGNS[verdict]}".strip()


def metrics_table():
    cells = {}
    for row in results("metrics_means"):
        if row["noise_px"] == "1":
            cells.setdefault(row["selector"], []).append(with_sign(row["mean_below_all"], row["verdict_of_max_log_det"]))
    return table(["selector", "translation (m)", "rotation (deg)"],
                 ([f"`{selector}`", *errors] for selector, errors in cells.items()))


def differences(name):
    """{(selector, against): {error: cell}}"""
    cells = {}
    for row in results(name):
        pair = cells.setdefault((row["selector"], row["against"]), {})
        pair[row["error"]] = with_sign(row["difference_percent"], row["verdict"])
    return cells


def budget_table():
    cells = differences("budget")
    return table(["features", *(f"{error} against `inl` (%)" for error in ("ATE", "RPE", "ROE"))],
                 ([k, *(cells[k, "inl"][error] for error in ("ATE", "RPE", "ROE"))] for k in ("80", "200")))


def euroc_table():
    rows = []
    for (selector, other), cells in differences("euroc_differences").items():
        if selector != "md":
            continue
        papers = ["-", "-"]
        if other in PAPER_ERRORS:
            papers = [f"{100 * (md / its - 1):.0f}" for md, its in zip(PAPER_ERRORS["md"], PAPER_ERRORS[other])]
        rows.append([f"`{other}`", cells["RPE"], papers[0], cells["ROE"], papers[1], cells["ATE"]])
    return table(["`md` against", "RPE (%)", "RPE in the paper (%)", "ROE (%)", "ROE in the paper (%)", "ATE (%)"], rows)


def time_table():
    rows = []
    for row in results("time"):
        name = row["ms_a_frame"]
        if name in ("observability", "md", "inl", "all"):
            rows.append([f"`{name}`", row["outlier_rejection"], row["selection"], PAPER_SELECTION_MS.get(name, "-"),
                         row["pose_optimisation"], row["total"]])
    return table(["selector", "outlier rejection (ms)", "selection (ms)", "selection in the paper (ms)",
                  "pose optimisation (ms)", "total (ms)"], rows)


def epsilon_table():
    columns = ["epsilon", "guarantee", "minimum of greedy", "fewer evaluations", "faster than lazy greedy"]
    return table(["ε", "guarantee (ratio)", "minimum f / f(greedy) (ratio)", "fewer evaluations (ratio)",
                  "faster than lazy greedy (ratio)"],
                 ([row[column] for column in columns] for row in results("epsilon")
                  if row["n and k"] != "all" and row["epsilon"] in ("1", "0.1")))


def main():
    if len(sys.argv) > 2 or sys.argv[-1].startswith("-"):
        sys.exit(__doc__.strip())
    for name, file in FILES.items() if len(sys.argv) == 2 else []:
        shutil.copy(pathlib.Path(sys.argv[1]) / file, RESULTS / f"{name}.csv")
    for name, lines in {"metrics_comparison": metrics_table(), "budget": budget_table(), "euroc": euroc_table(),
                        "euroc_times": time_table(), "epsilon": epsilon_table()}.items():
        rewrite(PAGE, name, lines)
    draw(metrics.picture(results("metrics")), ROOT / "docs/images/metrics.svg")
    print(f"drew {shown(ROOT / 'docs/images/metrics.svg')}")
    if len(sys.argv) == 2:
        stamp(PAGE, "does_the_paper_hold")


if __name__ == "__main__":
    main()
