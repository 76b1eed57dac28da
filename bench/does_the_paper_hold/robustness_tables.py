# SPDX-License-Identifier: MIT
"""Tables of `maxlogdet simulate robustness`."""

import re

from maxlogdet_tools.pages import table
from simulated import Experiment, brief, estimate, record

TAUS = ["0.1", "0.25", "0.5", "1", "2"]
FOLDER_OF_TAU = {tau: "robustness" if tau == "0.5" else f"robustness_tau_{tau}" for tau in TAUS}
ROBUSTNESS = list(dict.fromkeys(["robustness", "robustness_kitti", "robustness_gate", *FOLDER_OF_TAU.values()]))
# The parts that the page shows; results has everything.
SHOWN_DISTURBANCES = ["none", "batches"]
SHOWN_RIVALS = ["all", "random", "md_keyframes", "shared_keyframes"]


def robustness_table(results):
    differences = Experiment(results, "robustness").cells("Difference", "with 60 of 500 matches")
    rows = []
    for rival in SHOWN_RIVALS:
        both = [differences[disturbance][rival].split(", ") for disturbance in SHOWN_DISTURBANCES]
        rows.append([f"`{rival}`", *(brief(cell) for cells in both for cell in cells)])
    return table(["`md` against", *(f"`{disturbance}`, {error} (%)" for disturbance in SHOWN_DISTURBANCES
                                    for error in ("translation", "rotation"))], rows)


def robustness_difference_rows(results):
    for folder in ROBUSTNESS:
        experiment = Experiment(results, folder)
        for heading, _ in experiment.sections:
            budget = re.search(r"with (\d+) of", heading)
            if not heading.startswith("Difference"):
                continue
            for disturbance, cells in experiment.cells(heading).items():
                for other, cell in list(cells.items())[1:]:
                    both = [value for part in cell.split(", ") for value in estimate(part)]
                    yield [folder, disturbance, budget[1], other, *both]


def robustness_error_rows(results):
    columns = ["rms_translation_m", "ci95_translation_m", "rms_rotation_deg", "ci95_rotation_deg"]
    for folder in ROBUSTNESS:
        for row in Experiment(results, folder).csv("robustness.csv"):
            which = [row[c] for c in ("disturbance", "selector", "budget")]
            yield [folder, *which, *(f"{float(row[c]):.5g}" for c in columns)]


def record_all(results):
    errors = ["rms_translation_m", "translation_ci95", "rms_rotation_deg", "rotation_ci95"]
    record("robustness_errors", ["experiment", "disturbance", "selector", "budget", *errors],
              robustness_error_rows(results))
    both = [f"{error}_{what}" for error in ("translation", "rotation") for what in ("percent", "ci95", "verdict")]
    record("robustness_differences", ["experiment", "disturbance", "budget", "md_against", *both],
              robustness_difference_rows(results))


def tables(results):
    return {"robustness": robustness_table(results)}
