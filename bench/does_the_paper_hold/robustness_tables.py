# SPDX-License-Identifier: MIT
"""Tables of `maxlogdet simulate robustness`."""

import re

from maxlogdet_tools.pages import table
from simulated import Experiment, estimate, record

TAUS = ["0.1", "0.25", "0.5", "1", "2"]
FOLDER_OF_TAU = {tau: "robustness" if tau == "0.5" else f"robustness_tau_{tau}" for tau in TAUS}
ROBUSTNESS = list(dict.fromkeys(["robustness", "robustness_kitti", "robustness_gate", *FOLDER_OF_TAU.values()]))
SHOWN_TAUS = ["0.1", "0.25", "0.5", "2"]  # by the page; bench/does_the_paper_hold/results has all


def differences(results, folder):
    return Experiment(results, folder).cells("Difference", "with 60 of 500 matches")


def robustness_table(results):
    shown = [("robustness", "none"), ("robustness", "batches"), ("robustness_kitti", "batches"),
             ("robustness", "patches")]
    levels = []
    for folder, disturbance in shown:
        cells = Experiment(results, folder).cells("RMS errors", "with 60 of 500 matches")[disturbance]
        levels.append(f"{cells['md (m)']}, {cells['md (deg)']}")
    found = [differences(results, folder)[disturbance] for folder, disturbance in shown]
    return table(["", "`none`", "`batches`", "`batches`, KITTI-like", "`patches`"],
                 [["md itself (m, deg)", *levels],
                  *(["against " + other, *(cells[other] for cells in found)] for other in list(found[0])[1:])])


def tau_table(results):
    rows = []
    for tau in SHOWN_TAUS:
        cells = differences(results, FOLDER_OF_TAU[tau])
        rows.append([tau, cells["none"]["shared_keyframes"], cells["batches"]["shared_keyframes"]])
    return table(["τ (px)", "`none`", "`batches`"], rows)


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
    return {"robustness": robustness_table(results), "robustness_tau": tau_table(results)}
