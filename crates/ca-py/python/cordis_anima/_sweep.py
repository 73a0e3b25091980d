"""One scene played many times, each time with other values.

Decides that whoever computes a run is an `Executor` of the standard library, and that what is handed to it is plain: a job
that can be pickled, and numbers of runs. So threads, processes, joblib, Dask, MPI and Ray are the same to it.
"""

from __future__ import annotations

import functools
import operator
import os
import pickle
import time
import uuid
from collections.abc import Iterator, Mapping, Sequence, Set
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple, Union

import numpy as np
import numpy.typing as npt

from . import _html, _zarr
from ._errors import FailedError, UsageError, needed
from ._job import Job, fill, play
from ._results import Floats, Sound, plain
from ._scene import Gesture, Path, Progress, Scene

#: how many rows a notebook shows, and what of them besides what was varied
_SHOWN = 10
_TOLD = ("status", "failed", "peak", "rms", "partial", "t60", "residual", "message")
#: how long a task should take [s], so that handing it over is little beside it
_TASK = 0.5


class Range(NamedTuple):
    """A parameter that may be anything between two values, or `steps` of them.

    >>> import cordis_anima as ca
    >>> ca.Range("1 kN/m", "9 kN/m", log=True)
    Range(low='1 kN/m', high='9 kN/m', log=True, steps=None)
    """

    #: at one end: a number in the model's units, or a quantity
    low: float | str
    #: at the other
    high: float | str
    #: equal ratios instead of equal differences
    log: bool = False
    #: how many values; anything between if none
    steps: int | None = None


#: what a parameter may be: a range, or values
Space = Union[Range, Sequence[object], npt.NDArray[Any]]
Column = npt.NDArray[Any]
Task = functools.partial[Any]


@dataclass(frozen=True, repr=False, eq=False)
class Sweep(Mapping[str, Column]):
    """What became of all runs: columns by name, in the order of runs.

    Numbers are arrays, NaN where a run has none; texts are arrays of ``object``, ``None`` where a run has none.

    >>> import cordis_anima as ca
    >>> s = ca.sweep(ca.examples.string(), {"low.m": ["1 g", "2 g", "-1 g"]}, seconds=0.05)
    >>> len(s["peak"]), s["status"].tolist()
    (3, ['ok', 'ok', 'invalid'])
    """

    columns: Mapping[str, Column]
    #: names of what was varied
    axes: tuple[str, ...]
    #: sounds (frames, channels) of all runs, where they were kept in memory
    audio: tuple[Sound, ...] | None
    #: sound rate [Hz]
    rate: float
    #: where it was written, if it was
    path: str | None
    #: hash of the scene as it is where nothing varies it
    scene: str
    #: time it took, with everything [s]
    run_time: float

    def __getitem__(self, name: str) -> Column:
        return self.columns[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.columns)

    def __len__(self) -> int:
        return len(self.columns)

    @property
    def runs(self) -> int:
        """How many runs there are."""
        return len(self.columns["index"])

    @property
    def ok(self) -> npt.NDArray[np.bool_]:
        """Which runs are as they should be."""
        return np.array(self.columns["status"] == "ok", np.bool_)

    @property
    def counts(self) -> dict[str, int]:
        """How many runs ended how."""
        status, n = np.unique(self.columns["status"].astype(str), return_counts=True)
        return {str(s): int(k) for s, k in zip(status, n)}

    def to_pandas(self) -> Any:
        """A `pandas.DataFrame`, by the number of the run."""
        return needed("pandas", "data").DataFrame(dict(self.columns)).set_index("index")

    def to_xarray(self) -> Any:
        """An `xarray.Dataset` over ``run``; with ``audio`` (run, frame, channel) where all sounds are of one length."""
        data: dict[str, Any] = {k: ("run", v) for k, v in self.columns.items() if k != "index"}
        if self.audio and len({a.shape for a in self.audio}) == 1:
            data["audio"] = (("run", "frame", "channel"), np.stack(self.audio))
        return needed("xarray", "data").Dataset(
            {k: v for k, v in data.items() if k not in self.axes},
            coords={"run": self.columns["index"]} | {k: data[k] for k in self.axes},
            attrs={"scene": self.scene, "rate": self.rate},
        )

    def __repr__(self) -> str:
        told = ", ".join(f"{n} {status}" for status, n in self.counts.items())
        return f"<Sweep: {self.runs} runs over {', '.join(self.axes) or 'nothing'}: {told}>"

    def _repr_html_(self) -> str:
        names = [name for name in ("index", *self.axes, *_TOLD) if name in self]
        first = {name: self[name][:_SHOWN].tolist() for name in names}
        return _html.sweep(repr(self)[1:-1], first, max(0, self.runs - _SHOWN))


def sweep(
    scene: Scene,
    vary: Mapping[str, Space],
    runs: int | None = None,
    *,
    seed: int = 0,
    seconds: float | None = None,
    gesture: Gesture = None,
    energy: bool = False,
    measure: bool = True,
    to: Path | None = None,
    audio: bool | Literal["flac", "wav", "none"] | None = None,
    chunk: int | None = None,
    executor: Executor | None = None,
    batch: int | None = None,
    progress: Progress | None = None,
) -> Sweep:
    """Plays a scene many times, each time with other values.

    A run depends on the scene, the seed and its number only: any executor, in any order, finds the same. A run that blows
    up or makes no sense is a row with its `status`, and ends nothing. Ctrl-C ends the sweep; what was written stays, and
    the same call goes on from there.

    Args:
        scene: what is played.
        vary: what each parameter may be: a `Range`, or a list or array of values.
        runs: how many are drawn; without, every combination of values, the last parameter first.
        seed: another one draws others.
        seconds: how long each is played; without, as the model says.
        gesture: what drives ports and live parameters, as in `Scene.render`.
        energy: keep the energy book, for a column ``residual``.
        measure: measure the strongest partial and the decay.
        to: a folder for sounds and rows, or ``*.zarr``; without, all stays in memory. What is there is not done again.
        audio: ``"flac"``, ``"wav"`` or ``"none"`` in a folder; in memory and Zarr, whether sounds are kept.
        chunk: how many runs are written at once; without, a 64th of them, 100 at most.
        executor: who computes: threads of this process if none. Any `concurrent.futures.Executor`:
            ``dask.distributed.Client(…).get_executor()``, ``joblib.externals.loky.get_reusable_executor()``,
            ``mpi4py.futures.MPIPoolExecutor()``.
        batch: runs of a task in memory; without, as many as take half a second.
        progress: told how many runs of how many are done.

    Raises:
        UsageError: no such parameter, values that are none, a folder of something else.
        ModelError: the scene itself has errors.

    >>> import cordis_anima as ca
    >>> vary = {"low.f": ca.Range("110 Hz", "440 Hz", log=True), "hammer.m": ["10 g", "20 g"]}
    >>> s = ca.sweep(ca.examples.string(), vary, 20, seed=1, seconds=0.1)
    >>> s
    <Sweep: 20 runs over low.f, hammer.m: 20 ok>
    >>> s["low.f"].shape, bool(s["peak"][s["hammer.m"] == 0.02].mean() > s["peak"][s["hammer.m"] == 0.01].mean())
    ((20,), True)
    """
    if seconds is not None and not 0 < seconds < 1e9:
        raise UsageError(f"seconds = {seconds}: a length above 0, below 1e9")
    runs = None if runs is None else _whole("runs", runs, 1, 2**40)
    seed = _whole("seed", seed, 0, 2**64 - 1)
    batch = None if batch is None else _whole("batch", batch, 1, 2**40)
    chunk = None if chunk is None else _whole("chunk", chunk, 1, 1_000_000)
    begin = time.perf_counter()
    asked = (runs, seed, None if seconds is None else float(seconds), bool(energy), bool(measure))
    job = _job(scene, vary, asked, gesture)
    core = job.core
    # workers may stand elsewhere
    target = None if to is None else os.path.abspath(os.fsdecode(to))
    chunk = core.chunk if chunk is None else chunk
    kept: Any = None
    if target is None:
        if isinstance(audio, str):
            raise UsageError(f"audio = {audio!r} is for a folder, `to=`; in memory, `True` keeps sounds")
        tasks, kept = _in_memory(job, bool(audio), batch)
    elif target.endswith(".zarr"):
        if isinstance(audio, str):
            raise UsageError(f"audio = {audio!r} is for a folder; in Zarr, `True` or `False`")
        tasks = _zarr.tasks(job, target, audio is not False, chunk)
    else:
        form = audio if isinstance(audio, str) else "none" if audio is False else "flac"
        tasks = [functools.partial(fill, job, target, form, chunk, k) for k in core.missing(target, form, chunk)]
    # the last chunk may be shorter than others
    todo = core.runs - (1 if kept else 0) if target is None else sum(_size(t, core.runs, chunk) for t in tasks)
    own = ThreadPoolExecutor(os.cpu_count() or 1)
    try:
        done = _all(executor or own, tasks, todo, core.runs, kept, progress)
    except BaseException:
        core.stop()
        raise
    finally:
        own.shutdown(cancel_futures=True)
    sounds: tuple[Sound, ...] | None = None
    if target is None:
        columns = _together([d[2] for d in done])
        sounds = tuple(s for d in done for s in d[3]) if audio else None
    elif target.endswith(".zarr"):
        columns = _zarr.columns(target)
    else:
        raw = core.gather(target, form, chunk)
        if raw is None:
            raise FailedError(f"`{target}` has not all runs after all: is it the same folder for all workers?")
        columns = _arrays(raw)
    return Sweep(columns, tuple(core.columns[1]), sounds, core.rate, target, core.hash, time.perf_counter() - begin)


def _whole(name: str, value: object, low: int, high: int) -> int:
    """A whole number, of Python, NumPy or whoever has some."""
    try:
        number = operator.index(value)  # type: ignore[arg-type]
    except TypeError:
        raise UsageError(f"{name} = {value!r}: a whole number is wanted") from None
    if not low <= number <= high:
        raise UsageError(f"{name} = {number}: {low} to {high}")
    return number


def _value(name: str, value: object) -> object:
    """A value that a model can have."""
    value = plain(value)
    if isinstance(value, int) and not isinstance(value, bool):
        try:
            return float(value)
        except OverflowError:
            raise UsageError(f"`{name}` cannot be {value}") from None
    if isinstance(value, (bool, float, str, list, dict)):
        return value
    raise UsageError(f"`{name}` cannot be {value!r}: numbers, quantities, names and lists are values")


def _job(scene: Scene, vary: Mapping[str, Space], asked: tuple[Any, ...], gesture: Gesture) -> Job:
    axes: list[tuple[str, Any]] = []
    for name, space in vary.items():
        if isinstance(space, Range):
            steps = None if space.steps is None else _whole(f"`{name}`: steps", space.steps, 2, 1_000_000)
            axes.append((name, (_value(name, space.low), _value(name, space.high), bool(space.log), steps)))
        elif isinstance(space, (str, bytes, Mapping, Set)) or not hasattr(space, "__iter__") or getattr(space, "ndim", 1) == 0:
            raise UsageError(f"`{name}` may be {space!r}: a `Range`, or a list of values")
        else:
            axes.append((name, [_value(name, v) for v in space]))
    rate, _ = scene._asked
    hands = scene._gesture(gesture)
    held = None if hands is None else pickle.dumps(hands.tracks(), 4)
    model = scene._model
    return Job((model.bytes(), model.name, (rate, *asked), pickle.dumps(axes, 4), held, uuid.uuid4().hex))


def _in_memory(job: Job, audio: bool, batch: int | None) -> tuple[list[Task], Any]:
    """Tasks of about half a second, and what was played to know how many runs that are."""
    runs, kept = job.core.runs, None
    first = 0
    if batch is None:
        begin = time.perf_counter()
        kept = play(job, 0, 1, audio)
        first, each = 1, time.perf_counter() - begin
        # few enough that several workers have something to do to the end
        batch = max(1, min(int(_TASK / max(each, 1e-6)), (runs + 15) // 16))
    parts = range(first, runs, batch)
    return [functools.partial(play, job, k, min(k + batch, runs), audio) for k in parts], kept


def _size(task: Task, runs: int, chunk: int) -> int:
    """Runs of a chunk, whose number is the last argument of its task."""
    first = int(task.args[-1]) * chunk
    return min(first + chunk, runs) - first


def _all(
    executor: Executor, tasks: list[Task], todo: int, runs: int, kept: Any, progress: Progress | None
) -> list[Any]:
    """What all tasks return, in their order."""
    waiting: set[Future[Any]] = set()
    done: list[Any] = [] if kept is None else [kept]
    # what is there already counts as done
    count = runs - todo
    try:
        waiting = {executor.submit(t.func, *t.args) for t in tasks}
        while waiting:
            ready, waiting = wait(waiting, timeout=0.1, return_when=FIRST_COMPLETED)
            for future in ready:
                found = future.result()
                count += found[1]
                done.append(found)
            if ready and progress is not None:
                progress(count, runs)
    finally:
        for future in waiting:
            future.cancel()
    return sorted(done, key=lambda d: int(d[0]))


def _arrays(raw: Mapping[str, Any]) -> dict[str, Column]:
    def text(values: list[str | None]) -> Column:
        column = np.empty(len(values), object)
        column[:] = values
        return column

    return {k: text(v) if isinstance(v, list) else np.asarray(v) for k, v in raw.items()}


def _together(parts: Sequence[Mapping[str, Any]]) -> dict[str, Column]:
    all = [_arrays(p) for p in parts]
    return {k: np.concatenate([p[k] for p in all]) for k in all[0]}
