# SPDX-License-Identifier: MIT
"""Means and quantiles."""

import math


def mean(values):
    """NaN without values, or if one of them is missing: None, null in JSON."""
    values = list(values)
    return sum(values) / len(values) if values and None not in values else math.nan


def quantile(values, share):
    """Linear between order statistics (R's type 7), as in bench/world/statistics.hpp; NaN if a value is missing."""
    if not values or None in values:
        return math.nan
    values = sorted(values)
    at = share * (len(values) - 1)
    below = int(at)
    above = min(below + 1, len(values) - 1)
    return values[below] + (at - below) * (values[above] - values[below])
