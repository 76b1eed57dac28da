# SPDX-License-Identifier: MIT
"""What threading_benchmark.cpp measured: its cases, and the ratios that pages and pictures show."""

from results import ratio

KINDS = ["threads", "choose", "after_pause", "side_by_side", "line"]
SIZES = ["2000", "5000", "10000", "20000", "50000", "100000"]


def find(results, kind, method, threads, n="2000", k="100", blocks="2_rows", family="euroc_like"):
    """A row; None if it was not measured."""
    return results.find_row(kind=kind, method=method, threads=str(threads), n=n, k=k, blocks=blocks, family=family)


def round_trip(results):
    """The time in which a cache line travels to the other core and back, as text."""
    row = results.find_row(kind="line")
    if row is None:
        return "not measured"
    trips = int(row["method"].split("_")[0])
    median, minimum, p99 = (1e3 * row[key] / trips for key in ("median_us", "min_us", "p99_us"))
    return f"{median:.0f} ns ({minimum:.0f} to {p99:.0f})"


def max_threads(results):
    return max((int(row["threads"]) for row in results.rows if row["kind"] == "threads"), default=1)


def speedup(results, method, n, threads):
    return ratio(find(results, "threads", method, 1, n), find(results, "threads", method, threads, n))


def chosen_costs(results):
    """(time with `threads = 0` / time with 1, row) of the small points of the grid, in ascending order."""
    points = [(r, find(results, "choose", r["method"], 0, r["n"], r["k"], r["blocks"], r["family"]))
              for r in results.rows if r["kind"] == "choose" and r["threads"] == "1"]  # fmt: skip
    return sorted(((ratio(chosen, one), one) for one, chosen in points if chosen is not None), key=lambda cost: cost[0])


def side_by_side(results):
    """The throughput of a serial selector on each thread, relative to a single one."""
    threads = max_threads(results)
    return threads * ratio(*(find(results, "side_by_side", "lazy_greedy", count) for count in (1, threads)))
