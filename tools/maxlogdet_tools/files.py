# SPDX-License-Identifier: MIT
"""The checkout, and files of JSON and CSV."""

import csv
import json
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]


def shown(path):
    """A path as messages show it: relative to the checkout if it is in there."""
    path = pathlib.Path(path)
    return path.relative_to(ROOT) if path.is_relative_to(ROOT) else path


def json_of(file):
    try:
        return json.loads(pathlib.Path(file).read_text())
    except OSError as error:
        sys.exit(f"{file}: cannot be read ({error.strerror}); expected a file of JSON")
    except ValueError as error:
        sys.exit(f"{file}: expected JSON ({error})")


def rows_of(file):
    """The rows of a CSV file as dictionaries."""
    with open(file, newline="") as lines:
        return list(csv.DictReader(lines))


def write_csv(file, header, rows):
    """Rewrites a CSV file, and says so."""
    file = pathlib.Path(file)
    file.parent.mkdir(exist_ok=True)
    with open(file, "w", newline="") as lines:
        csv.writer(lines, lineterminator="\n").writerows([header, *rows])
    print(f"wrote {shown(file)}")
