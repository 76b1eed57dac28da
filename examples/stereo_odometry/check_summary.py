#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Checks the accuracy in a summary.json of the stereo odometry: prints a line of figures, or the failures and exits
with 1.

Usage: check_summary.py SUMMARY.json TRAJECTORIES    TRAJECTORIES: how many are the same with one thread and with two
"""

import sys

from maxlogdet_tools.files import json_of

SELECTORS = {"quality", "bucket", "observability", "md", "quality_md", "random", "leverage", "half_random", "md_cells",
             "md_keyframes", "shared_cells", "shared_keyframes", "inl", "all", "all_weighted", "active"}  # fmt: skip

results = {entry["selector"]: entry for entry in json_of(sys.argv[1])}
same = int(sys.argv[2])
md, inl = results["md"], results["inl"]
share = {key: md[key] / inl[key] for key in ("rpe_m_per_s", "roe_deg_per_s")}
failures = []
if set(results) != SELECTORS or same != len(SELECTORS):
    failures.append(f"expected {len(SELECTORS)} selectors and trajectories, found {sorted(results)} and {same}")
failures += [f"{name} tracks {e['tracked_percent']:.0f} % of frames" for name, e in results.items()
             if e["tracked_percent"] < 99.999]  # fmt: skip
failures += [f"md has {value:.3f} times the {key} of inl, expected at most 1.05" for key, value in share.items()
             if not value <= 1.05]  # fmt: skip
failures += [f"md's {key} is {md[key]:.4f}, that of {rival} {results[rival][key]:.4f}"
             for rival in ("random", "quality") for key in share if not md[key] < results[rival][key]]  # fmt: skip
if failures:
    sys.exit("\n".join(failures))
print(f"all frames tracked, {same} trajectories the same with 1 and 2 threads; md has "
      f"{share['rpe_m_per_s']:.2f} x inl's RPE, {share['roe_deg_per_s']:.2f} x its ROE")  # fmt: skip
