"""Derivatives of modes by parameters.

They are derivatives of the poles of the tick itself. With M, N, K and Z of `Scene.linear`, a mode solves

    Q(w) φ = ((M / T² + N) (w − 1)² + K w + Z (w − 1) / T) φ = 0,

whose matrices are symmetric, so that dw = − φᵀ dQ φ / φᵀ Q'(w) φ (docs/numerics.md §9). This also holds for coupled
damping, where φ is complex. The derivatives of the matrices are eighth-order differences, as in `tangents`. Coinciding
poles give NaN.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from importlib import import_module
from typing import Any

import numpy as np
import numpy.typing as npt

from .._errors import UsageError
from .linear import Linear
from .._results import Floats, ModeDerivatives

#: weights of the matrices at 1, 2, … steps, minus those at −1, −2, …: of eighth and of sixth order
_EIGHTH = (4 / 5, -1 / 5, 4 / 105, -1 / 280)
_SIXTH = (3 / 4, -3 / 20, 1 / 60, 0.0)
#: steps relative to the value
_STEPS = (1e-2, 1e-3, 1e-4)
#: largest difference of both orders, relative to the change
_ASKED = 1e-7
#: poles nearer than this, relative to their distance from 1, coincide
_SAME = 1e-6

Complex = npt.NDArray[np.complex128]


def derivatives(
    part: Linear,
    modes: tuple[Floats, Floats, Floats],
    parameters: Sequence[tuple[str, float, str]],
    moved: Callable[[str, float, str], Linear],
) -> ModeDerivatives:
    """Derivatives of the modes given by ``heard``, ``t60`` and ``shapes``. `moved` returns the linear part for another
    value of a parameter.

    Raises:
        UsageError: if part of the scene has another scheme, or changes discontinuously.
    """
    if part.other_scheme is not None:
        raise UsageError(f"a part of this scene has `{part.other_scheme}`; its modes cannot be differentiated")
    changes = [_change(part, p, moved) for p in parameters]
    heard, t60, shapes = modes
    poles, vectors = _poles(part, heard, t60, shapes)
    T = part.T
    own = _matrices(part)
    of_w = np.full((len(heard), len(parameters)), np.nan + 0j)
    for j, (w, v) in enumerate(zip(poles, vectors)):
        if np.isnan(w):
            continue
        slope = v @ (own[0] @ v) * 2 * (w - 1) + v @ (own[1] @ v) + v @ (own[2] @ v)
        for k, (dA, dK, dZ) in enumerate(changes):
            of_w[j, k] = -(v @ (dA @ v) * (w - 1) ** 2 + v @ (dK @ v) * w + v @ (dZ @ v) * (w - 1)) / slope
    with np.errstate(invalid="ignore"):
        relative = of_w / poles[:, None]
    decay = -np.log(np.abs(poles)) / T
    with np.errstate(invalid="ignore", divide="ignore"):
        falls = np.where(np.isfinite(t60)[:, None], 3 * np.log(10) / decay[:, None] ** 2 * relative.real / T, 0.0)
    falls[np.isnan(relative.real)] = np.nan
    names, values, units = zip(*parameters)
    return ModeDerivatives(relative.imag / (2 * np.pi * T), falls, names, np.array(values, float), units)


def _matrices(part: Linear) -> tuple[Any, Any, Any]:
    """M / T² + N, K and Z / T."""
    return part.M / part.T**2 + part.N, part.K, part.Z / part.T


def _change(
    part: Linear, parameter: tuple[str, float, str], moved: Callable[[str, float, str], Linear]
) -> tuple[Any, Any, Any]:
    """Derivatives of the three matrices."""
    name, value, unit = parameter
    for step in _STEPS:
        h = step * (abs(value) or 1e-3)
        high: list[Any] = [0.0, 0.0, 0.0]
        low: list[Any] = [0.0, 0.0, 0.0]
        for i, (a, b) in enumerate(zip(_EIGHTH, _SIXTH), 1):
            up, down = moved(name, value + i * h, unit), moved(name, value - i * h, unit)
            if up.places != part.places or down.places != part.places:
                raise UsageError(f"no derivative by `{name}`: it changes the structure of the scene, not only its numbers")
            for m, (u, d) in enumerate(zip(_matrices(up), _matrices(down))):
                high[m], low[m] = high[m] + (u - d) * (a / h), low[m] + (u - d) * (b / h)
        sizes = [(abs(x).max(), abs(x - y).max()) for x, y in zip(high, low)]
        # a change below this is rounding
        floors = [1e-13 * abs(m).max() / h for m in _matrices(part)]
        if all(off <= _ASKED * size + floor for (size, off), floor in zip(sizes, floors)):
            return high[0], high[1], high[2]
    raise UsageError(f"no derivative by `{name}` at its value: the linear part has a corner or a jump there")


def _poles(part: Linear, heard: Floats, t60: Floats, shapes: Floats) -> tuple[Complex, Complex]:
    """Poles and their vectors, NaN if a mode does not oscillate or shares its pole."""
    solve: Any = import_module("scipy.sparse.linalg").splu
    A, K, Z = _matrices(part)
    poles = np.full(len(heard), np.nan + 0j)
    vectors = shapes.astype(complex)
    for j in np.flatnonzero(heard > 0):
        w = np.exp((2j * np.pi * heard[j] - 3 * np.log(10) / t60[j]) * part.T)
        v = vectors[j] / np.linalg.norm(vectors[j])
        for _ in range(8):
            q = (A * (w - 1) ** 2 + K * w + Z * (w - 1)).tocsc()
            try:
                u = solve(q).solve((A * (2 * (w - 1)) + K + Z) @ v)
            except RuntimeError:  # singular: exactly at the pole
                break
            step = (v.conj() @ v) / (v.conj() @ u)
            w, v = w - step, u / np.linalg.norm(u)
            if abs(step) <= 1e-15:
                break
        poles[j], vectors[j] = w, v
    near = np.abs(poles[:, None] - poles[None, :]) <= _SAME * np.abs(poles[:, None] - 1)
    np.fill_diagonal(near, False)
    poles[near.any(axis=1)] = np.nan
    return poles, vectors
