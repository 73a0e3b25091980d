"""A sweep in Zarr: every column is an array over runs; the sounds are one array over runs, frames and channels.

A task writes one chunk of each array, so that workers never touch the same file. `done` is written last and marks
complete chunks. Missing texts are empty here. Because a task writes a file per column, chunks are as large as they can
be with several tasks for each worker.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from typing import Any

import numpy as np

from .. import _core
from .._errors import UsageError, needed
from .job import Job


#: default limits: runs per chunk, bytes of its sounds, and smallest number of tasks
_RUNS, _BYTES, _TASKS = 100, 64 << 20, 8


def _group(path: str, mode: str) -> Any:
    return needed("zarr", "data").open_group(path, mode=mode)


def chunk(core: _core.Sweep, first: Mapping[str, Any], audio: bool) -> int:
    """Default number of runs per chunk, from the length of the first run; always the same for a sweep."""
    sound = 4 * core.channels * int(first["frames"][0]) if audio else 0
    return max(1, min(_RUNS, -(-core.runs // _TASKS), _BYTES // sound if sound else _RUNS))


def missing(job: Job, path: str, audio: bool, chunk: int) -> list[int]:
    """Numbers of the missing chunks in a store, which is created if needed."""
    core = job.core
    asked = core.reported("zarr" if audio else "none", chunk)
    group = _group(path, "a")
    said = group.attrs.get("cordis_anima")
    if said not in (None, asked):
        raise UsageError(f"`{path}` contains another sweep; choose another store, or remove this one")
    if said is None and any(True for _ in group.keys()):
        raise UsageError(f"`{path}` contains other data; choose another store")
    if not group.attrs.get("made"):
        # an unfinished creation starts again
        group.attrs["cordis_anima"] = asked
        for name in list(group.keys()):
            del group[name]
        _make(job, group, audio, chunk)
        group.attrs["scene"], group.attrs["rate"] = core.hash, core.rate
        group.attrs["columns"] = core.columns[0]
        group.attrs["made"] = True
    done = group["done"][:]
    return [int(k) for k in np.flatnonzero(done == 0)]


def _make(job: Job, group: Any, audio: bool, chunk: int) -> None:
    core, frames = job.core, 0
    columns: dict[str, Any] = {}
    for first in range(core.runs):
        columns, _ = core.play(first, first + 1, False)
        frames = int(columns["frames"][0])
        if frames:
            break
    with warnings.catch_warnings():
        # the warning that texts are not part of the core format does not matter here
        warnings.simplefilter("ignore")
        for name, values in columns.items():
            kind = str if isinstance(values, list) else values.dtype
            group.create_array(name, shape=(core.runs,), chunks=(chunk,), dtype=kind, dimension_names=("run",))
        if audio:
            shape = (core.runs, frames, core.channels)
            names = ("run", "frame", "channel")
            group.create_array("audio", shape=shape, chunks=(chunk, *shape[1:]), dtype="f4", dimension_names=names)
        n = -(-core.runs // chunk)
        group.create_array("done", shape=(n,), chunks=(1,), dtype="u1", dimension_names=("chunk",))


def fill(job: Job, path: str, audio: bool, chunk: int, which: int) -> tuple[int, int, Any, Any]:
    core = job.core
    first, end = which * chunk, min((which + 1) * chunk, core.runs)
    columns, sounds = core.play(first, end, audio)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        group = _group(path, "r+")
        if audio:
            to = group["audio"]
            block = np.zeros((end - first, *to.shape[1:]), np.float32)
            for k, sound in enumerate(sounds):
                if len(sound) not in (0, block.shape[1]):
                    what = f"run {first + k} has {len(sound)} frames, others {block.shape[1]}"
                    raise UsageError(f"{what}; sounds in Zarr need one length: set `seconds`, or write into a folder")
                block[k, : len(sound)] = sound
            to[first:end] = block
        for name, values in columns.items():
            if isinstance(values, list):
                values = np.array(["" if v is None else v for v in values], dtype=object)
            group[name][first:end] = values
        group["done"][which] = 1
    return which, end - first, None, None


def columns(path: str) -> dict[str, Any]:
    """All columns of a store, without sounds."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        group = _group(path, "r")
        found = {name: np.asarray(group[name][:]) for name in group.attrs["columns"]}
    # texts become objects, as in memory
    return {name: v if v.dtype.kind in "iuf" else v.astype(object) for name, v in found.items()}
