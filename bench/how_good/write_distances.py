#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Shows in docs/performance.md what stochastic greedy loses, and what the proved upper bound is worth and costs.

Usage: write_distances.py DISTANCES.json    (of maxlogdet_distance)
"""

import statistics
import sys

from maxlogdet_tools.files import json_of
from maxlogdet_tools.pages import paragraph, rewrite, table
from maxlogdet_tools.project import ROOT
from maxlogdet_tools.runs import stamp

PAGE = ROOT / "docs/performance.md"


def losses(rows):
    by_epsilon = {}
    for loss in (loss for row in rows for loss in row["losses"]):
        by_epsilon.setdefault(loss["epsilon"], []).append(loss["mean_nats"])
    return table(["ε", "loss, mean, nats", "loss of the worst problem, mean, nats"],
                 ([f"{epsilon:g}", f"{statistics.mean(of_problems):.2f}", f"{max(of_problems):.2f}"]
                  for epsilon, of_problems in by_epsilon.items()))  # fmt: skip


def certificates(rows):
    times = [row["bound_us"] for row in rows]
    return paragraph(
        f"In the {len(rows)} problems with n = 2000 and k = 100, computing the bound took {min(times):.1f} to",
        f"{max(times):.1f} µs, and `upper_bound` exceeded the log det of `lazy_greedy` by at most",
        f"{max(row['gap_nats'] for row in rows):.4f} nats.",
    )


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    rows = json_of(sys.argv[1])
    rewrite(PAGE, "losses", losses(rows))
    rewrite(PAGE, "certificates", certificates(rows))
    stamp(PAGE, "how_good")


if __name__ == "__main__":
    main()
