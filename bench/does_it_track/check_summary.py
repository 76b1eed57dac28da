#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Checks what the stereo odometry has written: prints a line of figures, or the failures and exits with 1.

Usage: check_summary.py OUTPUT TRAJECTORIES    TRAJECTORIES: how many are the same with one thread and with two
"""

import pathlib
import sys

from maxlogdet_tools.files import json_of

SELECTORS = {"md", "active", "active_random", "random", "inl", "all"}
LENGTHS = ("translation_mm", "rotation_mrad")

output = pathlib.Path(sys.argv[1])
same = int(sys.argv[2])
runs = {entry["selector"]: entry for entry in json_of(output / "summary.json")}
frames = json_of(output / "same_frame.json")
at_30 = {entry["selector"]: entry for entry in frames["selectors"] if entry["budget"] == 30}
deviation = {name: [entry[key]["median"] for key in LENGTHS] for name, entry in at_30.items()}
failures = []
if set(runs) != SELECTORS or same != len(SELECTORS):
    failures.append(f"expected {len(SELECTORS)} selectors and trajectories, found {sorted(runs)} and {same}")
failures += [f"{name} tracks {e['tracked_percent']:.0f} % of frames" for name, e in runs.items()
             if e["tracked_percent"] < 99.999]  # fmt: skip
if frames["frames_unusable"] > 0:
    failures.append(f"{frames['frames_unusable']} frames have no pose of all inliers")
failures += [f"{key} of 30 by md is {ours:.3f}, by {rival} {theirs:.3f}" for rival in ("random", "quality")
             for key, ours, theirs in zip(LENGTHS, deviation["md"], deviation[rival]) if not ours < theirs]  # fmt: skip
if failures:
    sys.exit("\n".join(failures))
shares = [ours / theirs for ours, theirs in zip(deviation["md"], deviation["random"])]
print(f"all frames tracked, {same} trajectories and the comparison on the same frames the same with 1 and 2 threads; 30 "
      f"by md deviate by {shares[0]:.2f} / {shares[1]:.2f} of what 30 random ones do")  # fmt: skip
