# SPDX-License-Identifier: MIT
"""The checkout, and the machine that measures."""

import pathlib
import platform

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent


def shown(path):
    """A path as messages show it: relative to the checkout if it is in there."""
    path = pathlib.Path(path)
    return path.relative_to(ROOT) if path.is_relative_to(ROOT) else path


def cpu_model():
    for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return platform.machine()
