# SPDX-License-Identifier: MIT
"""Reads the results of `maxlogdet_simulate`, and records full tables in bench/does_the_paper_hold/results."""

import pathlib
import re
import sys

from maxlogdet_tools.files import rows_of, write_csv
from maxlogdet_tools.project import ROOT

BETTER, OPEN, WORSE = "▲", "·", "▼"
VERDICTS = {BETTER: "better", OPEN: "open", WORSE: "worse"}
ESTIMATE = re.compile(r"(?P<value>-?[\d.]+|-)(?: ± (?P<ci95>[\d.]+))?(?: %)?(?: (?P<sign>[▲·▼]))?")


class Experiment:
    """One folder of results: the tables of its NAME.md by their headings, and its CSV files."""

    def __init__(self, results, folder):
        self.folder = pathlib.Path(results) / folder
        self.name = folder.split("_")[0]
        text = (self.folder / f"{self.name}.md").read_text()
        self.sections = re.findall(r"^([^|\n].*)\n\n((?:\|.*\n)+)", text, flags=re.MULTILINE)

    def rows(self, *words):
        """The only table whose heading has all these words, as lists of cells; the header is first."""
        found = [lines for heading, lines in self.sections if all(word in heading for word in words)]
        if len(found) != 1:
            sys.exit(f"{self.folder}: expected one table about {words}, found {len(found)}")
        rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in found[0].rstrip("\n").split("\n")]
        return [rows[0], *rows[2:]]

    def cells(self, *words):
        """The same table as {first cell of a row: {column: cell}}."""
        rows = self.rows(*words)
        return {row[0]: dict(zip(rows[0], row)) for row in rows[1:]}

    def csv(self, file):
        return rows_of(self.folder / file)


def parts_of(cell):
    match = ESTIMATE.fullmatch(cell)
    if match is None:
        sys.exit(f"expected a number, or a cell such as -8.1 ± 0.3 % ▲, found {cell!r}")
    return match


def estimate(cell):
    """Value, half width of the 95 % interval and verdict of a cell such as `-8.1 ± 0.3 % ▲`; missing ones are empty."""
    match = parts_of(cell)
    value = "" if match["value"] == "-" else match["value"]
    return [value, match["ci95"] or "", VERDICTS.get(match["sign"], "")]


def brief(cell):
    """A cell as the page shows it, without its interval: `-8.1 ± 0.3 % ▲` becomes `-8.1 ▲`."""
    match = parts_of(cell)
    return " ".join(part for part in (match["value"], match["sign"]) if part)


def record(name, header, rows):
    """Rewrites bench/does_the_paper_hold/results/NAME.csv."""
    write_csv(ROOT / f"bench/does_the_paper_hold/results/{name}.csv", header, rows)
