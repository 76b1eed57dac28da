#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""What residuals depend on: models of their variance, each fitted to all sets but one and judged by that one.

Usage: fit_noise.py RESULTS    RESULTS: the folder that ci/tracker_page fills
Reads RESULTS/residuals/SET/inl/residuals.csv. Writes RESULTS/noise/models.json, RESULTS/noise/fitted_without_SET and
fitted_to_all (base and growth of sim::MotionNoise) and docs/images/tracker_residuals.svg.

A residual is a Student t with 4 degrees of freedom, for matches that are wrong, whose scale squared is a + b x. EM:
weights w = 5 / (4 + e^2 / variance), then w e^2 is regressed on (1, x) with weights 1 / variance^2.
"""

import csv
import json
import math
import pathlib
import statistics
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
PICTURE = ROOT / "docs/images/tracker_residuals.svg"
NU = 4.0
MIN_VARIANCE = 0.03**2  # px^2
MAX_RESIDUAL = 4.0  # px: beyond that a match is of another point
EVERY = 4  # of the residuals, for time's sake
# What may explain a variance, and how many levels of it the picture shows.
QUANTITIES = {
    "nothing": lambda row: 0.0,
    "motion": lambda row: float(row["motion_px"]),
    "octave": lambda row: float(row["octave"]),
    "inverse depth": lambda row: float(row["inverse_depth"]),
    "one observation": lambda row: 1.0 if int(row["observations"]) == 1 else 0.0,
    "age": lambda row: float(row["age"]),
    "no right column": lambda row: 1.0 - float(row["stereo"]),
}
AXES = {
    "image motion (px)": lambda row: float(row["motion_px"]),
    "octave": lambda row: float(row["octave"]),
    "inverse depth (1/m)": lambda row: float(row["inverse_depth"]),
    "observations": lambda row: float(row["observations"]),
    "age (keyframes)": lambda row: float(row["age"]),
    "right column (0: none)": lambda row: float(row["stereo"]),
}


def read(path):
    with open(path) as file:
        rows = [row for row in csv.DictReader(file)]
    return [row for row in rows if math.hypot(float(row["e_u"]), float(row["e_v"])) < MAX_RESIDUAL]


def samples_of(rows, quantity):
    return [(quantity(row), float(row[name]) ** 2) for row in rows[::EVERY] for name in ("e_u", "e_v")]


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
    """Mean negative log likelihood, nats, but for a constant."""
    return statistics.fmean(0.5 * math.log(a + b * x) + (NU + 1) / 2 * math.log1p(square / (NU * (a + b * x)))
                            for x, square in samples)


def levels(rows, quantity):
    """(x, rms) of six levels with as many residuals each; of what takes few values, one a value."""
    ordered = sorted((quantity(row), float(row["e_u"]) ** 2 + float(row["e_v"]) ** 2) for row in rows)
    values = sorted({x for x, _ in ordered})
    if len(values) <= 8:
        parts = [[p for p in ordered if p[0] == value] for value in values]
    else:
        parts = [ordered[i * len(ordered) // 6:(i + 1) * len(ordered) // 6] for i in range(6)]
    return [(statistics.median(x for x, _ in part), math.sqrt(statistics.fmean(e for _, e in part) / 2))
            for part in parts if len(part) >= 30]


def draw(sets):
    script = ["set terminal svg size 900,520 dynamic background '#ffffff'", f"set output '{PICTURE}'",
              "set multiplot layout 2,3", "set yrange [0:1.4]", "set grid", "set key top left",
              "set ylabel 'RMS of u, v (px)'"]  # fmt: skip
    for number, (name, quantity) in enumerate(AXES.items()):
        blocks = []
        for i, (which, rows) in enumerate(sets.items()):
            script.append(f"$d{number}_{i} << EOD")
            script += [f"{x} {y}" for x, y in levels(rows, quantity)] + ["EOD"]
            blocks.append(f"$d{number}_{i} with linespoints title '{which if number == 0 else ''}' noenhanced")
        script += [f"set xlabel '{name}'", "plot " + ", ".join(blocks)]
    subprocess.run(["gnuplot"], input="\n".join(script) + "\nunset multiplot\n", text=True, check=True)


def fit_models(sets, folder):
    """{x: {set: a, b and the mean negative log likelihood of the set by what was fitted to the others}}"""
    models = {}
    for name, quantity in QUANTITIES.items():
        samples = {which: samples_of(rows, quantity) for which, rows in sets.items()}
        models[name] = {}
        for held_out in sets:
            a, b = fit([s for which, of in samples.items() if which != held_out for s in of])
            models[name][held_out] = {"a": a, "b": b, "mean_nll": mean_nll(samples[held_out], a, b)}
        if name == "motion":
            write_constants(models[name], fit([s for of in samples.values() for s in of]), folder)
        print(name, {which: round(model["mean_nll"], 3) for which, model in models[name].items()}, flush=True)
    return models


def write_constants(motion, fitted_to_all, folder):
    constants = {f"fitted_without_{which}": (model["a"], model["b"]) for which, model in motion.items()}
    for name, (a, b) in {**constants, "fitted_to_all": fitted_to_all}.items():
        (folder / name).write_text(f"{math.sqrt(a):.3f} {math.sqrt(b):.4f}\n")


def main():
    results = pathlib.Path(sys.argv[1])
    found = sorted(results.glob("residuals/*/inl/residuals.csv"))
    sets = {path.parent.parent.name: read(path) for path in found}
    if len(sets) < 2:
        sys.exit(f"{results}/residuals: {len(sets)} sets; expected at least 2, to judge one by what the others say")
    folder = results / "noise"
    folder.mkdir(parents=True, exist_ok=True)
    models = fit_models(sets, folder)
    (folder / "models.json").write_text(json.dumps(models, indent=1) + "\n")
    draw(sets)


main()
