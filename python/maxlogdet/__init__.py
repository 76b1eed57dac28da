# SPDX-License-Identifier: MIT
"""Picks the k feature matches that keep a camera-pose least-squares problem best conditioned.

    maximise  log det(prior + sum over i in S of H_i^T H_i)   over  |S| = k

Y. Zhao, P. A. Vela: Good Feature Selection for Least Squares Pose Optimization in VO/VSLAM, IROS 2018.
"""
import dataclasses as _dataclasses

import numpy as _numpy

from ._core import Camera, GoodFeatures, __version__, errors, isa, select_blocks, strategies, warnings

__all__ = ["Camera", "GoodFeatures", "Selection", "SelectionError", "errors", "isa", "select_blocks", "strategies", "warnings"]


@_dataclasses.dataclass(frozen=True, eq=False)
class Selection:
    """The answer. len() is how many are selected; iteration gives their indices. What was not asked for is NaN."""

    indices: _numpy.ndarray  # (k,): required ones, then in order of selection
    gains: _numpy.ndarray  # (k,): the increase of log det by each after those before it, nats; NaN where it is unknown
    status: str  # 'ok', 'all_selected', 'target_reached', 'deadline_reached', 'few_candidates' or 'error'
    error: str  # a key of `errors`; 'none' unless status is 'error'
    warning: str  # a key of `warnings`: what is suspicious of the frame
    reason: str  # for a log: the error, or the warning, or the status
    log_det: float  # log det(prior + sum of selected H^T H), nats
    upper_bound: float  # no selection that the options allow has a greater log det
    certified_efficiency: float  # (det M / det of the bound)^(1/6)
    efficiency: float  # (det M / det M_all)^(1/6): what is reached of target_efficiency
    searched: int  # how many, the first ones, the search itself selected; the rest fill the budget
    evaluations: int  # gains computed; may differ between machines
    invalid_candidates: int  # those without a block

    def __len__(self):
        return len(self.indices)

    def __iter__(self):
        return iter(self.indices.tolist())

    def __repr__(self):
        return f"<maxlogdet.Selection: {self.reason}, {len(self)} selected, log_det {self.log_det:.6g}>"


class SelectionError(ValueError):
    """The library refused the request; `error` is a key of `errors`."""

    def __init__(self, error):
        super().__init__(error)
        self.error = error

    def __str__(self):
        return f"{self.error}: {errors.get(self.error, 'unknown')}"


for _public in (Camera, GoodFeatures):
    _public.__module__ = __name__  # where they are imported from
del _public
