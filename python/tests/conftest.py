# SPDX-License-Identifier: MIT
import zlib

import numpy as np
import pytest


@pytest.fixture
def rng(request):
    """Random numbers of the test's own; pytest shows what is printed when the test fails."""
    seed = zlib.crc32(request.node.name.encode())
    print(f"seed of {request.node.name}: {seed}")
    return np.random.default_rng(seed)
