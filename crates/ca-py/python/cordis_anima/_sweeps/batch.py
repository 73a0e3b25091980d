"""Plays one scene many times with given values, into one array.

A batch is one call: values go in as columns, sound comes out as an array over instances. Threads of the engine play
them without the interpreter lock. For random values, measurements, files or other machines, use a `sweep`.
"""

from __future__ import annotations

import itertools
import os
from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from .. import _core
from .._errors import UsageError
from .._gestures import Gesture, made
from .._analysis.measured import Progress
from .._probes import columns
from .._results import DType, Floats, Sound, is_double, length, value, whole
from .._scene import Scene

#: largest number of instances
_MOST = 1_000_000


@dataclass(frozen=True, repr=False, eq=False)
class Batch:
    """Result of a batch: sounds of many instances of a scene.

    >>> import cordis_anima as ca
    >>> b = ca.batch(ca.examples.string(), {"low.f": [110, 165, 220]}, 0.1)
    >>> b, b.audio.shape
    (<Batch: 3 instances over low.f: 3 ok>, (3, 4800, 1))
    """

    #: sound (instances, frames, channels), within ±1
    audio: Sound
    #: sound rate [Hz]
    sr: int
    #: values of the instances, by parameter name
    values: Mapping[str, tuple[Any, ...]]
    #: probes by selector: (instances, frames), or (instances, frames, n) if it chose several
    probes: Mapping[str, Sound]
    #: status of each: ``ok``, ``clipped``, ``unstable``, ``refused``, ``mute``, ``gained`` or ``invalid``, as in a
    #: sweep
    status: npt.NDArray[np.object_]
    #: problem of each instance; empty if none
    message: tuple[str, ...]
    #: time [s] at which each diverged, and the module that caused it
    failed: tuple[tuple[float, str] | None, ...]
    #: largest |sample| of each over all channels before clipping (instances); 1 is full scale
    peak: Floats

    @property
    def ok(self) -> npt.NDArray[np.bool_]:
        """Mask of the instances with status ``ok``."""
        return np.array(self.status == "ok", np.bool_)

    def __len__(self) -> int:
        return len(self.status)

    def __repr__(self) -> str:
        status, n = np.unique(self.status.astype(str), return_counts=True)
        reported = ", ".join(f"{k} {s}" for s, k in zip(status, n))
        return f"<Batch: {len(self)} instances over {', '.join(self.values)}: {reported or 'none'}>"


def batch(
    scene: Scene,
    values: Mapping[str, Sequence[object] | npt.NDArray[Any]],
    seconds: float | str | None = None,
    *,
    gesture: Gesture = None,
    probes: Sequence[str] = (),
    dtype: DType = "float32",
    threads: int | None = None,
    progress: Progress | None = None,
) -> Batch:
    """Plays a scene once for each row of values, on all cores. Every instance has the bits of a separate render.

    An instance that is invalid or diverges is silent (from then on) and has a `status`; the others continue. An
    instance whose numbers of channels or probes differ from the scene's is ``invalid``. All are equally long.

    Args:
        scene: scene to play.
        values: columns by name as for `Scene.replace`; each has the value of every instance.
        seconds: length of each; default: as for the scene itself.
        gesture: as for `Scene.render`, the same for all.
        probes: as for `Scene.render`.
        dtype: ``"float32"`` or ``"float64"``, of sound and probes.
        threads: number of threads; default: one per core.
        progress: called regularly with the numbers of instances done and in total.

    Raises:
        UsageError: if a parameter does not exist, columns differ in length, a value is not a number, text or list, a
            column is ``rate.sound`` or ``model.seconds``, the result does not fit into memory, or an option is invalid.
        ModelError: if the scene itself has errors, or a probe matches no module.

    >>> import cordis_anima as ca, numpy as np
    >>> struck = ca.examples.string()
    >>> b = ca.batch(struck, {"hammer.v": [1.0, 2.0]}, 0.1, dtype="float64")
    >>> bool((b.audio[1] == struck.replace({"hammer.v": 2.0}).render(0.1, dtype="float64").audio).all())
    True
    """
    if not isinstance(values, Mapping):
        raise UsageError("values must be columns by name, e.g. {\"low.f\": [110, 220]}")
    seconds = None if seconds is None else length(seconds)
    threads = (os.cpu_count() or 1) if threads is None else whole("threads", threads, 1, 4096)
    asked = {name: _column(name, given) for name, given in values.items()}
    selectors = [probes] if isinstance(probes, str) else list(probes)
    core = scene._listening(selectors, False)
    driven = made(scene._compiled, gesture)
    raw = _core.batch(core, list(asked.items()), seconds, driven, is_double(dtype), threads, progress)
    heard: Sound = raw["probes"]
    places = columns(core.probes[1], selectors)
    status = np.empty(len(raw["status"]), object)
    status[:] = raw["status"]
    return Batch(
        audio=raw["audio"],
        sr=round(raw["rate"]),
        values={name: tuple(column) for name, column in asked.items()},
        probes={s: heard[:, :, c[0]] if len(c) == 1 else heard[:, :, c] for s, c in places.items()},
        status=status,
        message=tuple(raw["message"]),
        failed=tuple(raw["failed"]),
        peak=raw["peak"],
    )


def _column(name: str, given: object) -> list[Any]:
    """Values of one parameter."""
    if isinstance(given, (str, bytes, Mapping, Set)) or not hasattr(given, "__iter__") or getattr(given, "ndim", 1) == 0:
        raise UsageError(f"`{name}` is {given!r}; use a list or an array with one value per instance")
    all = list(itertools.islice(given, _MOST + 1))
    if len(all) > _MOST:
        raise UsageError(f"`{name}` has more than {_MOST} values; play fewer instances at a time")
    return [value(name, v) for v in all]
