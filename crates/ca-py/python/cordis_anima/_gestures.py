"""Gestures: curves by name of the port or parameter they drive, and gesture files."""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Union

import numpy as np
import numpy.typing as npt

from . import _core
from ._errors import UsageError
from ._results import Floats, number, reals

Path = Union[str, "os.PathLike[str]"]


@dataclass(frozen=True, eq=False, repr=False)
class Points:
    """Breakpoints as two arrays, with linear interpolation between them.

    >>> import cordis_anima as ca, numpy as np
    >>> t = np.linspace(0, 0.1, 50)
    >>> key = ca.load("hammered_string")
    >>> key.render(0.2, gesture={"key": ca.Points(t, -0.008 * np.cos(30 * t))}).status
    'ok'
    """

    #: times (n,) [s], non-decreasing
    times: npt.ArrayLike
    #: values (n,), in the unit of the port or parameter
    values: npt.ArrayLike

    def __repr__(self) -> str:
        return f"<Points: {np.size(self.times)} values>"


#: drives one port or live parameter: a constant number; breakpoints, as a list of (time [s], value) pairs or as
#: `Points`; samples (n,) at the sound rate; samples and their rate [Hz]; a file with one track; an array file and its
#: rate [Hz]
Curve = Union[float, npt.ArrayLike, Points, "tuple[npt.ArrayLike, float]", Path, "tuple[Path, float]"]
#: curves by name of what they drive; a file whose tracks have these names; or a compiled gesture
Gesture = Union[Mapping[str, Curve], str, "os.PathLike[str]", _core.Gesture, None]


def made(scene: _core.Scene, gesture: Gesture) -> _core.Gesture | None:
    """Converts a gesture to the engine's form.

    Raises:
        UsageError: if values or shapes are invalid.
        FileError: if a file cannot be read.
    """
    if gesture is None or isinstance(gesture, _core.Gesture):
        return gesture
    if isinstance(gesture, (str, os.PathLike)):
        return _file(scene, gesture, None, None)
    if not isinstance(gesture, Mapping):
        raise UsageError("a gesture must be a file, or a mapping from names of ports to curves")
    files: list[_core.Gesture] = []
    tracks: list[tuple[str, Any]] = []
    for name, curve in gesture.items():
        if isinstance(curve, (str, os.PathLike)):
            files.append(_file(scene, curve, name, None))
        elif isinstance(curve, tuple) and len(curve) == 2 and isinstance(curve[0], (str, os.PathLike)):
            files.append(_file(scene, curve[0], name, number(f"rate of `{name}`", curve[1], "Hz")))
        elif isinstance(curve, tuple) and len(curve) == 2 and _ndim(curve[0]) == 1 and _ndim(curve[1]) == 0:
            tracks.append((name, (number(f"rate of `{name}`", curve[1], "Hz"), reals(name, curve[0], dense=True))))
        elif isinstance(curve, Points):
            tracks.append((name, _joined(name, curve)))
        else:
            values = reals(name, curve)
            if values.ndim == 0:
                tracks.append((name, float(values)))
            elif values.ndim == 1:
                tracks.append((name, (float(scene.about()["rate"]), values)))
            elif values.ndim == 2 and values.shape[1] == 2 and isinstance(curve, (list, tuple)):
                tracks.append((name, values))
            else:
                raise UsageError(f"gesture `{name}` {_no_curve(values)}")
    return _core.Gesture.together([_core.Gesture(tracks), *files]) if files else _core.Gesture(tracks)


def _joined(name: str, points: Points) -> Floats:
    times, values = reals(f"times of {name}", points.times), reals(f"values of {name}", points.values)
    if times.ndim != 1 or times.shape != values.shape:
        raise UsageError(f"`Points` of `{name}` have times {times.shape} and values {values.shape}; both must be (n,)")
    return np.ascontiguousarray(np.stack([times, values], axis=1))


def _no_curve(values: Floats) -> str:
    """Explains why an array is not a curve. Two columns may be times and values, or two channels of a sound."""
    if values.ndim == 2 and values.shape[1] == 2:
        return (
            f"is an array {values.shape}, which may be breakpoints or two channels: write `Points(a[:, 0], a[:, 1])` for times "
            "and values, `a[:, 0]` for samples of one channel"
        )
    if values.ndim == 2 and 1 in values.shape:
        return f"has the shape {values.shape}; samples must have the shape (n,), e.g. `a.ravel()`"
    return f"has the shape {values.shape}; use samples (n,), or breakpoints as a list of pairs or `Points`"


def _file(scene: _core.Scene, path: Path, port: str | None, rate: float | None) -> _core.Gesture:
    """Reads a gesture from a file; remarks on the file become warnings."""
    gesture = scene.gesture(os.fspath(path), port, rate)
    for remark in gesture.remarks:
        warnings.warn(f"`{os.fspath(path)}`: {remark}", stacklevel=4)
    return gesture


def _ndim(given: object) -> int | None:
    """Number of dimensions of an array; ``None`` if its rows differ in length."""
    try:
        return np.ndim(given)  # type: ignore[arg-type]
    except ValueError:
        return None
