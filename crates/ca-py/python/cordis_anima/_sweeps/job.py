"""Runs of a sweep as a job for any worker.

A job is pickled as the bytes of a model and plain values, and compiled once in each process that plays it.
"""

from __future__ import annotations

import functools
import pickle
from typing import Any

from .. import _core

class Job:
    """Everything that a worker needs. Pickled, it is a model of some kilobytes; the scene is compiled by the worker."""

    def __init__(self, key: tuple[Any, ...]) -> None:
        #: model, its name, arguments, axes, gesture, and a number unique to this call
        self.key = key

    def __reduce__(self) -> tuple[Any, ...]:
        return (Job, (self.key,))

    @property
    def core(self) -> _core.Sweep:
        return _made(*self.key)


@functools.lru_cache(maxsize=32)
def _made(
    model: bytes, name: str, asked: tuple[Any, ...], vary: bytes, gesture: bytes | None, call: str
) -> _core.Sweep:
    """The sweep of a call, once per process. Each call has a separate one, so that stopping it stops no other."""
    rate, runs, seed, seconds, energy, measure = asked
    hands = None if gesture is None else _core.Gesture(*pickle.loads(gesture))
    return _core.Sweep(
        _core.Model.from_bytes(model, name),
        rate=rate,
        vary=pickle.loads(vary),
        runs=runs,
        seed=seed,
        seconds=seconds,
        gesture=hands,
        energy=energy,
        measure=measure,
    )


def play(job: Job, first: int, end: int, audio: bool) -> tuple[int, int, Any, Any]:
    """Plays runs in memory. Returns the first, their number, columns and sounds."""
    columns, sounds = job.core.play(first, end, audio)
    return first, end - first, columns, sounds


def fill(job: Job, path: str, audio: str, chunk: int, which: int) -> tuple[int, int, Any, Any]:
    """Plays a chunk into a folder. Returns its index and its number of runs."""
    return which, job.core.fill(path, audio, chunk, which), None, None
