# SPDX-License-Identifier: MIT
"""What tracker_benchmark.cpp measured: its cases, and their targets."""

import math

from results import EIGEN, ratio

KINDS = {
    "2_rows_measurement": "monocular",
    "3_rows_measurement": "stereo",
    "3_rows_measurement_and_map": "stereo with covariances",
}
MONOCULAR, STEREO, STEREO_MAP = KINDS
SIZES = ["200", "350", "465", "500", "1000", "2000"]
CACHES = ["hot", "cold"]
OPTIONAL = ["slots", "prior", "batch", "matched"]  # keys that only some cases have


def find(results, method, blocks, n="465", caches="hot", k="100", isa=None, **more):
    """A row; None if it was not measured."""
    wanted = {"kind": "tracker", "method": method, "blocks": blocks, "n": n, "caches": caches, "k": k}
    wanted["isa"] = "native" if method in EIGEN else isa or results.widest
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


def times_select(results, n, matched, batch="1", isa=None):
    """The time of the loop of an ActiveSelection, relative to one select()."""
    active = find(results, "active", STEREO_MAP, n, isa=isa, batch=batch, matched=matched)
    return ratio(active, find(results, "lazy_greedy", STEREO_MAP, n, isa=isa))


def times_dense(results, method, blocks, n, slots, caches, isa=None):
    """The time with candidates that may not be selected, relative to that without them."""
    full = find(results, method, blocks, n, caches, isa=isa, slots=slots)
    return ratio(full, find(results, method, blocks, n, caches, isa=isa, slots=n))


def targets(results):
    """(case, limits, whether these are lower limits, {instruction set: values})"""
    of_isas = lambda values: {isa: values(isa) for isa in isas(results)}
    frames = [("465", STEREO_MAP, (4, 3)), ("465", MONOCULAR, (6, 4)), ("2000", STEREO_MAP, (4.5, 3.5))]
    for n, blocks, limits in frames:
        case = f"Eigen lazy / *both*, n = {n}, {KINDS[blocks]}"
        eigen = lambda isa: [times_eigen(results, blocks, n, caches, isa=isa) for caches in CACHES]
        yield case, limits, True, of_isas(eigen)
    select = lambda isa: [times_select(results, n, matched, isa=isa)
                          for matched in ("0.5", "0.2") for n in ("800", "3000")]  # fmt: skip
    case = "`ActiveSelection` / *select*: half matched, n = 800, 3000; a fifth matched, n = 800, 3000"
    yield case, [1.2, 1.2, 1.4, 1.4], False, of_isas(select)
    dense = lambda isa: [times_dense(results, "blocks_and_select", blocks, "377", "2005", caches, isa)
                         for blocks in (MONOCULAR, STEREO_MAP) for caches in CACHES]  # fmt: skip
    case = "2005 slots, 377 matched / these alone: monocular hot, cold; stereo with covariances hot, cold"
    yield case, [1.15], False, of_isas(dense)


def p99_by_median(row):
    """p99 / median"""
    return math.nan if row is None else row["p99_us"] / row["median_us"]
