# SPDX-License-Identifier: MIT
"""Paths on the command line of scripts, and their JSON."""

import json
import pathlib
import sys


def arguments(usage):
    """The paths of the command line; terminates with the usage if there is none, or an option."""
    paths = sys.argv[1:]
    if not paths or any(path.startswith("-") for path in paths):
        sys.exit(usage.strip())
    return [pathlib.Path(path) for path in paths]


def json_of(file):
    try:
        return json.loads(file.read_text())
    except OSError as error:
        sys.exit(f"{file}: cannot be read ({error.strerror}); expected a file of JSON")
    except ValueError as error:
        sys.exit(f"{file}: expected JSON ({error})")
