#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Draws the evaluation.json that `maxlogdet evaluate --output FOLDER` wrote: deviation and leverage, .svg and .png,
beside it.

Usage: draw_evaluation.py FOLDER...
"""

from maxlogdet_tools.files import arguments, json_of
from maxlogdet_tools.gnuplot import draw_both
from maxlogdet_tools.pictures import evaluation

for folder in arguments(__doc__):
    data = json_of(folder / "evaluation.json")
    draw_both(evaluation.deviation(data), folder / "deviation")
    draw_both(evaluation.leverage(data), folder / "leverage")
