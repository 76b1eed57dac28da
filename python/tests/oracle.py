# SPDX-License-Identifier: MIT
"""The reference selection, in plain NumPy and float64, without regard to speed."""
import numpy as np

DEFAULT_PRIOR = 1e-5 * np.eye(6)


def log_det(matrix):
    return np.linalg.slogdet(matrix)[1]


def stored(blocks):
    """(n, r, 6), rounded as in a store."""
    return np.asarray(blocks, np.float32).astype(np.float64)


def information(blocks, indices, prior=DEFAULT_PRIOR):
    chosen = stored(blocks)[np.asarray(indices, int)]
    return prior + np.einsum("nri,nrj->ij", chosen, chosen)


def check_greedy(blocks, indices, prior=DEFAULT_PRIOR, allowed=None, tolerance=1e-6):
    """Checks that each index has the highest gain after those before it; returns how many were clear winners."""
    blocks = stored(blocks)
    free = np.ones(len(blocks), bool) if allowed is None else np.array(allowed)
    matrix = prior.copy()
    clear = 0
    for position, chosen in enumerate(indices):
        assert free[chosen], f"{chosen} at position {position} was not free"
        gains = log_det(matrix + np.einsum("nri,nrj->nij", blocks, blocks)) - log_det(matrix)
        gains[~free] = -np.inf
        best = int(np.argmax(gains))
        assert gains[chosen] >= gains[best] - tolerance, f"position {position}: {best} adds more than {chosen}"
        others = np.delete(gains, best)
        if gains[best] > others.max(initial=-np.inf) + tolerance:
            clear += 1
            assert chosen == best, f"position {position}"
        free[chosen] = False
        matrix += blocks[chosen].T @ blocks[chosen]
    return clear


def pinhole_blocks(rng, n, rows=2):
    """Blocks in pixels: translation and rotation columns differ in scale as in a tracker."""
    z = rng.uniform(2, 30, n)
    x, y = rng.uniform(-0.8, 0.8, (2, n))
    zero, one, d = np.zeros(n), np.ones(n), 1 / z
    u = np.stack([d, zero, -x * d, -x * y, one + x * x, -y], axis=1)
    v = np.stack([zero, d, -y * d, -(one + y * y), x * y, x], axis=1)
    right = u - np.stack([zero, zero, 0.1 * d * d, 0.1 * y * d, -0.1 * x * d, zero], axis=1)
    return 458 * np.stack([u, v, right][:rows], axis=1)
