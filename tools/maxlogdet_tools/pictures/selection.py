# SPDX-License-Identifier: MIT
"""A frame's matches in a map view (from above) and a camera view, as in the paper's simulation figure: selected ones red,
the others blue."""

from maxlogdet_tools.gnuplot import Picture, data_block, number, quoted

# A few points at hundreds of metres would compress all others into a corner: the map view covers this share of them, and
# the selected ones.
SHOWN_SHARE = 0.97
MARGIN = 1.05


def quantile(values, share):
    """Linear between order statistics (R's type 7), like quantile_of() of bench/does_it_help."""
    values = sorted(values)
    at = share * (len(values) - 1)
    below = int(at)
    above = min(below + 1, len(values) - 1)
    return values[below] + (at - below) * (values[above] - values[below])


def reach_of(distances, selected):
    reach = max(quantile(distances, SHOWN_SHARE), 1.0) if distances else 1.0
    return MARGIN * max([reach, *(distances[i] for i in selected)])


def picture(frame):
    """`frame`: what bench/world/selection_data.hpp writes."""
    points = list(zip(frame["right_m"], frame["forward_m"], frame["u_px"], frame["v_px"]))
    selected = set(frame["selected"])
    width, height = frame["width_px"], frame["height_px"]
    side = reach_of([abs(right) for right in frame["right_m"]], selected)
    depth = reach_of(frame["forward_m"], selected)
    title = f"{frame['frame']}: {len(selected)} of {len(points)} matches selected"
    return Picture(1200, 480, (
        data_block("unselected", [point for i, point in enumerate(points) if i not in selected])
        + data_block("selected", [point for i, point in enumerate(points) if i in selected])
        + f"set multiplot layout 1,2 title {quoted(title)}\n"
        "set style line 1 lc rgb '#3465c4' pt 7 ps 0.3\nset style line 2 lc rgb '#d62020' pt 7 ps 0.6\n"
        "set tics nomirror out\nset key outside bottom center horizontal\n"
        "set title 'map view (from above, camera at the bottom)'\nset xlabel 'right (m)'\nset ylabel 'forward (m)'\n"
        f"set xrange [{number(-side)}:{number(side)}]\nset yrange [0:{number(depth)}]\n"
        "plot $unselected using 1:2 with points ls 1 title 'unselected', "
        "$selected using 1:2 with points ls 2 title 'selected', "
        "'-' using 1:2 with points lc rgb 'black' pt 9 ps 1.5 notitle\n0 0\ne\n"
        "set title 'camera view'\nset xlabel 'u (px)'\nset ylabel 'v (px)'\n"
        f"set xrange [0:{width}]\nset yrange [{height}:0]\nset size ratio {number(height / width)}\n"
        "plot $unselected using 3:4 with points ls 1 title 'unselected', "
        "$selected using 3:4 with points ls 2 title 'selected'\nunset multiplot\n"
    ))
