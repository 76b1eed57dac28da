# SPDX-License-Identifier: MIT
"""`maxlogdet_simulate metrics`: RMS errors over the subset size, four panels as in the paper."""

from maxlogdet_tools.gnuplot import STYLE, Picture, data_block
from maxlogdet_tools.selector_styles import line_style

PANELS = (("RMS translation error (m)", "1:2:3"), ("RMS rotation error (deg)", "1:4:5"))
COLUMNS = ("size", "rms_translation_m", "ci95_of_rms_translation_m", "rms_rotation_deg", "ci95_of_rms_rotation_deg")


def curve(selector, noise, columns):
    using, style = (columns[:3], "lines") if selector == "all" else (columns, "yerrorlines")
    return f"${selector}_{noise} using {using} with {style} {line_style(selector)} title '{selector}'"


def picture(rows):
    """`rows`: those of metrics.csv."""
    selectors = list(dict.fromkeys(row["selector"] for row in rows))
    blocks, panels = "", ""
    for noise in dict.fromkeys(row["noise_px"] for row in rows):
        for selector in selectors:
            chosen = [row for row in rows if row["noise_px"] == noise and row["selector"] == selector]
            blocks += data_block(f"{selector}_{noise}", [[row[column] for column in COLUMNS] for row in chosen])
        for label, columns in PANELS:
            panels += (f"set title 'noise {noise} px'\nset ylabel '{label}'\nplot "
                       + ", \\\n".join(curve(selector, noise, columns) for selector in selectors) + "\n")
    return Picture(1200, 800, (
        blocks + STYLE + "set multiplot layout 2,2 title 'bars: 95 % confidence'\nset xlabel 'subset size'\n"
        + panels + "unset multiplot\n"
    ))
