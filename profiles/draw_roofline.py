#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Draws docs/images/roofline.{svg,png} from profiles/roofline.json."""

from maxlogdet_tools.files import json_of
from maxlogdet_tools.gnuplot import Picture, draw_both
from maxlogdet_tools.project import ROOT

COLOURS = ["#7f8c8d", "#1f77b4", "#d95f02"]  # from narrow to wide instruction sets
POINT_TYPES = {2: 7, 3: 5}  # rows: circle, square
LOWEST, HIGHEST = 0.1, 32.0  # flop / byte


def script(record):
    peaks = record["peak_gflops"]
    colours = dict(zip(peaks, COLOURS[-len(peaks) :]))
    top = max(peaks.values())
    commands = [
        f"set title '{record['machine']}: full round of {record['candidates']}, {record['arithmetic']}'",
        "set logscale xy 2",
        f"set xrange [{LOWEST}:{HIGHEST}]",
        f"set yrange [{min(r['gflops'] for r in record['full_round']) / 2}:{2 * top}]",
        "set xtics (0.125, 0.25, 0.5, 1, 2, 4, 8, 16, 32)",
        "set xlabel 'arithmetic intensity, flop per byte of blocks read and gains written'",
        "set ylabel 'GFLOP/s'",
        "set grid back lt 1 lc rgb '#e0e0e0'",
        "set key bottom right",
    ]
    for isa, peak in peaks.items():
        commands.append(f"set label '{isa} peak, float32 multiply-adds: {peak:.0f}' at "
                        f"{0.98 * HIGHEST},{1.12 * peak} right tc rgb '{colours[isa]}'")
    plots = []
    for cache, dash in (("L1", 1), ("L2", 2)):
        bandwidth = record[f"{cache.lower()}_gb_s"]
        ridge = top / bandwidth
        plots.append(f"[{LOWEST}:{ridge}] {bandwidth} * x with lines lw 2 dt {dash} lc rgb '#404040' "
                     f"title '{cache} loads, {bandwidth:.0f} GB/s'")
    for isa, peak in peaks.items():
        plots.append(f"[{peak / record['l1_gb_s']}:{HIGHEST}] {peak} with lines lw 2 lc rgb '{colours[isa]}' notitle")
    for rows, point in POINT_TYPES.items():
        for isa, colour in colours.items():
            r = next(r for r in record["full_round"] if r["rows"] == rows and r["isa"] == isa)
            commands.append(f"${isa}_{rows} << EOD\n{r['intensity']} {r['gflops']}\nEOD")
            plots.append(f"${isa}_{rows} with points pt {point} ps 1.4 lc rgb '{colour}' "
                         f"title '{isa}, {rows} rows: {r['gflops']:.0f}'")
    return "\n".join(commands) + "\nplot sample " + ", \\\n".join(plots) + "\n"


draw_both(Picture(900, 560, script(json_of(ROOT / "profiles/roofline.json"))), ROOT / "docs/images/roofline")
