# SPDX-License-Identifier: MIT
"""Trajectories of the stereo odometry from above, with the ground truth where it is known."""

from maxlogdet_tools.gnuplot import STYLE, Picture, data_block, quoted
from maxlogdet_tools.selector_styles import line_style


def picture(data):
    """`data`: what bench/does_it_track writes as trajectories.json."""
    blocks, curves = "", []
    if data["truth"]:
        blocks += data_block("truth", data["truth"])
        curves.append("$truth with lines lc rgb '#000000' lw 4 title 'ground truth'")
    for i, one in enumerate(data["trajectories"]):
        blocks += data_block(f"run{i}", one["points"])
        curves.append(f"$run{i} with linespoints {line_style(one['selector'])} title {quoted(one['name'])}")
    along, across = data["axes"]
    title = quoted(f"{data['dataset']}, from above, begun at the true pose, not aligned; axes differ in scale")
    return Picture(900, 500, (
        blocks + STYLE + f"set xlabel {quoted(along)}\nset ylabel {quoted(across)}\nset title {title}\nplot "
        + ", ".join(curves) + "\n"
    ))
