# SPDX-License-Identifier: MIT
from os import PathLike
from types import TracebackType
from typing import Any, Callable, Dict, Iterator, Literal, Optional, Sequence, Tuple, Type, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

_Blocks = Union[ArrayLike, Sequence[Optional[ArrayLike]]]
_Strategy = str  # one of `strategies`
_Status = Literal["ok", "all_selected", "target_reached", "deadline_reached", "few_candidates", "error"]
_Error = str  # a key of `errors`
_Weighting = Literal["map_bias", "map_bias_world", "measurement", "measurement_and_map"]
_DepthCue = Literal["none", "stereo", "depth"]

__version__: str
has_tbb: bool
strategies: Tuple[str, ...]
camera_models: Tuple[str, ...]
isas: Tuple[str, ...]
errors: Dict[str, str]

def isa() -> str: ...

class SelectionError(ValueError):
    error: _Error

class PinholeCamera:
    fx: float
    fy: float
    cx: float
    cy: float
    bf: float
    def __init__(self, fx: float, fy: float, cx: float = 0.0, cy: float = 0.0, bf: float = 0.0) -> None: ...

class Camera:
    def __init__(self, pinhole: PinholeCamera) -> None: ...
    @staticmethod
    def radial_tangential(
        pinhole: PinholeCamera, k1: float, k2: float, p1: float, p2: float, k3: float = 0.0
    ) -> Camera: ...
    @staticmethod
    def kannala_brandt(pinhole: PinholeCamera, k1: float, k2: float, k3: float, k4: float) -> Camera: ...
    @staticmethod
    def double_sphere(pinhole: PinholeCamera, xi: float, alpha: float) -> Camera: ...
    @staticmethod
    def of_model(model: str, pinhole: PinholeCamera, parameters: Sequence[float]) -> Camera: ...
    @property
    def model(self) -> str: ...
    @property
    def pinhole(self) -> PinholeCamera: ...
    @property
    def parameters(self) -> Tuple[float, ...]: ...
    def project(self, points: ArrayLike) -> NDArray[np.float64]: ...

_Camera = Union[PinholeCamera, Camera]
_CameraOrRig = Union[_Camera, Sequence[Tuple[_Camera, ArrayLike]]]

class BlockReport:
    @property
    def error(self) -> _Error: ...
    @property
    def appended(self) -> int: ...
    @property
    def invalid(self) -> int: ...
    @property
    def unusable(self) -> int: ...
    @property
    def behind_camera(self) -> int: ...
    @property
    def too_near(self) -> int: ...
    @property
    def singular_rays(self) -> int: ...
    @property
    def invalid_covariances(self) -> int: ...
    @property
    def invalid_jacobians(self) -> int: ...

class BlockStore:
    def __init__(self, blocks: Union[int, _Blocks, None] = None, capacity: int = 0) -> None: ...
    def append(self, block: Optional[ArrayLike]) -> int: ...
    def extend(self, blocks: _Blocks) -> None: ...
    def append_blocks(
        self,
        camera: _CameraOrRig,
        T_cw: ArrayLike,
        points: ArrayLike,
        *,
        sigmas: Optional[ArrayLike] = None,
        has_depth_cue: Optional[ArrayLike] = None,
        usable: Optional[ArrayLike] = None,
        weights: Optional[ArrayLike] = None,
        map_covariances: Optional[ArrayLike] = None,
        jacobians: Optional[ArrayLike] = None,
        camera_ids: Optional[ArrayLike] = None,
        weighting: Optional[_Weighting] = None,
        depth_cue: _DepthCue = 'none',
        map_sigma: float = 0.05,
        depth_sigma: float = 0.05,
        min_depth: float = 0.01,
        threads: int = 0,
    ) -> BlockReport: ...
    def clear(self) -> None: ...
    def reserve(self, capacity: int) -> None: ...
    def copy(self) -> BlockStore: ...
    def __len__(self) -> int: ...
    @property
    def capacity(self) -> int: ...
    @property
    def rows(self) -> int: ...
    @property
    def invalid_count(self) -> int: ...
    @property
    def stored(self) -> int: ...
    @property
    def planes(self) -> NDArray[np.float32]: ...
    @property
    def indices(self) -> NDArray[np.uint32]: ...
    @property
    def valid(self) -> NDArray[np.bool_]: ...

class Selection:
    @property
    def indices(self) -> NDArray[np.intp]: ...
    @property
    def gains(self) -> NDArray[np.float64]: ...
    @property
    def log_det(self) -> float: ...
    @property
    def upper_bound(self) -> float: ...
    @property
    def certified_efficiency(self) -> float: ...
    @property
    def efficiency(self) -> float: ...
    @property
    def translation_sigma(self) -> float: ...
    @property
    def rotation_sigma(self) -> float: ...
    @property
    def status(self) -> _Status: ...
    @property
    def error(self) -> _Error: ...
    @property
    def reason(self) -> str: ...
    @property
    def searched(self) -> int: ...
    @property
    def strategy(self) -> _Strategy: ...
    @property
    def evaluations(self) -> int: ...
    @property
    def float64_decisions(self) -> int: ...
    @property
    def invalid_candidates(self) -> int: ...
    @property
    def threads(self) -> int: ...
    def __len__(self) -> int: ...
    def __iter__(self) -> Iterator[int]: ...

class GoodFeatures:
    weighting: _Weighting
    map_sigma: float
    depth_sigma: float
    min_depth: float
    spread: float
    is_weighted: bool
    def __init__(self, capacity: int, threads: int = 0) -> None: ...
    def start(self, camera: _CameraOrRig, T_cw: ArrayLike) -> None: ...
    def add(
        self,
        points: ArrayLike,
        measured: Optional[ArrayLike] = None,
        sigmas: Optional[ArrayLike] = None,
        *,
        u_right: Optional[ArrayLike] = None,
        depth: Optional[ArrayLike] = None,
        covariances: Optional[ArrayLike] = None,
        jacobians: Optional[ArrayLike] = None,
        camera_ids: Optional[ArrayLike] = None,
        required: Optional[ArrayLike] = None,
        point_ids: Optional[ArrayLike] = None,
        keyframes: Optional[ArrayLike] = None,
    ) -> None: ...
    def select(
        self,
        budget: int = 200,
        *,
        prior: Optional[ArrayLike] = None,
        time_limit: float = 0.0,
        strategy: _Strategy = 'lazy_greedy',
        threads: Optional[int] = None,
        required: Optional[ArrayLike] = None,
        excluded: Optional[ArrayLike] = None,
        target_efficiency: float = 0.0,
        target_translation_sigma: float = 0.0,
        target_rotation_sigma: float = 0.0,
        groups: Optional[ArrayLike] = None,
        group_maximum: int = 1,
        group_maxima: Optional[ArrayLike] = None,
        certificate: bool = False,
        certificate_passes: int = 0,
        epsilon: float = 0.1,
        seed: int = 0,
        exchange_sweeps: int = 0,
    ) -> Selection: ...
    def match(
        self,
        try_to_match: Callable[[int], Union[None, bool, ArrayLike, Dict[str, Any]]],
        budget: int = 200,
        *,
        prior: Optional[ArrayLike] = None,
        time_limit: float = 0.0,
        strategy: Literal["greedy", "lazy_greedy", "automatic"] = 'lazy_greedy',
        required: Optional[ArrayLike] = None,
        excluded: Optional[ArrayLike] = None,
        target_efficiency: float = 0.0,
        target_translation_sigma: float = 0.0,
        target_rotation_sigma: float = 0.0,
        groups: Optional[ArrayLike] = None,
        group_maximum: int = 1,
        group_maxima: Optional[ArrayLike] = None,
    ) -> Selection: ...
    def outliers(self, T_cw: ArrayLike) -> NDArray[np.intp]: ...
    def efficiency(self) -> float: ...
    def information(self) -> NDArray[np.float64]: ...
    def whitening(self) -> NDArray[np.float64]: ...
    def blocks(self) -> BlockStore: ...
    def record(self, folder: Union[str, bytes, PathLike[str]]) -> bool: ...
    @property
    def selection(self) -> Selection: ...
    @property
    def reason(self) -> str: ...
    @property
    def block_report(self) -> BlockReport: ...
    @property
    def chi2(self) -> NDArray[np.float64]: ...
    @property
    def capacity(self) -> int: ...
    def __len__(self) -> int: ...

class Selector:
    def __init__(self, capacity: int, threads: int = 0) -> None: ...
    def select(
        self,
        blocks: Union[BlockStore, _Blocks],
        budget: int = 200,
        *,
        prior: Optional[ArrayLike] = None,
        time_limit: float = 0.0,
        strategy: _Strategy = 'lazy_greedy',
        threads: Optional[int] = None,
        required: Optional[ArrayLike] = None,
        excluded: Optional[ArrayLike] = None,
        target_efficiency: float = 0.0,
        target_translation_sigma: float = 0.0,
        target_rotation_sigma: float = 0.0,
        groups: Optional[ArrayLike] = None,
        group_maximum: int = 1,
        group_maxima: Optional[ArrayLike] = None,
        certificate: bool = False,
        certificate_passes: int = 0,
        epsilon: float = 0.1,
        seed: int = 0,
        exchange_sweeps: int = 0,
    ) -> Selection: ...
    @property
    def capacity(self) -> int: ...

class ActiveSelection:
    def __init__(self, capacity: int) -> None: ...
    def start(
        self,
        blocks: Union[BlockStore, _Blocks],
        budget: int = 200,
        *,
        prior: Optional[ArrayLike] = None,
        time_limit: float = 0.0,
        strategy: Literal["greedy", "lazy_greedy", "automatic"] = 'lazy_greedy',
        required: Optional[ArrayLike] = None,
        excluded: Optional[ArrayLike] = None,
        target_efficiency: float = 0.0,
        target_translation_sigma: float = 0.0,
        target_rotation_sigma: float = 0.0,
        groups: Optional[ArrayLike] = None,
        group_maximum: int = 1,
        group_maxima: Optional[ArrayLike] = None,
    ) -> None: ...
    def next(self) -> Optional[int]: ...
    def next_batch(self, count: int) -> NDArray[np.uint32]: ...
    def accept(self, block: Optional[ArrayLike] = None, *, index: Optional[int] = None) -> None: ...
    def reject(self, *, index: Optional[int] = None) -> None: ...
    def answer(self, matched: ArrayLike) -> None: ...
    def selection(self) -> Selection: ...
    def stop(self) -> None: ...
    @property
    def capacity(self) -> int: ...
    def __iter__(self) -> ActiveSelection: ...
    def __next__(self) -> int: ...
    def __enter__(self) -> ActiveSelection: ...
    def __exit__(
        self,
        error_type: Optional[Type[BaseException]],
        error: Optional[BaseException],
        traceback: Optional[TracebackType],
    ) -> None: ...

def select(
    camera: _CameraOrRig,
    T_cw: ArrayLike,
    points: ArrayLike,
    measured: Optional[ArrayLike] = None,
    sigmas: Optional[ArrayLike] = None,
    *,
    u_right: Optional[ArrayLike] = None,
    depth: Optional[ArrayLike] = None,
    covariances: Optional[ArrayLike] = None,
    jacobians: Optional[ArrayLike] = None,
    camera_ids: Optional[ArrayLike] = None,
    weighting: _Weighting = 'measurement',
    map_sigma: float = 0.05,
    depth_sigma: float = 0.05,
    min_depth: float = 0.01,
    budget: int = 200,
    prior: Optional[ArrayLike] = None,
    time_limit: float = 0.0,
    strategy: _Strategy = 'lazy_greedy',
    threads: Optional[int] = None,
    required: Optional[ArrayLike] = None,
    excluded: Optional[ArrayLike] = None,
    target_efficiency: float = 0.0,
    target_translation_sigma: float = 0.0,
    target_rotation_sigma: float = 0.0,
    groups: Optional[ArrayLike] = None,
    group_maximum: int = 1,
    group_maxima: Optional[ArrayLike] = None,
    certificate: bool = False,
    certificate_passes: int = 0,
    epsilon: float = 0.1,
    seed: int = 0,
    exchange_sweeps: int = 0,
) -> Selection: ...

def select_blocks(
    blocks: Union[BlockStore, _Blocks],
    budget: int = 200,
    *,
    prior: Optional[ArrayLike] = None,
    time_limit: float = 0.0,
    strategy: _Strategy = 'lazy_greedy',
    threads: Optional[int] = None,
    required: Optional[ArrayLike] = None,
    excluded: Optional[ArrayLike] = None,
    target_efficiency: float = 0.0,
    target_translation_sigma: float = 0.0,
    target_rotation_sigma: float = 0.0,
    groups: Optional[ArrayLike] = None,
    group_maximum: int = 1,
    group_maxima: Optional[ArrayLike] = None,
    certificate: bool = False,
    certificate_passes: int = 0,
    epsilon: float = 0.1,
    seed: int = 0,
    exchange_sweeps: int = 0,
) -> Selection: ...

def match_information(
    camera: _CameraOrRig,
    T_cw: ArrayLike,
    points: ArrayLike,
    *,
    sigmas: Optional[ArrayLike] = None,
    has_depth_cue: Optional[ArrayLike] = None,
    map_covariances: Optional[ArrayLike] = None,
    jacobians: Optional[ArrayLike] = None,
    camera_ids: Optional[ArrayLike] = None,
    weighting: Optional[_Weighting] = None,
    depth_cue: _DepthCue = 'none',
    map_sigma: float = 0.05,
    depth_sigma: float = 0.05,
) -> NDArray[np.float64]: ...

match_whitening = match_information
