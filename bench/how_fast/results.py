# SPDX-License-Identifier: MIT
"""What the benchmarks measured, from Google Benchmark's JSON: the source of every number in tables and pictures."""

import math
import pathlib

from maxlogdet_tools.files import json_of, write_csv

RESULTS = pathlib.Path(__file__).parent / "results"
BASE = {"family": "euroc_like", "n": "2000", "k": "100", "blocks": "2_rows"}
SIZES = ["200", "500", "1000", "2000", "5000", "20000", "100000"]
EPSILONS = ["0.5", "0.1", "0.01"]
BLOCKS = {
    "1_row": "1 row",
    "2_rows": "2 rows",
    "3_rows": "3 rows",
    "2_rows_measurement": "2 rows, measurement",
    "3_rows_measurement": "3 rows, measurement",
}
# The baselines, in the order of columns.
EIGEN = {
    "eigen_exact": "Eigen exact",
    "eigen_exact_batched": "Eigen exact, batched",
    "eigen_lazy": "Eigen lazy, heap",
    "eigen_lazy_scan": "Eigen lazy, scan",
    "eigen_stochastic": "Eigen stochastic",
    "eigen_log_det": "Eigen log det",
}
STRATEGIES = ["greedy", "lazy_greedy", "stochastic_greedy"]
STOCHASTIC = ["stochastic_greedy", "eigen_stochastic", "eigen_log_det"]
# How pages write instruction sets.
ISAS = {"sse2": "SSE2", "avx2": "AVX2", "avx512": "AVX-512", "neon": "NEON"}
# Columns of the records: the fields of a case, and its counters.
FIELDS = ["kind", "method", "caches", "family", "blocks", "weighting", "third", "n", "k", "epsilon", "threads", "isa",
          "slots", "prior"]  # fmt: skip
COUNTERS = ["median_us", "min_us", "p99_us", "p999_us", "max_us", "undisturbed_p99_us", "calls", "preemptions",
            "delta_nats", "log_det", "mismatches", "evaluations", "float64_decisions", "inliers",
            "wrong_percent", "deviation_mm"]  # fmt: skip


class Results:
    def __init__(self, path):
        data = json_of(path)
        self.context = data["context"]
        rows = {}
        for result in data["benchmarks"]:
            if result["run_type"] != "iteration" or "median_us" not in result:
                continue
            row = {**result, **fields_of(result["name"])}
            # The repetition with the highest number of calls has the samples of all of them.
            known = rows.get(result["name"])
            if known is None or known["calls"] < row["calls"]:
                rows[result["name"]] = row
        self.rows = list(rows.values())
        self.widest = self.context["maxlogdet_isa"]

    def find(self, method, kind="select", **where):
        """The row of a method at the base point, changed by `where`; None if it was not measured."""
        wanted = {**BASE, "method": method, "kind": kind, **where}
        if method in STOCHASTIC:
            wanted.setdefault("epsilon", "0.1")
        wanted.setdefault("isa", "native" if method in EIGEN else self.widest)
        return self.find_row(**wanted)

    def find_row(self, **wanted):
        """The row with these fields (None: without that field); None if it was not measured."""
        return next((row for row in self.rows if all(row.get(key) == value for key, value in wanted.items())), None)

    def find_append(self, kind, third, weighting="map_bias"):
        return self.find_row(kind=kind, third=third, weighting=weighting)

    def baseline(self, method, row):
        """The row of a baseline at the point of `row`."""
        where = {key: row[key] for key in BASE}
        if method in STOCHASTIC:
            where["epsilon"] = row.get("epsilon", "0.1")
        return self.find(method, **where)

    def record(self, name, *kinds):
        """Records all rows of some kinds."""
        rows = [{**row, **{f: "" for f in FIELDS if not isinstance(row.get(f, ""), str)},
                 "preemptions": round(row["calls"] * row["preemptions"])}
                for row in self.rows if row["kind"] in kinds]  # fmt: skip
        columns = [column for column in [*FIELDS, *COUNTERS] if any(row.get(column, "") != "" for row in rows)]
        number = lambda text: int(text) if text.isdigit() else 0
        rows.sort(key=lambda row: [(number(row.get(f, "")), row.get(f, "")) for f in FIELDS])
        short = lambda value: value if isinstance(value, str) else f"{value:.6g}"
        write_csv(RESULTS / name, columns, ([short(row.get(column, "")) for column in columns] for row in rows))


def fields_of(name):
    """The fields of KIND/METHOD/KEY:VALUE/..., the names in selection_benchmark.cpp."""
    parts = name.split("/")
    fields = dict(part.split(":", 1) for part in parts if ":" in part)
    words = [part for part in parts if ":" not in part]
    return {"kind": words[0], "method": words[1].removesuffix("manual_time"), **fields}


def label_of(method, epsilon=None):
    text = EIGEN.get(method, method)
    return f"{text}, ε = {epsilon}" if epsilon is not None else text


def ratio(slow, fast):
    if slow is None or fast is None:
        return math.nan
    return slow["median_us"] / fast["median_us"]


def printed_ratio(slow, fast):
    """The ratio of two times as us() writes them, so that a reader who divides finds the same."""
    return "–" if "–" in (slow, fast) else times(float(slow) / float(fast))


def fastest(rows):
    rows = [row for row in rows if row is not None]
    return min(rows, key=lambda row: row["median_us"]) if rows else None


def us(row, counter="median_us"):
    """A time with at least three digits."""
    if row is None:
        return "–"
    value = row[counter]
    return f"{value:.0f}" if value >= 1000 else f"{value:.1f}"


def lost(row):
    """The loss: the log det of exact greedy minus that of this row."""
    return "–" if row is None else f"{round(-row['delta_nats'], 3) + 0.0:.3f}"


def times(value):
    return "–" if math.isnan(value) else f"{value:.0f}" if value >= 10 else f"{value:.1f}"
