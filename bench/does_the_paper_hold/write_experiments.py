#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Rewrites the tables and the picture of docs/experiments.md, and the record of the paper's tables II and III.

Usage: write_experiments.py FOLDER    (what bench/run does_the_paper_hold fills)
"""
import pathlib
import shutil
import sys

from maxlogdet_tools.files import ROOT, rows_of, shown
from maxlogdet_tools.gnuplot import draw
from maxlogdet_tools.pages import paragraph, rewrite, stamp, table
from maxlogdet_tools.pictures import metrics

PAGE = ROOT / "docs/experiments.md"
PICTURE = ROOT / "docs/images/metrics.svg"
SIGNS = {"better": "▲", "worse": "▼", "open": "·", "": ""}

# Zhao & Vela's own figures: averages of table II (RPE in m/s), and table IV (ms).
PAPER_RPE = {
    "quality": 0.047,
    "bucket": 0.051,
    "observability": 0.048,
    "md": 0.042,
    "quality_md": 0.032,
    "inl": 0.059,
    "all": 0.061,
}
PAPER_SELECTION_MS = {"observability": "2.6", "md": "3.0"}


def with_sign(value, verdict):
    return f"{value} {SIGNS[verdict]}".strip()


def unbiased(rows):
    """Of all comparisons of `all` with a metric or random points, in both noises and errors: how many it wins."""
    of_all = {(row["noise_px"], row["error"]): float(row["mean_below_all"]) for row in rows if row["selector"] == "all"}
    others = [row for row in rows if row["selector"] != "all"]
    won = sum(of_all[row["noise_px"], row["error"]] < float(row["mean_below_all"]) for row in others)
    return paragraph(f"Without bias, `all` has the lower error in {won} of {len(others)} comparisons with other selectors.")


def differences(rows):
    """{(selector, against): {error: cell}}"""
    cells = {}
    for row in rows:
        pair = cells.setdefault((row["selector"], row["against"]), {})
        pair[row["error"]] = with_sign(row["difference_percent"], row["verdict"])
    return cells


def budget(rows):
    cells = differences(rows)
    few, many = (cells[k, "inl"]["ATE"].split()[0] for k in ("80", "200"))
    return paragraph("On MH_05_difficult (`budget`, section V-A), the ATE of `md` against that of `inl`, some 700 a frame, is",
                     f"{few} % with 80 features and {many} % with 200.")  # fmt: skip


def euroc_table(differences_of_runs):
    rows = []
    for (selector, other), cells in differences(differences_of_runs).items():
        if selector != "md":
            continue
        its = PAPER_RPE.get(other)
        rows.append([f"`{other}`", cells["RPE"], f"{100 * (PAPER_RPE['md'] / its - 1):.0f}" if its else "-", cells["ATE"]])
    return table(["`md` against", "RPE (%)", "RPE in the paper (%)", "ATE (%)"], rows)


def times(rows):
    of = {row["ms_a_frame"]: row for row in rows}
    return paragraph(f"In a frame of MH_05_difficult, `md` selects in {of['md']['selection']} ms (in the paper",
                     f"{PAPER_SELECTION_MS['md']} ms), `observability` in {of['observability']['selection']} ms",
                     f"({PAPER_SELECTION_MS['observability']} ms). The whole frame takes {of['md']['total']} ms with `md`,",
                     f"{of['inl']['total']} ms with `inl`, and {of['all']['total']} ms with `all`.")  # fmt: skip


def epsilon(rows):
    of = next(row for row in rows if row["n and k"] != "all" and row["epsilon"] == "0.1")
    return paragraph("To select 100 of 1000, stochastic greedy with ε = 0.1 needs",
                     f"{of['fewer evaluations']} times fewer evaluations than greedy, but is",
                     f"{of['faster than lazy greedy']} times as fast as lazy greedy.")  # fmt: skip


BLOCKS = [  # the name in the page, what writes it, and from which file
    ("unbiased", unbiased, "unbiased/metrics_means.csv"),
    ("budget", budget, "budget/budget.csv"),
    ("euroc", euroc_table, "euroc/euroc_differences.csv"),
    ("euroc_times", times, "time/time.csv"),
    ("epsilon", epsilon, "epsilon/epsilon.csv"),
]


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__.strip())
    folder = pathlib.Path(sys.argv[1])
    for name, lines_of, file in BLOCKS:
        rewrite(PAGE, name, lines_of(rows_of(folder / file)))
    draw(metrics(rows_of(folder / "metrics/metrics.csv")), PICTURE)
    print(f"drew {shown(PICTURE)}")
    shutil.copy(folder / "euroc/euroc_sequences.csv", pathlib.Path(__file__).parent)
    stamp(PAGE, "does_the_paper_hold")


if __name__ == "__main__":
    main()
