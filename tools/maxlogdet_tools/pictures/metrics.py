# SPDX-License-Identifier: MIT
"""`maxlogdet_simulate metrics`: RMS errors over the subset size, four panels as in the paper; a picture for each weighting."""

from maxlogdet_tools.gnuplot import STYLE, Picture, data_block, number
from maxlogdet_tools.selector_styles import line_style

PANELS = (("RMS translation error (m)", "1:2:3"), ("RMS rotation error (deg)", "1:4:5"))
WITHOUT_BARS = ("all", "all_weighted")
COLUMNS = ("size", "rms_translation_m", "ci95_translation_m", "rms_rotation_deg", "ci95_rotation_deg")


def curve(selector, noise_place, columns):
    is_line = selector in WITHOUT_BARS
    using, style = (columns[:3], "lines") if is_line else (columns, "yerrorlines")
    return f"${selector}_{noise_place} using {using} with {style} {line_style(selector)} title '{selector}'"


def picture(weighting, noises, rows):
    """`rows`: those of one weighting."""
    selectors = list(dict.fromkeys(row["selector"] for row in rows))
    blocks, panels = "", ""
    for n, noise in enumerate(noises):
        for selector in selectors:
            chosen = [row for row in rows if row["noise_px"] == noise and row["selector"] == selector]
            in_order = sorted(chosen, key=lambda row: row["size"])
            blocks += data_block(f"{selector}_{n}", [[row[column] for column in COLUMNS] for row in in_order])
        for label, columns in PANELS:
            panels += (f"set title 'noise {number(noise)} px'\nset ylabel '{label}'\nplot "
                       + ", \\\n".join(curve(selector, n, columns) for selector in selectors) + "\n")
    return Picture(1200, 800, (
        blocks + STYLE + f"set multiplot layout {len(noises)},2 title '{weighting} blocks, {number(rows[0]['runs'])} runs; "
        "bars: 95 % confidence'\nset xlabel 'subset size'\n" + panels + "unset multiplot\n"
    ))


def pictures(settings, rows):
    return {f"metrics_{weighting}": picture(weighting, settings["noises_px"],
                                            [row for row in rows if row["weighting"] == weighting])
            for weighting in settings["weightings"]}
