#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Fits models of the variance of residuals to all sets except one, and evaluates them on that one.

Usage: fit_noise.py RESULTS    RESULTS: the folder that bench/run does_it_track fills
Reads RESULTS/residuals/SET/inl/residuals.csv. Writes RESULTS/noise/models.json, RESULTS/noise/fitted_to_all (base and
growth of sim::MotionNoise) and docs/images/tracker_residuals.svg.

A residual has a Student t distribution with 4 degrees of freedom, because of wrong matches; its squared scale is
a + b x. EM: weights w = 5 / (4 + e^2 / variance), then w e^2 is regressed on (1, x) with weights 1 / variance^2.
"""

import json
import math
import pathlib
import statistics
import sys

from maxlogdet_tools.files import rows_of
from maxlogdet_tools.gnuplot import Picture, data_block, draw
from maxlogdet_tools.project import ROOT

PICTURE = ROOT / "docs/images/tracker_residuals.svg"
NU = 4.0
MIN_VARIANCE = 0.03**2  # px^2
MAX_RESIDUAL = 4.0  # px: larger ones are wrong matches
STEP = 4  # fits every `STEP`-th residual, to save time
# Quantities that may explain the variance.
QUANTITIES = {
    "nothing": lambda row: 0.0,
    "motion": lambda row: float(row["motion_px"]),
    "octave": lambda row: float(row["octave"]),
    "inverse depth": lambda row: float(row["inverse_depth"]),
    "one observation": lambda row: 1.0 if int(row["observations"]) == 1 else 0.0,
    "age": lambda row: float(row["age"]),
    "no right column": lambda row: 1.0 - float(row["stereo"]),
}
AXES = {  # of the picture: column and step of the tics
    "image motion (px)": ("motion_px", 50),
    "octave": ("octave", 1),
    "inverse depth (1/m)": ("inverse_depth", 0.4),
    "observations": ("observations", 1),
    "age (keyframes)": ("age", 1),
    "right column (0: none)": ("stereo", 1),
}


def read(path):
    return [row for row in rows_of(path) if math.hypot(float(row["e_u"]), float(row["e_v"])) < MAX_RESIDUAL]


def samples_of(rows, quantity):
    return [(quantity(row), float(row[name]) ** 2) for row in rows[::STEP] for name in ("e_u", "e_v")]


def fit(samples):
    """(a, b) of the variance a + b x, neither negative."""
    a, b = 0.1, 0.0
    for _ in range(40):
        s00 = s01 = s11 = r0 = r1 = 0.0
        for x, square in samples:
            variance = a + b * x
            y = (NU + 1) / (NU + square / variance) * square
            weight = 1 / (variance * variance)
            s00 += weight
            s01 += weight * x
            s11 += weight * x * x
            r0 += weight * y
            r1 += weight * x * y
        determinant = s00 * s11 - s01 * s01
        a, b = r0 / s00, 0.0
        if determinant > 1e-12 * s00 * s11:
            a, b = (s11 * r0 - s01 * r1) / determinant, (s00 * r1 - s01 * r0) / determinant
            if a < MIN_VARIANCE:
                a, b = MIN_VARIANCE, (r1 - MIN_VARIANCE * s01) / s11
            if b < 0:
                a, b = r0 / s00, 0.0
    return a, b


def mean_nll(samples, a, b):
    """Mean negative log likelihood up to a constant, nats."""
    return statistics.fmean(0.5 * math.log(a + b * x) + (NU + 1) / 2 * math.log1p(square / (NU * (a + b * x)))
                            for x, square in samples)


def levels(rows, column):
    """(x, rms) of six quantile groups; of each value if there are few."""
    ordered = sorted((float(row[column]), float(row["e_u"]) ** 2 + float(row["e_v"]) ** 2) for row in rows)
    values = sorted({x for x, _ in ordered})
    if len(values) <= 8:
        parts = [[p for p in ordered if p[0] == value] for value in values]
    else:
        parts = [ordered[i * len(ordered) // 6:(i + 1) * len(ordered) // 6] for i in range(6)]
    return [(statistics.median(x for x, _ in part), math.sqrt(statistics.fmean(e for _, e in part) / 2))
            for part in parts if len(part) >= 30]


def picture(sets):
    script = ["set encoding utf8", "set multiplot layout 2,3", "set yrange [0:1.4]", "set grid", "set key bottom right",
              "set ylabel 'RMS of u, v (px)'"]  # fmt: skip
    for number, (name, (column, step)) in enumerate(AXES.items()):
        curves = []
        for i, (which, rows) in enumerate(sets.items()):
            script.append(data_block(f"d{number}_{i}", levels(rows, column)))
            curves.append(f"$d{number}_{i} with linespoints title '{which if number == 0 else ''}'")
        script += [f"set xlabel '{name}'", f"set xtics {step}", "plot " + ", ".join(curves)]
    return Picture(1050, 600, "\n".join(script) + "\nunset multiplot\n")


def fit_models(sets, folder):
    """{x: {set: a, b fitted to the other sets, and the mean negative log likelihood of the set}}"""
    models = {}
    for name, quantity in QUANTITIES.items():
        samples = {which: samples_of(rows, quantity) for which, rows in sets.items()}
        models[name] = {}
        for held_out in sets:
            a, b = fit([s for which, of in samples.items() if which != held_out for s in of])
            models[name][held_out] = {"a": a, "b": b, "mean_nll": mean_nll(samples[held_out], a, b)}
        if name == "motion":
            a, b = fit([s for of in samples.values() for s in of])
            (folder / "fitted_to_all").write_text(f"{math.sqrt(a):.3f} {math.sqrt(b):.4f}\n")
        print(name, {which: round(model["mean_nll"], 3) for which, model in models[name].items()}, flush=True)
    return models


def main():
    results = pathlib.Path(sys.argv[1])
    found = sorted(results.glob("residuals/*/inl/residuals.csv"))
    sets = {path.parent.parent.name: read(path) for path in found}
    if len(sets) < 2:
        sys.exit(f"{results}/residuals: {len(sets)} sets; expected at least 2, to fit to one and evaluate on another")
    folder = results / "noise"
    folder.mkdir(parents=True, exist_ok=True)
    models = fit_models(sets, folder)
    (folder / "models.json").write_text(json.dumps(models, indent=1) + "\n")
    draw(picture(sets), PICTURE)


main()
