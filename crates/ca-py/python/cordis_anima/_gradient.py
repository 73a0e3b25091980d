"""Derivatives of what a scene sounds by its parameters."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from . import _core
from ._errors import UsageError
from ._results import Floats

#: what a loss gives for a sound (frames, channels): its value, and its derivatives by each sample, of the same shape
Loss = Callable[[Floats], "tuple[float, npt.ArrayLike]"]


@dataclass(frozen=True)
class Tangents:
    """A sound with its derivatives.

    Attributes:
        audio: the sound (frames, channels), in double precision.
        tangents: its derivatives (frames, channels, parameters), per unit of the parameter.
        wrt: names of the parameters.
        values: their values (parameters).
        units: their units, of SI; empty for plain numbers.
        sr: sound rate [Hz].
    """

    audio: Floats
    tangents: Floats
    wrt: tuple[str, ...]
    values: Floats
    units: tuple[str, ...]
    sr: int

    def __getitem__(self, name: str) -> Floats:
        """The derivatives by one parameter (frames, channels)."""
        return self.tangents[:, :, _place(self.wrt, name)]

    def gradient(self, cotangent: npt.ArrayLike) -> Floats:
        """The gradient (parameters) of a loss whose derivatives by the samples are `cotangent` (frames, channels)."""
        found: Floats = np.einsum("fc,fcp->p", _cotangent(cotangent, self.audio.shape), self.tangents)
        return found


@dataclass(frozen=True)
class Gradient:
    """A gradient of a loss.

    Attributes:
        loss: value of the loss; none where its cotangent was given.
        gradient: its derivatives (parameters), per unit of the parameter.
        wrt: names of the parameters.
        values: their values (parameters).
        units: their units, of SI; empty for plain numbers.
    """

    loss: float | None
    gradient: Floats
    wrt: tuple[str, ...]
    values: Floats
    units: tuple[str, ...]

    def __getitem__(self, name: str) -> float:
        """The derivative by one parameter."""
        return float(self.gradient[_place(self.wrt, name)])


def _place(names: Sequence[str], name: str) -> int:
    if name not in names:
        raise UsageError(f"no derivative by `{name}` was asked for, but by {', '.join(f'`{n}`' for n in names)}")
    return names.index(name)


def _cotangent(given: npt.ArrayLike, shape: tuple[int, ...] | None) -> Floats:
    values = np.asarray(given, float)
    if values.ndim == 1:
        values = values[:, np.newaxis]
    if values.ndim != 2 or (shape is not None and values.shape != shape):
        wanted = "(frames, channels)" if shape is None else str(shape)
        raise UsageError(f"the cotangent has the shape {np.shape(given)}: {wanted}")
    return np.ascontiguousarray(values)


def _about(forward: _core.Forward) -> tuple[tuple[str, ...], Floats, tuple[str, ...]]:
    all = forward.parameters
    return tuple(p[0] for p in all), np.array([p[1] for p in all], float), tuple(p[2] for p in all)


def tangents(forward: _core.Forward, seconds: float | None, gesture: _core.Gesture | None, sr: int) -> Tangents:
    audio, all = forward.tangents(seconds, gesture)
    names, values, units = _about(forward)
    return Tangents(audio=audio, tangents=all, wrt=names, values=values, units=units, sr=sr)


def gradient(
    forward: _core.Forward,
    seconds: float | None,
    gesture: _core.Gesture | None,
    cotangent: npt.ArrayLike | None,
    loss: Loss | None,
) -> Gradient:
    value = None
    if loss is not None:
        audio = forward.audio(seconds, gesture)
        value, of = loss(audio)
        given = _cotangent(of, audio.shape)
    elif cotangent is not None:
        given = _cotangent(cotangent, None)
    else:
        raise UsageError("a gradient is that of a `loss`, or goes by a `cotangent`; `tangents` has all derivatives")
    names, values, units = _about(forward)
    found = forward.gradient(given, gesture)
    return Gradient(loss=None if value is None else float(value), gradient=found, wrt=names, values=values, units=units)
