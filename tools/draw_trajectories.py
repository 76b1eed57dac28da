#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Draws the trajectories.json that the stereo odometry wrote into a folder: trajectory.svg and trajectory.png beside it.

Usage: draw_trajectories.py FOLDER...
"""

from maxlogdet_tools.files import arguments, json_of
from maxlogdet_tools.gnuplot import draw_both
from maxlogdet_tools.pictures import trajectories

for folder in arguments(__doc__):
    draw_both(trajectories.picture(json_of(folder / "trajectories.json")), folder / "trajectory")
