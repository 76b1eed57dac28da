# SPDX-License-Identifier: MIT
import zlib

import numpy as np
import pytest


@pytest.fixture
def rng(request):
    """A random generator whose seed derives from the test's name; pytest shows the seed if the test fails."""
    seed = zlib.crc32(request.node.name.encode())
    print(f"seed of {request.node.name}: {seed}")
    return np.random.default_rng(seed)
