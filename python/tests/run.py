# SPDX-License-Identifier: MIT
"""Runs the tests beside it with pytest and the interpreter of this script. ctest calls it; exit code 77: skipped."""
import pathlib
import sys

try:
    import pytest
except ImportError:
    print(f"skipped: {sys.executable} lacks pytest; on Debian: apt-get install python3-pytest")
    sys.exit(77)

here = pathlib.Path(__file__).parent
sys.exit(pytest.main(["-p", "no:cacheprovider", "-ra", "--rootdir", str(here), str(here), *sys.argv[1:]]))
