# SPDX-License-Identifier: MIT
from dataclasses import dataclass
from os import PathLike
from typing import Dict, Iterator, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

__version__: str
strategies: Tuple[str, ...]
errors: Dict[str, str]
warnings: Dict[str, str]

def isa() -> str: ...

class SelectionError(ValueError):
    error: str  # a key of `errors`
    def __init__(self, error: str) -> None: ...

class Camera:
    def __init__(
        self,
        fx: float,
        fy: float,
        cx: float,
        cy: float,
        bf: float = 0.0,
        *,
        cx_right: Optional[float] = None,
        model: str = 'pinhole',
        parameters: ArrayLike = (),
        T_cb: Optional[ArrayLike] = None,
    ) -> None: ...

@dataclass(frozen=True, eq=False)
class Selection:
    indices: NDArray[np.intp]
    gains: NDArray[np.float64]
    status: str
    error: str
    warning: str
    reason: str
    log_det: float
    upper_bound: float
    certified_efficiency: float
    efficiency: float
    searched: int
    evaluations: int
    invalid_candidates: int
    def __len__(self) -> int: ...
    def __iter__(self) -> Iterator[int]: ...

class GoodFeatures:
    spread: float
    rejects_outliers: bool
    map_sigma: float
    depth_sigma: float
    def __init__(self, capacity: int) -> None: ...
    def start(self, camera: Union[Camera, Sequence[Camera]], T_cw: ArrayLike) -> None: ...
    def add(
        self,
        points: ArrayLike,
        pixels: Optional[ArrayLike] = None,
        *,
        sigmas: Optional[ArrayLike] = None,
        u_right: Optional[ArrayLike] = None,
        depth: Optional[ArrayLike] = None,
        covariances: Optional[ArrayLike] = None,
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
        strategy: str = 'lazy_greedy',
        epsilon: float = 0.1,
        seed: int = 0,
        time_limit: float = 0.0,
        groups: Optional[ArrayLike] = None,
        maximum: int = 1,
        target_efficiency: float = 0.0,
        certificate: bool = False,
    ) -> Selection: ...
    def align(self, prior: Optional[ArrayLike] = None) -> Dict[str, Union[str, int, float]]: ...
    @property
    def pose(self) -> NDArray[np.float64]: ...
    @property
    def pose_information(self) -> NDArray[np.float64]: ...
    @property
    def is_inlier(self) -> NDArray[np.bool_]: ...
    @property
    def alignment(self) -> Dict[str, Union[str, int, float]]: ...
    def outliers(self, T_cw: ArrayLike) -> NDArray[np.intp]: ...
    def chi2(self) -> NDArray[np.float64]: ...
    def efficiency(self) -> float: ...
    def record(self, folder: Union[str, bytes, PathLike[str], PathLike[bytes]]) -> bool: ...
    @property
    def block_report(self) -> Dict[str, Union[str, int]]: ...
    @property
    def reason(self) -> str: ...
    @property
    def size(self) -> int: ...

def select_blocks(
    blocks: ArrayLike,
    budget: int = 200,
    *,
    required: Optional[ArrayLike] = None,
    prior: Optional[ArrayLike] = None,
    strategy: str = 'lazy_greedy',
    epsilon: float = 0.1,
    seed: int = 0,
    time_limit: float = 0.0,
    groups: Optional[ArrayLike] = None,
    maximum: int = 1,
    target_efficiency: float = 0.0,
    certificate: bool = False,
) -> Selection: ...
