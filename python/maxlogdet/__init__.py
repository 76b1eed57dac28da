# SPDX-License-Identifier: MIT
"""Picks the k feature matches that keep a camera-pose least-squares problem best conditioned.

    maximise  log det(prior + sum over i in S of H_i^T H_i)   over  |S| = k

Y. Zhao, P. A. Vela: Good Feature Selection for Least Squares Pose Optimization in VO/VSLAM, IROS 2018.
"""
from ._core import (ActiveSelection, BlockReport, BlockStore, Camera, GoodFeatures, PinholeCamera, Selection,
                    SelectionError, Selector, __version__, camera_models, errors, has_tbb, isa, isas,
                    match_information, match_whitening, select, select_blocks, strategies)

__all__ = ["ActiveSelection", "BlockReport", "BlockStore", "Camera", "GoodFeatures", "PinholeCamera", "Selection",
           "SelectionError", "Selector", "camera_models", "errors", "has_tbb", "isa", "isas", "match_information",
           "match_whitening", "select", "select_blocks", "strategies"]

for _public in (ActiveSelection, BlockReport, BlockStore, Camera, GoodFeatures, PinholeCamera, Selection, Selector):
    _public.__module__ = __name__  # where they are imported from
del _public
