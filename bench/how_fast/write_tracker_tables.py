#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Prints the tables of tracker frames; rewrites them in docs/performance.md and README.md, and the record.

Usage: write_tracker_tables.py BENCH.json
"""

import itertools
import math
import sys

from maxlogdet_tools.pages import paragraph, rewrite, table
from maxlogdet_tools.project import ROOT
from maxlogdet_tools.runs import stamp
from results import Results, ratio, us
from tracker_results import (
    CACHES, KINDS, MONOCULAR, STEREO, STEREO_MAP, find, times_dense, times_eigen,
)  # fmt: skip

SHOWN = [STEREO_MAP, MONOCULAR]  # the record has all rows


def number(value, digits=2):
    return "–" if math.isnan(value) else f"{value:.{digits}f}"


def lost(row, best):
    """The loss of log det, in nats."""
    return "–" if row is None or best is None else f"{round(best['log_det'] - row['log_det'], 3) + 0.0:.3f}"


def plan(results):
    """What to expect, for the first screen."""
    calls = [find(results, "blocks_and_select", blocks, caches="cold") for blocks in (MONOCULAR, STEREO_MAP)]
    median, percentile = ([microseconds(row, counter) for row in calls] for counter in ("median_us", "p99_us"))
    return paragraph(
        "**Keep the default strategy, `lazy_greedy`. To select 100 of 465 matches, plan for",
        f"{median[0]} µs per monocular frame and {median[1]} µs per stereo frame.** These are medians with cold",
        "caches, and with map covariances for stereo. One call in a hundred took longer than",
        f"{percentile[0]} µs (monocular) or {percentile[1]} µs (stereo).",
    )


def microseconds(row, counter):
    return "–" if row is None else f"{row[counter]:.0f}"


def frames(results):
    """A frame of 465 matches."""
    rows, calls = [], {}
    for blocks, caches in itertools.product(SHOWN, CACHES):
        row = lambda method: find(results, method, blocks, caches=caches)
        measured = [row("append_blocks"), row("lazy_greedy"), row("blocks_and_select")]
        rows.append([KINDS[blocks], caches, *map(us, measured), us(measured[-1], "p99_us")])
        calls.setdefault(caches, []).extend(found["calls"] for found in measured if found is not None)
    least = {caches: f"{min(counts):.0f}" if counts else "–" for caches, counts in calls.items()}
    return [
        *table(["matches", "caches", "blocks, median, µs", "selection, median, µs", "both, median, µs",
                "both, 99th percentile, µs"], rows),
        "",
        *paragraph(f"A hot figure summarises at least {least['hot']} calls, a cold figure at least {least['cold']},",
                   "on four frames."),
    ]  # fmt: skip


def against_eigen(results):
    rows = []
    shown = [(STEREO_MAP, "465"), (MONOCULAR, "465"), (STEREO_MAP, "2000")]
    for (blocks, n), caches in itertools.product(shown, CACHES):
        row = lambda method: find(results, method, blocks, n, caches)
        rows.append([KINDS[blocks], n, caches, us(row("eigen_lazy_scan")), us(row("blocks_and_select")),
                     number(times_eigen(results, blocks, n, caches), 1)])  # fmt: skip
    return table(["matches", "n", "caches", "Eigen: selection alone, median, µs",
                  "maxlogdet: blocks and selection, median, µs", "times as fast (ratio)"], rows)  # fmt: skip


def sampling(results):
    rows = []
    for n in ("465", "2000"):
        lazy, stochastic = (find(results, method, STEREO_MAP, n) for method in ("lazy_greedy", "stochastic_greedy"))
        rows.append([n, us(lazy), us(stochastic), lost(stochastic, lazy)])
    return table(["n", "`lazy_greedy`, median, µs", "`stochastic_greedy`, median, µs", "lost on average, nats"], rows)


def worst(values):
    return number(max(values, key=lambda value: -math.inf if math.isnan(value) else value))


def change(caches, results):
    """How a motion prior changes the time of a selection."""
    row = lambda prior: find(results, "lazy_greedy", STEREO, caches=caches, prior=prior)
    percent = 100 * (ratio(row("motion"), row(None)) - 1)
    return "–" if math.isnan(percent) else f"{abs(percent):.0f} % {'more' if percent > 0 else 'less'} time ({caches})"


def details(results):
    slots = worst([times_dense(results, "blocks_and_select", blocks, "377", "2005", caches)
                   for blocks, caches in itertools.product(SHOWN, CACHES)])  # fmt: skip
    return paragraph(
        "Pass matches alone, without empty slots. With 1628 empty slots, which `Matches::usable` marks, 377 matches",
        f"take up to {slots} times as long. With a motion prior of 5 cm and 0.01 rad (standard deviations), selecting",
        "from a stereo frame without covariances takes",
        f"{change('hot', results)} and {change('cold', results)}.",
    )


def active(results):
    rows, losses = [], {"8": [], "32": []}
    for n, share in (("800", "1"), ("800", "0.5"), ("800", "0.2"), ("3000", "1"), ("3000", "0.2")):
        select = find(results, "lazy_greedy", STEREO_MAP, n)
        one, *batches = (find(results, "active", STEREO_MAP, n, batch=batch, matched=share) for batch in ("1", *losses))
        rows.append([n, f"{100 * float(share):.0f}", *map(us, (select, one, *batches))])
        for found, batch in zip(losses.values(), batches):
            found += [lost(batch, one)] if one is not None and batch is not None else []
    most = {batch: max(found, key=float, default="–") for batch, found in losses.items()}
    return [
        *table(["n", "found, % of proposals", "`select`, median, µs", "one by one, median, µs",
                "batches of 8, median, µs", "batches of 32, median, µs"], rows),
        "",
        *paragraph(f"Compared with proposals one by one, batches of 8 lost at most {most['8']} nats and batches of 32",
                   f"at most {most['32']} nats."),
    ]  # fmt: skip


def readme(results):
    rows = []
    for blocks, caches in itertools.product(SHOWN, CACHES):
        both = find(results, "blocks_and_select", blocks, caches=caches)
        rows.append([KINDS[blocks], caches, us(both), us(both, "p99_us"),
                     us(find(results, "eigen_lazy_scan", blocks, caches=caches)),
                     number(times_eigen(results, blocks, "465", caches), 1)])  # fmt: skip
    return [
        *paragraph(
            "The library selects 100 of the 465 matches of a simulated frame. A *hot* call follows other calls, so",
            "that the caches hold its code and data. Before a *cold* call, other work has filled the caches, as the",
            "rest of a tracker does. Plan with the cold rows ([details](docs/performance.md#in-a-tracker)).",
        ),
        "",
        *table(["matches", "caches", "maxlogdet: Jacobians and selection, median, µs", "the same, 99th percentile, µs",
                "lazy greedy in Eigen: selection alone, median, µs", "times as fast (ratio)"], rows),
    ]  # fmt: skip


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    results = Results(sys.argv[1])
    if not any(row["kind"] == "tracker" for row in results.rows):
        print("no case of a tracker was measured: its tables stay unchanged")
        return
    performance, front = ROOT / "docs/performance.md", ROOT / "README.md"
    for section in (plan, frames, against_eigen, sampling, details, active):
        lines = section(results)
        print("\n".join(lines))
        rewrite(performance, section.__name__, lines)
    rewrite(front, "tracker_latency", readme(results))
    for page in (performance, front):
        stamp(page, "how_fast --tracker")
    results.record("tracker.csv", "tracker")


if __name__ == "__main__":
    main()
