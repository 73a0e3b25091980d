"""Submits the tasks of a sweep to an executor, and estimates its time and memory.

Only as many tasks wait as keep every worker busy, so waiting tasks do not grow with the number of runs. Rows and sounds
do grow. They are counted first, and a sweep that would not fit in memory is refused. A long run time is reported as
soon as something has been played.
"""

from __future__ import annotations

import functools
import itertools
import os
import sys
import time
import warnings
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from typing import Any

from .._errors import UsageError

Task = functools.partial[Any]

#: waiting tasks per worker, at least in total, and for an unknown number of workers
_EACH, _LEAST, _UNKNOWN = 4, 64, 1024
#: longest sweep without a warning, and time after which its length is estimated [s]
_LONG, _WATCHED = 600.0, 1.0
#: assumed memory if the system does not report it [bytes]
_MEMORY = 4 << 30


def memory() -> int:
    """Memory of this machine [bytes]."""
    try:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, ValueError, OSError):
        return _MEMORY


def check_room(runs: int, columns: int, first: Callable[[], tuple[Any, float]], sound: bool, channels: int) -> None:
    """Refuses a sweep whose rows and sounds would take more than half of the memory; the message has size and time.

    Args:
        runs: number of runs.
        columns: number of columns of each.
        first: plays the first run and returns its result and the time it took [s]; called only if needed.
        sound: true if sounds stay in memory too.
        channels: channels of a sound.
    """
    # counted twice, because the rows of all tasks are joined at the end
    least = 2 * 8 * columns * runs
    if least <= memory() // 100 and not sound:
        return
    (_, _, row, _), each = first()
    texts = sum(sys.getsizeof(v[0]) for v in row.values() if isinstance(v, list))
    need = least + texts * runs + (4 * channels * int(row["frames"][0]) * runs if sound else 0)
    if need > memory() // 2:
        what = "rows and sounds" if sound else "rows"
        raise UsageError(
            f"{runs} runs: their {what} take {_bytes(need)}, but half of the memory is {_bytes(memory() // 2)}; one thread "
            f"plays them in {_duration(each * runs)}; use fewer runs, or split them into several calls"
        )


def tell(seconds: float, runs: int, level: int) -> bool:
    """Warns about a long sweep, `level` calls above. Returns true if it did."""
    if seconds < _LONG:
        return False
    warnings.warn(f"{runs} runs are left, which take about {_duration(seconds)}; Ctrl-C stops them", stacklevel=level + 1)
    return True


def workers(executor: Executor) -> int | None:
    """Number of workers of an executor, if it is known."""
    n = getattr(executor, "_max_workers", None)
    return n if isinstance(n, int) and n > 0 else None


def all_of(
    executor: Executor,
    tasks: Iterable[Task],
    todo: int,
    runs: int,
    kept: Any,
    reported: bool,
    progress: Callable[[int, int], object] | None,
) -> list[Any]:
    """Runs all tasks and returns their results in order: `todo` runs of `runs`. `kept` is the result of an earlier run;
    `reported` tells if the time was reported.
    """
    n = workers(executor)
    room = _UNKNOWN if n is None else max(_LEAST, _EACH * n)
    left: Iterator[Task] = iter(tasks)
    waiting: set[Future[Any]] = set()
    done: list[Any] = [] if kept is None else [kept]
    new, begin = 0, time.perf_counter()
    try:
        while True:
            for task in itertools.islice(left, room - len(waiting)):
                waiting.add(executor.submit(task.func, *task.args))
            if not waiting:
                break
            ready, waiting = wait(waiting, timeout=0.1, return_when=FIRST_COMPLETED)
            for future in ready:
                found = future.result()
                new += found[1]
                done.append(found)
            if ready and progress is not None:
                # existing results count as done
                progress(runs - todo + new, runs)
            passed = time.perf_counter() - begin
            if not reported and new and passed > _WATCHED:
                reported = tell(passed / new * (todo - new), todo - new, 3)
    finally:
        for future in waiting:
            future.cancel()
    return sorted(done, key=lambda d: int(d[0]))


def _bytes(n: float) -> str:
    """Formats a size, such as 3.2 GB."""
    unit = "B"
    for bigger in ("kB", "MB", "GB", "TB", "PB"):
        if n < 1000:
            break
        n, unit = n / 1000, bigger
    return f"{n:.3g} {unit}"


def _duration(seconds: float) -> str:
    """Formats a duration: 12 min, 2.5 h, 40 days, 95 years."""
    for unit, each, most in (("s", 1, 120), ("min", 60, 7200), ("h", 3600, 172_800), ("days", 86_400, 6.3e7)):
        if seconds < most:
            return f"{seconds / each:.3g} {unit}"
    return f"{seconds / 31_557_600:.3g} years"
