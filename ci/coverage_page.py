# SPDX-License-Identifier: MIT
"""Prints the coverage of each folder from gcovr's JSON summary, the last line of ci/coverage; rewrites docs/trust.md.

Usage: coverage_page.py SUMMARY MIN_PERCENT_OF_LINES MIN_PERCENT_OF_BRANCHES yes|no
"""

import datetime
import sys

from maxlogdet_tools.files import json_of
from maxlogdet_tools.pages import rewrite, table
from maxlogdet_tools.project import ROOT


def percent(part, whole):
    return 100 * part / whole


def main(summary, min_lines, min_branches, page):
    files = json_of(summary)["files"]
    rows = []
    for folder in ["include", "kernel", "simd", "threading", "all"]:
        of_folder = [f for f in files if folder in ("all", f["filename"].split("/")[0])]
        total = {key: sum(f[key] for f in of_folder)
                 for key in ("line_covered", "line_total", "branch_covered", "branch_total")}
        if total["line_total"] == 0:
            sys.exit(f"{summary}: expected counted lines of {folder}/")
        lines = percent(total["line_covered"], total["line_total"])
        branches = percent(total["branch_covered"], total["branch_total"])
        rows.append((folder, total, lines, branches))
    if page == "yes":
        rewrite(ROOT / "docs/trust.md", "coverage", [
            f"Counted by `ci/coverage --page` on {datetime.date.today()}:",
            "",
            *table(["folder", "lines (count)", "executed (%)", "branches (count)", "taken (%)"],
                   [[folder if folder == "all" else f"`{folder}/`", str(total["line_total"]), f"{lines:.1f}",
                     str(total["branch_total"]), f"{branches:.1f}"] for folder, total, lines, branches in rows]),
        ])
    short = [folder for folder, _, lines, branches in rows
             if lines < float(min_lines) or branches < float(min_branches)]
    print(", ".join(f"{folder}: {lines:.1f} % of lines, {branches:.1f} % of branches"
                    for folder, _, lines, branches in rows))
    if short:
        sys.exit(f"{', '.join(short)}: expected {min_lines} % of lines and {min_branches} % of branches")


main(*sys.argv[1:])
