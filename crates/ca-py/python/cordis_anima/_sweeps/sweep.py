"""Plays one scene many times, each time with other values.

Runs are computed by any `Executor` of the standard library. It gets plain data: a job that can be pickled, and numbers
of runs. So threads, processes, joblib, Dask, MPI and Ray all work. `work` submits the tasks.
"""

from __future__ import annotations

import functools
import itertools
import os
import pickle
import time
import uuid
from collections.abc import Iterator, Mapping, Sequence, Set
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple, Union

import numpy as np
import numpy.typing as npt

from .._page import html as _html
from . import work as _work
from . import zarr as _zarr
from .._errors import FailedError, UsageError, needed
from .job import Job, fill, play
from .._results import Floats, Sound, length, value, whole
from .._gestures import Gesture, Path, made
from .._analysis.measured import Progress
from .._scene import Scene

#: rows shown by a notebook, and columns shown besides the varied ones
_SHOWN = 10
_TOLD = ("status", "failed", "peak", "rms", "partial", "t60", "residual", "message")
#: intended length of a task [s], long compared with submitting it
_TASK = 0.5
#: most values of a parameter
_VALUES = 1_000_000


class Range(NamedTuple):
    """Any value between two ends, or `steps` values.

    >>> import cordis_anima as ca
    >>> ca.Range("1 kN/m", "9 kN/m", log=True)
    Range(low='1 kN/m', high='9 kN/m', log=True, steps=None)
    """

    #: one end: a number in the model's units, or a quantity
    low: float | str
    #: the other end
    high: float | str
    #: equal ratios instead of equal differences
    log: bool = False
    #: number of values; any value between if ``None``
    steps: int | None = None


#: values of a parameter: a range, or a list
Space = Union[Range, Sequence[object], npt.NDArray[Any]]
Column = npt.NDArray[Any]
Task = _work.Task


@dataclass(frozen=True, repr=False, eq=False)
class Sweep(Mapping[str, Column]):
    """Result of a sweep: columns by name, in the order of runs.

    Numbers are arrays, with NaN where a run has none; texts are arrays of ``object``, with ``None`` where a run has
    none.

    >>> import cordis_anima as ca
    >>> s = ca.sweep(ca.examples.string(), {"low.m": ["1 g", "2 g", "-1 g"]}, seconds=0.05)
    >>> len(s["peak"]), s["status"].tolist()
    (3, ['ok', 'ok', 'invalid'])
    """

    columns: Mapping[str, Column]
    #: names of the varied parameters
    axes: tuple[str, ...]
    #: sounds (frames, channels) of all runs, if kept in memory
    audio: tuple[Sound, ...] | None
    #: sound rate [Hz]
    rate: float
    #: folder it was written to, if any
    path: str | None
    #: hash of the scene without changes
    scene: str
    #: total time it took [s]
    run_time: float

    def __getitem__(self, name: str) -> Column:
        try:
            return self.columns[name]
        except KeyError:
            raise KeyError(self._missing(name)) from None

    @staticmethod
    def _missing(name: str) -> str:
        """Message for a column that does not exist."""
        return f"no column `{name}`" + ("; `sweep(…, measure=True)` adds it" if name in ("partial", "t60") else "")

    def __iter__(self) -> Iterator[str]:
        return iter(self.columns)

    def __len__(self) -> int:
        return len(self.columns)

    # a mapping would compare values, and the truth value of an array is ambiguous
    __eq__ = object.__eq__
    __hash__ = object.__hash__

    @property
    def runs(self) -> int:
        """Number of runs."""
        return len(self.columns["index"])

    @property
    def ok(self) -> npt.NDArray[np.bool_]:
        """Mask of the runs with status ``ok``."""
        return np.array(self.columns["status"] == "ok", np.bool_)

    @property
    def counts(self) -> dict[str, int]:
        """Number of runs by status."""
        status, n = np.unique(self.columns["status"].astype(str), return_counts=True)
        return {str(s): int(k) for s, k in zip(status, n)}

    def to_pandas(self) -> Any:
        """Converts it to a `pandas.DataFrame`, indexed by run."""
        return needed("pandas", "data").DataFrame(dict(self.columns)).set_index("index")

    def to_xarray(self) -> Any:
        """Converts it to an `xarray.Dataset` over ``run``, with ``audio`` (run, frame, channel) if equally long."""
        data: dict[str, Any] = {k: ("run", v) for k, v in self.columns.items() if k != "index"}
        if self.audio and len({a.shape for a in self.audio}) == 1:
            data["audio"] = (("run", "frame", "channel"), np.stack(self.audio))
        return needed("xarray", "data").Dataset(
            {k: v for k, v in data.items() if k not in self.axes},
            coords={"run": self.columns["index"]} | {k: data[k] for k in self.axes},
            attrs={"scene": self.scene, "rate": self.rate},
        )

    def __repr__(self) -> str:
        reported = ", ".join(f"{n} {status}" for status, n in self.counts.items())
        return f"<Sweep: {self.runs} runs over {', '.join(self.axes) or 'nothing'}: {reported}>"

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
    seconds: float | str | None = None,
    gesture: Gesture = None,
    energy: bool = False,
    measure: bool = False,
    to: Path | None = None,
    audio: bool | Literal["flac", "wav", "none"] | None = None,
    chunk: int | None = None,
    executor: Executor | None = None,
    batch: int | None = None,
    progress: Progress | None = None,
) -> Sweep:
    """Plays a scene many times, each time with other values.

    A run depends only on the scene, the seed and its number, so any executor gives the same results in any order. A run
    that diverges or is invalid becomes a row with a `status`; the others continue. Ctrl-C ends the sweep; finished
    parts stay, and the same call continues from there. A sweep that will take more than ten minutes gives a warning
    with the time. One whose rows and sounds would take more than half of the memory is refused, with both figures.

    Args:
        scene: scene to play.
        vary: values of each parameter: a `Range`, or a list or array.
        runs: number of random draws; default: every combination of values, the last parameter varying fastest.
        seed: seed of the random draws.
        seconds: length of each run; default: as given by the model.
        gesture: drives ports and live parameters, as in `Scene.render`.
        energy: keep the energy ledger, for the column ``residual``.
        measure: measure the strongest partial and the decay, for the columns ``partial`` and ``t60``. For a short sound
            this takes longer than playing it. ``ca sweep`` does it by default, so to continue its folder set it as
            well.
        to: folder for sounds and rows, or ``*.zarr``; default: everything stays in memory. Existing results are not
            computed again.
        audio: ``"flac"``, ``"wav"`` or ``"none"`` for a folder; for memory and Zarr, whether to keep sounds.
        chunk: number of runs written at once. Default: 1/64 of them; for Zarr 1/8, at most 100 runs and 64 MB of
            sounds.
        executor: computes the runs; default: threads of this process. Any `concurrent.futures.Executor`:
            ``dask.distributed.Client(…).get_executor()``, ``joblib.externals.loky.get_reusable_executor()``,
            ``mpi4py.futures.MPIPoolExecutor()``.
        batch: runs of a task in memory; default: as many as take half a second.
        progress: called with the numbers of runs done and in total.

    Raises:
        UsageError: if a parameter does not exist, values are invalid, the folder has other contents, or the rows do not
            fit into memory.
        ModelError: if the scene itself has errors.

    >>> import cordis_anima as ca
    >>> vary = {"low.f": ca.Range("110 Hz", "440 Hz", log=True), "hammer.m": ["10 g", "20 g"]}
    >>> s = ca.sweep(ca.examples.string(), vary, 20, seed=1, seconds=0.1)
    >>> s
    <Sweep: 20 runs over low.f, hammer.m: 20 ok>
    >>> s["low.f"].shape, bool(s["peak"][s["hammer.m"] == 0.02].mean() > s["peak"][s["hammer.m"] == 0.01].mean())
    ((20,), True)
    """
    seconds = None if seconds is None else length(seconds)
    runs = None if runs is None else whole("runs", runs, 1, 2**40)
    seed = whole("seed", seed, 0, 2**64 - 1)
    if not (executor is None or callable(getattr(executor, "submit", None))):
        raise UsageError(f"executor = {executor!r}: must be an executor of `concurrent.futures`, or `None`")
    batch = None if batch is None else whole("batch", batch, 1, 2**40)
    chunk = None if chunk is None else whole("chunk", chunk, 1, 1_000_000)
    begin = time.perf_counter()
    asked = (runs, seed, seconds, bool(energy), bool(measure))
    job = _job(scene, vary, asked, gesture)
    core = job.core
    # workers may have another working directory
    target = None if to is None else os.path.abspath(os.fsdecode(to))
    if isinstance(audio, str) and (target is None or target.endswith(".zarr")):
        raise UsageError(f"audio = {audio!r} needs a folder, `to=`; in memory and in Zarr, use `True` or `False`")
    total, size = core.runs, core.chunk if chunk is None else chunk
    sound = target is None and bool(audio)

    @functools.cache
    def first() -> tuple[Any, float]:
        """Plays the first run, which is needed before all others. Returns it and the time it took [s]."""
        begin = time.perf_counter()
        return play(job, 0, 1, sound), time.perf_counter() - begin

    _work.check_room(total, len(core.columns[0]), first, sound, core.channels)
    own = ThreadPoolExecutor(os.cpu_count() or 1)
    who = executor or own
    kept: Any = None
    warned = False
    try:
        if target is None:
            kept, each = first()
            tasks = _in_memory(job, sound, batch, each)
            todo = total - 1
            warned = _work.tell(each * todo / (_work.workers(who) or 1), todo, 2)
        else:
            if target.endswith(".zarr"):
                size = _zarr.chunk(core, first()[0][2], audio is not False) if chunk is None else chunk
                missing = _zarr.missing(job, target, audio is not False, size)
                work = functools.partial(_zarr.fill, job, target, audio is not False, size)
            else:
                form = audio if isinstance(audio, str) else "none" if audio is False else "flac"
                missing = core.missing(target, form, size)
                work = functools.partial(fill, job, target, form, size)
            todo = sum(min(size, total - k * size) for k in missing)
            tasks = (functools.partial(work.func, *work.args, k) for k in missing)
        done = _work.all_of(who, tasks, todo, total, kept, warned, progress)
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
        raw = core.gather(target, form, size)
        if raw is None:
            raise FailedError(f"`{target}` does not contain all runs; check that all workers use the same folder")
        columns = _arrays(raw)
    return Sweep(columns, tuple(core.columns[1]), sounds, core.rate, target, core.hash, time.perf_counter() - begin)


def _job(scene: Scene, vary: Mapping[str, Space], asked: tuple[Any, ...], gesture: Gesture) -> Job:
    axes: list[tuple[str, Any]] = []
    for name, space in vary.items():
        if isinstance(space, Range):
            steps = None if space.steps is None else whole(f"`{name}`: steps", space.steps, 2, 1_000_000)
            axes.append((name, (value(name, space.low), value(name, space.high), bool(space.log), steps)))
        elif isinstance(space, (str, bytes, Mapping, Set)) or not hasattr(space, "__iter__") or getattr(space, "ndim", 1) == 0:
            raise UsageError(f"`{name}` is {space!r}; use a `Range`, or a list of values")
        else:
            values = list(itertools.islice(space, _VALUES + 1))
            if len(values) > _VALUES:
                raise UsageError(f"`{name}` has more than {_VALUES} values; use a `Range`, or fewer values")
            axes.append((name, [value(name, v) for v in values]))
    rate, _ = scene._asked
    hands = made(scene._compiled, gesture)
    held = None if hands is None else pickle.dumps((hands.tracks(), hands.midi), 4)
    model = scene._model
    return Job((model.bytes(), model.name, (rate, *asked), pickle.dumps(axes, 4), held, uuid.uuid4().hex))


def _in_memory(job: Job, audio: bool, batch: int | None, each: float) -> Iterator[Task]:
    """Tasks of about half a second after the first run, which took `each` [s]."""
    runs = job.core.runs
    # small enough to keep several workers busy to the end
    size = batch or max(1, min(int(_TASK / max(each, 1e-6)), (runs + 15) // 16))
    parts = range(1, runs, size)
    return (functools.partial(play, job, k, min(k + size, runs), audio) for k in parts)


def _arrays(raw: Mapping[str, Any]) -> dict[str, Column]:
    def text(values: list[str | None]) -> Column:
        column = np.empty(len(values), object)
        column[:] = values
        return column

    return {k: text(v) if isinstance(v, list) else np.asarray(v) for k, v in raw.items()}


def _together(parts: Sequence[Mapping[str, Any]]) -> dict[str, Column]:
    all = [_arrays(p) for p in parts]
    return {k: np.concatenate([p[k] for p in all]) for k in all[0]}
