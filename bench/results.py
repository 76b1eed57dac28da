# SPDX-License-Identifier: MIT
"""What the benchmarks measured, from Google Benchmark's JSON. Every number in tables and plots comes from here."""

import csv
import json
import math
import pathlib
import platform

ROOT = pathlib.Path(__file__).resolve().parent.parent

BASE = {"family": "euroc_like", "n": "2000", "k": "100", "blocks": "2_rows"}
EPSILONS = ["0.5", "0.1", "0.01"]
BLOCKS = {
    "1_row": "1 row",
    "2_rows": "2 rows",
    "3_rows": "3 rows",
    "2_rows_measurement": "2 rows, measurement",
    "3_rows_measurement": "3 rows, measurement",
}
# The baselines that give the same answer as exact greedy, in the order of columns.
EIGEN = {
    "eigen_exact": "Eigen exact",
    "eigen_exact_batched": "Eigen exact, batched",
    "eigen_lazy": "Eigen lazy, heap",
    "eigen_lazy_scan": "Eigen lazy, scan",
    "eigen_stochastic": "Eigen stochastic",
    "eigen_log_det": "Eigen log det",
}
STRATEGIES = ["greedy", "lazy_greedy", "stochastic_greedy", "relaxed", "backward_greedy"]
STOCHASTIC = ["stochastic_greedy", "eigen_stochastic", "eigen_log_det"]
# Columns of the records in bench/results: what a case is, and what was counted.
FIELDS = ["kind", "method", "caches", "family", "blocks", "weighting", "third", "n", "k", "epsilon", "threads", "isa",
          "slots", "prior", "batch", "matched"]  # fmt: skip
COUNTERS = ["median_us", "min_us", "p99_us", "p999_us", "max_us", "undisturbed_p99_us", "calls", "preemptions",
            "delta_nats", "log_det", "mismatches", "evaluations", "float64_decisions", "proposals"]  # fmt: skip


class Results:
    def __init__(self, path):
        data = json.loads(pathlib.Path(path).read_text())
        self.context = data["context"]
        rows = {}
        for result in data["benchmarks"]:
            if result["run_type"] != "iteration" or "median_us" not in result:
                continue
            row = {**result, **fields_of(result["name"])}
            # Repetitions are pooled: the one with the largest number of calls holds all.
            known = rows.get(result["name"])
            if known is None or known["calls"] < row["calls"]:
                rows[result["name"]] = row
        self.rows = list(rows.values())
        self.widest = self.context["maxlogdet_isa"]

    def find(self, method, kind="select", **where):
        """The row of a method at the base point but for `where`; None if it was not measured."""
        wanted = {**BASE, "method": method, "kind": kind, **where}
        if method in STOCHASTIC:
            wanted.setdefault("epsilon", "0.1")
        wanted.setdefault("isa", "native" if method in EIGEN else self.widest)
        return next((row for row in self.rows if all(row.get(key) == value for key, value in wanted.items())), None)

    def find_append(self, kind, third, weighting="map_bias"):
        return next(
            (r for r in self.rows if r["kind"] == kind and r["third"] == third and r["weighting"] == weighting), None
        )

    def baseline(self, method, row):
        """What a baseline took where `row` was measured."""
        where = {key: row[key] for key in BASE}
        if method in STOCHASTIC:
            where["epsilon"] = row.get("epsilon", "0.1")
        return self.find(method, **where)

    def find_threads(self, kind, method, threads, n="2000", k="100", blocks="2_rows", family="euroc_like"):
        """A row of threading_benchmark.cpp."""
        wanted = {"kind": kind, "method": method, "threads": str(threads), "n": n, "k": k, "blocks": blocks,
                  "family": family}
        return next((row for row in self.rows if all(row.get(key) == value for key, value in wanted.items())), None)

    def find_append_threads(self, n, threads):
        wanted = {"kind": "append_threads", "n": n, "threads": str(threads)}
        return next((row for row in self.rows if all(row.get(key) == value for key, value in wanted.items())), None)

    def round_trip(self):
        """What a cache line's way to the other core and back took, in words."""
        row = next((row for row in self.rows if row["kind"] == "line"), None)
        if row is None:
            return "not measured"
        trips = int(row["method"].split("_")[0])
        median, minimum, p99 = (1e3 * row[key] / trips for key in ("median_us", "min_us", "p99_us"))
        return f"{median:.0f} ns ({minimum:.0f} to {p99:.0f})"

    def record(self, name, *kinds):
        """Writes all that was measured of some kinds into bench/results."""
        rows = [{**row, **{f: "" for f in FIELDS if not isinstance(row.get(f, ""), str)},
                 "preemptions": round(row["calls"] * row["preemptions"])}
                for row in self.rows if row["kind"] in kinds]  # fmt: skip
        columns = [column for column in [*FIELDS, *COUNTERS] if any(row.get(column, "") != "" for row in rows)]
        number = lambda text: int(text) if text.isdigit() else 0
        rows.sort(key=lambda row: [(number(row.get(f, "")), row.get(f, "")) for f in FIELDS])
        short = lambda value: value if isinstance(value, str) else f"{value:.6g}"
        write_csv(name, columns, ([short(row.get(column, "")) for column in columns] for row in rows))

    def max_threads(self):
        return max((int(row["threads"]) for row in self.rows if row["kind"] == "threads"), default=1)

    def machine(self, threads="one thread"):
        c = self.context
        return (
            f"{cpu_model()}, {c['num_cpus']} cores, {c['maxlogdet_isa']}, {c['maxlogdet_compiler']}, {threads}, "
            f"maxlogdet {c['maxlogdet_version']}, {c['date'][:10]}, load {c['load_avg'][0]:.1f}; `bench/run`."
        )


def write_csv(name, header, rows):
    """A record beside the scripts: all that was measured, of which the pages have a part."""
    path = ROOT / "bench/results" / name
    path.parent.mkdir(exist_ok=True)
    with open(path, "w", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows([header, *rows])
    print(f"wrote {path.relative_to(ROOT)}")


def record_run(tables, line):
    """Where, how and when the tables of a page were measured, in bench/results/runs.csv: a line a table."""
    path = ROOT / "bench/results/runs.csv"
    rows = dict(csv.reader(path.read_text().splitlines()[1:])) if path.is_file() else {}
    rows.update((name, line) for name in tables)
    write_csv("runs.csv", ["table", "run"], sorted(rows.items()))


def fields_of(name):
    """KIND/METHOD/KEY:VALUE/... as selection_benchmark.cpp writes it."""
    parts = name.split("/")
    fields = dict(part.split(":", 1) for part in parts if ":" in part)
    words = [part for part in parts if ":" not in part]
    return {"kind": words[0], "method": words[1].removesuffix("manual_time"), **fields}


def cpu_model():
    for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return platform.machine()


def label_of(method, epsilon=None):
    text = EIGEN.get(method, method)
    return f"{text}, ε = {epsilon}" if epsilon is not None else text


def ratio(slow, fast):
    if slow is None or fast is None:
        return math.nan
    return slow["median_us"] / fast["median_us"]


def fastest(rows):
    rows = [row for row in rows if row is not None]
    return min(rows, key=lambda row: row["median_us"]) if rows else None


def us(row, counter="median_us"):
    """A time with three digits or so."""
    if row is None:
        return "–"
    value = row[counter]
    return f"{value:.0f}" if value >= 1000 else f"{value:.1f}"


def nats(row):
    return "–" if row is None else f"{round(row['delta_nats'], 4) + 0.0:.4f}"  # no -0.0000


def times(value):
    return "–" if math.isnan(value) else f"{value:.0f}" if value >= 10 else f"{value:.1f}"
