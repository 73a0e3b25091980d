"""Renders of many instances and gradients of their losses, for machine-learning libraries.

The interface is a function of plain arrays: rows of values in, sound out, and rows of gradients for cotangents. `torch`
and `jax` differ only in how they register it. If one instance cannot be played, the whole call fails with its message,
because a loss over silence would be misleading. A gesture is read once, so that the gradient belongs to the gesture
that was played.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np

from .._sweeps.batch import batch
from .._errors import FailedError, UsageError
from .._gestures import Gesture, made
from .._results import Floats, Sound, length, whole
from .._scene import Scene


class Instances:
    """Instances of a scene that differ in the values of some parameters, played and differentiated by threads."""

    def __init__(
        self,
        scene: Scene,
        names: Sequence[str],
        seconds: float | str | None,
        gesture: Gesture,
        threads: int | None,
    ) -> None:
        if not isinstance(scene, Scene):
            raise UsageError(f"a scene must come from `ca.load` or `ca.parse`, not {type(scene).__name__}")
        self.names = tuple(names)
        # unknown names are reported here, not in a later callback
        for name in names:
            scene._model.copy().set(name, 0.0)
        self._scene, self._gesture = scene, made(scene._compiled, gesture)
        self._seconds = None if seconds is None else length(seconds)
        self._threads = (os.cpu_count() or 1) if threads is None else whole("threads", threads, 1, 4096)
        #: channels of the sound
        self.channels = len(scene.channels)

    @property
    def frames(self) -> int:
        """Samples per channel."""
        if self._seconds is None:
            return len(self._scene.render(gesture=self._gesture).audio)
        # rounded as in the engine
        return max(1, math.floor(self._seconds * self._scene.rate + 0.5))

    def sound(self, values: Floats) -> Sound:
        """Sound (…, frames, channels) for values (…, parameters), in double precision."""
        rows = values.reshape(-1, len(self.names)).astype(float)
        columns = {name: rows[:, k] for k, name in enumerate(self.names)}
        b = batch(self._scene, columns, self._seconds, gesture=self._gesture, dtype="float64", threads=self._threads)
        for i, status in enumerate(b.status):
            if status != "ok":
                raise FailedError(f"instance {i} ({self._said(rows[i])}) is {status}: {b.message[i]}")
        return b.audio.reshape(*values.shape[:-1], *b.audio.shape[1:])

    def pullback(self, values: Floats, cotangents: Sound, wanted: Sequence[bool] | None = None) -> Floats:
        """Gradients (…, parameters) of a loss whose derivatives by the samples are `cotangents` (…, frames, channels);
        0 for parameters that are not `wanted`.
        """
        rows = values.reshape(-1, len(self.names)).astype(float)
        given = np.asarray(cotangents, float).reshape(len(rows), *cotangents.shape[-2:])
        places = [k for k in range(len(self.names)) if wanted is None or wanted[k]]

        def one(row: Floats, cotangent: Floats) -> Floats:
            scene = self._scene.replace(dict(zip(self.names, row.tolist())))
            names = [self.names[k] for k in places]
            found = np.zeros(len(self.names))
            found[places] = scene.gradient(names, cotangent=cotangent, gesture=self._gesture).gradient
            return found

        pool = ThreadPoolExecutor(self._threads)
        try:
            all = list(pool.map(one, rows, given))
        finally:
            # Ctrl-C does not wait for running rows
            pool.shutdown(wait=False, cancel_futures=True)
        return np.array(all).reshape(values.shape)

    def _said(self, row: Floats) -> str:
        return ", ".join(f"{name} = {value:g}" for name, value in zip(self.names, row))


def alone(scene: Scene, seconds: float | str | None, gesture: Gesture) -> Sound:
    """Sound (frames, channels) of the unchanged scene, in double precision."""
    r = scene.render(seconds, gesture=gesture, dtype="float64")
    if r.status != "ok":
        raise FailedError(f"the scene is {r.status}: {r.message}")
    return r.audio


def constants(scene: Scene, values: Mapping[str, Any], wanted: str) -> tuple[Scene, dict[str, Any]]:
    """Splits values into constants, which are set in the scene, and arrays to differentiate by.

    Raises:
        UsageError: if the values are not what is `wanted`.
    """
    if not isinstance(values, Mapping) or not values:
        raise UsageError(f"values must be {wanted}")
    fixed = {name: v for name, v in values.items() if isinstance(v, (bool, int, float, str))}
    return scene.replace(fixed) if fixed else scene, {name: v for name, v in values.items() if name not in fixed}
