# SPDX-License-Identifier: MIT
"""What tracker_benchmark.cpp measured: its cases, and the ratios that pages and pictures show."""

from results import ratio

KINDS = {
    "2_rows_measurement": "monocular",
    "3_rows_measurement": "stereo",
    "3_rows_measurement_and_map": "stereo with covariances",
}
MONOCULAR, STEREO, STEREO_MAP = KINDS
SIZES = ["200", "350", "465", "500", "1000", "2000"]
CACHES = ["hot", "cold"]
OPTIONAL = ["slots", "prior"]  # keys that only some cases have


def find(results, method, blocks, n="465", caches="hot", k="100", isa=None, **more):
    """A row; None if it was not measured."""
    wanted = {"kind": "tracker", "method": method, "blocks": blocks, "n": n, "caches": caches, "k": k}
    wanted["isa"] = "native" if method.startswith("eigen_") else isa or results.widest
    wanted.update({key: more.get(key) for key in OPTIONAL})
    return results.find_row(**wanted)


def isas(results):
    """The widest instruction set, and avx2 unless that is it."""
    has_avx2 = any(row["kind"] == "tracker" and row["isa"] == "avx2" for row in results.rows)
    return [results.widest] + (["avx2"] if has_avx2 and results.widest != "avx2" else [])


def times_eigen(results, blocks, n, caches, k="100", isa=None):
    """The time of Eigen's lazy greedy on given blocks, relative to our blocks and selection together."""
    ours = find(results, "blocks_and_select", blocks, n, caches, k, isa)
    return ratio(find(results, "eigen_lazy_scan", blocks, n, caches, k), ours)


def times_dense(results, method, blocks, n, slots, caches, isa=None):
    """The time with matches that are not usable, relative to that without them."""
    full = find(results, method, blocks, n, caches, isa=isa, slots=slots)
    return ratio(full, find(results, method, blocks, n, caches, isa=isa, slots=n))
