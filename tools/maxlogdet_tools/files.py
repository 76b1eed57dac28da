# SPDX-License-Identifier: MIT
"""What scripts are given: paths on their command line, and JSON in them."""

import json
import pathlib
import sys


def arguments(usage):
    """The paths of the command line; ends the script with its usage where there is none, or an option."""
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
