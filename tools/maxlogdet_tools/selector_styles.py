# SPDX-License-Identifier: MIT
"""Line and point of a metric or selector, the same in every picture."""

from maxlogdet_tools.gnuplot import Colour

STYLES = {
    "max_log_det": (Colour.VERMILION, "dt 1 lw 2.5 pt 7"),
    "max_trace": (Colour.BLUE, "dt 1 lw 1.5 pt 5"),
    "min_condition": (Colour.GREEN, "dt 1 lw 1.5 pt 9"),
    "max_min_eigenvalue": (Colour.PURPLE, "dt 1 lw 1.5 pt 11"),
    "md": (Colour.VERMILION, "dt 1 lw 2.5 pt 7"),
    "quality_md": (Colour.ORANGE, "dt 1 lw 1.5 pt 13"),
    "quality": (Colour.BLUE, "dt 1 lw 1.5 pt 5"),
    "bucket": (Colour.GREEN, "dt 1 lw 1.5 pt 9"),
    "observability": (Colour.PURPLE, "dt 1 lw 1.5 pt 11"),
    "random": ("#808080", "dt 3 lw 1.5 pt 1"),
    "inl": ("#d62020", "dt 2 lw 2 pt 2"),
    "all": (Colour.BLACK, "dt 1 lw 2 pt 3"),
    "all_weighted": (Colour.SKY_BLUE, "dt 2 lw 2 pt 4"),
    "md_cells": ("#8e44ad", "dt 2 lw 1.5 pt 4"),
    "md_spread": (Colour.PURPLE, "dt 1 lw 2 pt 13"),
    "md_ungated": (Colour.ORANGE, "dt 2 lw 1.5 pt 7"),
    "bucket_gated": (Colour.GREEN, "dt 1 lw 1.5 pt 9"),
    "random_gated": (Colour.BLUE, "dt 1 lw 1.5 pt 1"),
    "aligned": (Colour.SKY_BLUE, "dt 1 lw 2 pt 4"),
    "own": (Colour.BLACK, "dt 1 lw 2 pt 2"),
}
OTHER = ("#404040", "dt 1 lw 1 pt 6")


def colour_of(selector):
    """The colour alone, as gnuplot takes it behind `rgb`."""
    return f"'{STYLES.get(selector, OTHER)[0]}'"


def line_style(selector):
    return f"lc rgb {colour_of(selector)} {STYLES.get(selector, OTHER)[1]} ps 0.7"
