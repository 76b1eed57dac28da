#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Draws what `maxlogdet select --plot-data FILE.json` wrote: FILE.svg and FILE.png.

Usage: draw_selection.py FILE.json...
"""

from maxlogdet_tools.files import arguments, json_of
from maxlogdet_tools.gnuplot import draw_both
from maxlogdet_tools.pictures import selection

for file in arguments(__doc__):
    draw_both(selection.picture(json_of(file)), file.with_suffix(""))
