#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Rewrites how near answers and bounds come to the best of all subsets, in docs/trust.md, and what stochastic greedy
loses and what the proved upper bound is worth and costs, in docs/performance.md.

Usage: write_pages.py EXHAUSTIVE.csv DISTANCES.json    (of tests/core/exhaustive_test.cpp and maxlogdet_distance)
"""

import math
import statistics
import sys

from maxlogdet_tools.files import ROOT, json_of, rows_of
from maxlogdet_tools.pages import paragraph, rewrite, stamp, table

TRUST, PERFORMANCE = ROOT / "docs/trust.md", ROOT / "docs/performance.md"
OPTIMAL = 1e-10  # nats: the tolerance of the test for its own rounding


def quantile(values, share):
    """Nearest-rank quantile."""
    return sorted(values)[max(0, math.ceil(share * len(values)) - 1)]


def share(value):
    return "1" if value >= 1 - 5e-13 else f"{math.floor(1e4 * value) / 1e4:.4f}"  # rounded down


def nats(value):
    if abs(value) >= 1e4:
        return f"{value:.0e}".replace("e+0", "e").replace("e+", "e")
    return "0" if abs(value) < 1e-12 else f"{value:.1e}" if abs(value) < 1e-3 else f"{value:.3f}"


def percent(flags):
    return f"{100 * statistics.mean(flags):.1f}"


def exhaustive(rows):
    answers, bounds = {}, []
    for row in rows:
        if row["answer"].startswith("upper_bound"):
            bounds.append(float(row["distance_nats"]))
        else:
            answers.setdefault(row["answer"], []).append(row)
    alike = {}  # answers with the same figures share a row
    for answer, found in answers.items():
        shares = [float(row["share_of_optimum"]) for row in found]
        cells = (share(min(shares)), share(quantile(shares, 0.01)),
                 percent([float(row["distance_nats"]) <= OPTIMAL for row in found]))  # fmt: skip
        alike.setdefault(cells, []).append(answer)
    return [
        *paragraph(
            f"A problem is an instance with a budget; there are {len(answers['greedy'])}.",
            "Shares are of the optimum's gain over the prior."),
        "",
        *table(["strategy", "lowest share (ratio)", "1 % quantile (ratio)", "optimal (%)"],
               ([", ".join(names), *cells] for cells, names in alike.items())),
        "",
        *paragraph(
            f"`upper_bound` less the optimum: median {nats(quantile(bounds, 0.5))} nats, 99 % quantile",
            f"{nats(quantile(bounds, 0.99))}, maximum {nats(max(bounds))}, so a bound can be useless."),
    ]  # fmt: skip


def losses(rows):
    by_epsilon = {}
    for loss in (loss for row in rows for loss in row["losses"]):
        by_epsilon.setdefault(loss["epsilon"], []).append(loss["mean_nats"])
    means = [f"{statistics.mean(of_problems):.2f} ({max(of_problems):.2f}) nats at ε = {epsilon:g}"
             for epsilon, of_problems in by_epsilon.items()]  # fmt: skip
    return paragraph(f"In the {len(rows)} problems with n = 2000 and k = 100, it loses in the mean of 100 seeds (and in the",
                     f"worst problem) {', '.join(means)}.")  # fmt: skip


def certificates(rows):
    times = [row["bound_us"] for row in rows]
    return paragraph(
        f"In these problems, proving `upper_bound` (`Options::certificate`) took {min(times):.1f} to {max(times):.1f} µs.",
        f"It exceeded the log det of `lazy_greedy` by at most {max(row['gap_nats'] for row in rows):.4f} nats.",
    )


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    distances = json_of(sys.argv[2])
    rewrite(TRUST, "exhaustive", exhaustive(rows_of(sys.argv[1])))
    rewrite(PERFORMANCE, "losses", losses(distances))
    rewrite(PERFORMANCE, "certificates", certificates(distances))
    for page in (TRUST, PERFORMANCE):
        stamp(page, "how_good")


if __name__ == "__main__":
    main()
