# SPDX-License-Identifier: MIT
"""Line and point of a metric or selector, the same in every picture."""

from maxlogdet_tools.gnuplot import Colour

STYLES = {
    "max_log_det": (Colour.VERMILION, "dt 1 lw 2.5 pt 7"),
    "max_trace": (Colour.BLUE, "dt 1 lw 1.5 pt 5"),
    "min_condition": (Colour.GREEN, "dt 1 lw 1.5 pt 9"),
    "max_min_eigenvalue": (Colour.PURPLE, "dt 1 lw 1.5 pt 11"),
    "md": (Colour.VERMILION, "dt 1 lw 2.5 pt 7"),
    "bucket": (Colour.GREEN, "dt 1 lw 1.5 pt 9"),
    "random": ("#808080", "dt 3 lw 1.5 pt 1"),
    "all": (Colour.BLACK, "dt 1 lw 2 pt 3"),
    "md_spread": (Colour.PURPLE, "dt 1 lw 2 pt 13"),
    "md_ungated": (Colour.ORANGE, "dt 2 lw 1.5 pt 7"),
    "bucket_gated": (Colour.GREEN, "dt 1 lw 1.5 pt 9"),
    "random_gated": (Colour.BLUE, "dt 1 lw 1.5 pt 1"),
    "aligned": (Colour.SKY_BLUE, "dt 1 lw 2 pt 4"),
}
OTHER = ("#404040", "dt 1 lw 1 pt 6")


def colour_of(selector):
    """The colour alone, as gnuplot takes it behind `rgb`."""
    return f"'{STYLES.get(selector, OTHER)[0]}'"


def line_style(selector):
    return f"lc rgb {colour_of(selector)} {STYLES.get(selector, OTHER)[1]} ps 0.7"
