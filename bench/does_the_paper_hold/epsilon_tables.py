# SPDX-License-Identifier: MIT
"""Section IV: tables of `maxlogdet_simulate epsilon`."""

from maxlogdet_tools.pages import table
from simulated import Experiment, record

COLUMNS = ["ε", "1 − 1/e − ε", "minimum f / f(greedy)", "mean gap (nats)",
           "features differing (%)", "× fewer gains", "× faster than greedy", "× faster than lazy greedy"]
SETS = [("all", "Over the whole grid"), ("n = 1000, k = 100", "n = 1000")]
# The part that the page shows, of the second set; results has everything.
SHOWN_EPSILONS = ["1", "0.1"]
SHOWN_COLUMNS = {
    "ε": "ε",
    "1 − 1/e − ε": "guarantee (ratio)",
    "minimum f / f(greedy)": "minimum f / f(greedy) (ratio)",
    "× fewer gains": "fewer evaluations (ratio)",
    "× faster than lazy greedy": "faster than lazy greedy (ratio)",
}


def epsilon_table(epsilon):
    cells = epsilon.cells(SETS[1][1])
    return table(SHOWN_COLUMNS.values(), ([cells[e][column] for column in SHOWN_COLUMNS] for e in SHOWN_EPSILONS))


def record_all(results):
    epsilon = Experiment(results, "epsilon")
    record("epsilon_summary", ["n and k", *COLUMNS],
              ([name, *row] for name, heading in SETS for row in epsilon.rows(heading)[1:]))


def tables(results):
    return {"epsilon": epsilon_table(Experiment(results, "epsilon"))}
