# SPDX-License-Identifier: MIT
"""Section IV: tables of `maxlogdet simulate epsilon`."""

from maxlogdet_tools.pages import table
from simulated import Experiment, record

COLUMNS = ["ε", "1 − 1/e − ε", "minimum f / f(greedy)", "minimum f / bound", "mean gap (nats)",
                   "features differing (%)", "× fewer gains", "× faster than greedy", "× faster than lazy greedy"]
SETS = [("all", "Over the whole grid"), ("n = 1000, k = 100", "n = 1000")]
SHOWN_EPSILONS = ["1", "0.1", "0.01"]  # by the page; bench/does_the_paper_hold/results has all


def epsilon_table(epsilon):
    lines = []
    for name, heading in SETS:
        rows = [row for row in epsilon.rows(heading)[1:] if row[0] in SHOWN_EPSILONS]
        lines += [[name if row is rows[0] else "", *row[:3], *row[4:]] for row in rows]
    return table(["n, k", *COLUMNS[:3], *COLUMNS[4:]], lines)


def record_all(results):
    epsilon = Experiment(results, "epsilon")
    record("epsilon_summary", ["n and k", *COLUMNS],
              ([name, *row] for name, heading in SETS for row in epsilon.rows(heading)[1:]))


def tables(results):
    return {"epsilon": epsilon_table(Experiment(results, "epsilon"))}
