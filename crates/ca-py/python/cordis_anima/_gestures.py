"""What drives a scene: curves by name, and files of them."""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping
from typing import Any, Union

import numpy as np
import numpy.typing as npt

from . import _core
from ._errors import UsageError
from ._results import number, reals

Path = Union[str, "os.PathLike[str]"]
#: what drives one port or live parameter: a number that stays; breakpoints (n, 2) of time [s] and value; samples (n,) at
#: the sound rate; samples and their rate [Hz]; a file with one track; an array in a file, and its rate [Hz]
Curve = Union[float, npt.ArrayLike, "tuple[npt.ArrayLike, float]", Path, "tuple[Path, float]"]
#: curves by what they drive, or a file whose tracks are called by it; or one that was made before
Gesture = Union[Mapping[str, Curve], str, "os.PathLike[str]", _core.Gesture, None]


def made(scene: _core.Scene, gesture: Gesture) -> _core.Gesture | None:
    """A gesture as the engine takes it.

    Raises:
        UsageError: values or a shape that make no sense.
        FileError: a file that cannot be read.
    """
    if gesture is None or isinstance(gesture, _core.Gesture):
        return gesture
    if isinstance(gesture, (str, os.PathLike)):
        return _file(scene, gesture, None, None)
    if not isinstance(gesture, Mapping):
        raise UsageError("a gesture is a file, or names of ports with what drives them")
    files: list[_core.Gesture] = []
    tracks: list[tuple[str, Any]] = []
    for name, curve in gesture.items():
        if isinstance(curve, (str, os.PathLike)):
            files.append(_file(scene, curve, name, None))
        elif isinstance(curve, tuple) and len(curve) == 2 and isinstance(curve[0], (str, os.PathLike)):
            files.append(_file(scene, curve[0], name, number(f"rate of `{name}`", curve[1], "Hz")))
        elif isinstance(curve, tuple) and len(curve) == 2 and _ndim(curve[0]) == 1 and _ndim(curve[1]) == 0:
            tracks.append((name, (number(f"rate of `{name}`", curve[1], "Hz"), reals(name, curve[0], dense=True))))
        else:
            values = reals(name, curve)
            if values.ndim == 0:
                tracks.append((name, float(values)))
            elif values.ndim == 1:
                tracks.append((name, (float(scene.about()["rate"]), values)))
            elif values.ndim == 2 and values.shape[1] == 2:
                tracks.append((name, values))
            else:
                raise UsageError(f"gesture `{name}` has the shape {values.shape}: (n,) samples, or (n, 2) times and values")
    return _core.Gesture.together([_core.Gesture(tracks), *files]) if files else _core.Gesture(tracks)


def _file(scene: _core.Scene, path: Path, port: str | None, rate: float | None) -> _core.Gesture:
    """A gesture from a file; notes that move no port are a warning."""
    gesture = scene.gesture(os.fspath(path), port, rate)
    if gesture.unheard is not None:
        warnings.warn(f"`{os.fspath(path)}`: {gesture.unheard}", stacklevel=4)
    return gesture


def _ndim(given: object) -> int | None:
    """Dimensions of an array; none where its rows are of several lengths."""
    try:
        return np.ndim(given)  # type: ignore[arg-type]
    except ValueError:
        return None
