"""The string as loops, compiled by numba."""

from __future__ import annotations

import numba
import numpy as np


@numba.njit
def play(n: int, push: np.ndarray) -> np.ndarray:
    """Returns the positions of masses 3 and 19."""
    x, d, f = np.zeros(26), np.zeros(26), np.zeros(26)
    out = np.zeros((n, 2))
    for t in range(n):
        for i in range(26):
            f[i] = -1e-4 * d[i]
        f[6] += push[t]
        for i in range(25):
            force = 0.25 * (x[i + 1] - x[i]) + 2e-3 * (d[i + 1] - d[i])
            f[i] += force
            f[i + 1] -= force
        out[t, 0] = x[4]
        out[t, 1] = x[20]
        for i in range(1, 25):
            d[i] += f[i]
            x[i] += d[i]
    return out
