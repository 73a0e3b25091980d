"""Tasks of a sweep, handed to an executor as there is room for them, and what a sweep will take.

Decides that no more tasks wait than keep every worker busy: what waits does not grow with the number of runs. What stays
are rows and sounds, so those are counted before anything is handed over, and refused where they would not fit. How long
it takes is reported as soon as something has been played, where that is long.
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

#: tasks that wait for each worker, at least so many for all of them, and so many where nobody knows how many there are
_EACH, _LEAST, _UNKNOWN = 4, 64, 1024
#: how long a sweep may take without a word, and how long it is watched before its time is reported [s]
_LONG, _WATCHED = 600.0, 1.0
#: memory where the system does not say how much it has [bytes]
_MEMORY = 4 << 30


def memory() -> int:
    """How much memory this machine has [bytes]."""
    try:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, ValueError, OSError):
        return _MEMORY


def check_room(runs: int, columns: int, first: Callable[[], tuple[Any, float]], sound: bool, channels: int) -> None:
    """Refuses a sweep whose rows and sounds would take more than half of the memory, saying how much, and how long.

    Args:
        runs: how many there are.
        columns: how many each has.
        first: plays the first run: its result, and the time it took [s]; called where its row or its length matters.
        sound: whether sounds stay in memory too.
        channels: of a sound.
    """
    # twice, since rows of tasks are joined at the end
    least = 2 * 8 * columns * runs
    if least <= memory() // 100 and not sound:
        return
    (_, _, row, _), each = first()
    texts = sum(sys.getsizeof(v[0]) for v in row.values() if isinstance(v, list))
    need = least + texts * runs + (4 * channels * int(row["frames"][0]) * runs if sound else 0)
    if need > memory() // 2:
        what = "rows and sounds" if sound else "rows"
        raise UsageError(
            f"{runs} runs: their {what} take {_bytes(need)}, half of the memory here is {_bytes(memory() // 2)}, and one "
            f"thread plays them in {_duration(each * runs)}; ask for fewer, or for parts of them in calls of their own"
        )


def tell(seconds: float, runs: int, level: int) -> bool:
    """Warns of a sweep that takes long, `level` calls above; whether it did."""
    if seconds < _LONG:
        return False
    warnings.warn(f"{runs} runs are left, which take about {_duration(seconds)}; Ctrl-C ends them", stacklevel=level + 1)
    return True


def workers(executor: Executor) -> int | None:
    """How many work for an executor, where it says so."""
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
    """What all tasks return, in their order, `todo` runs of `runs`; `kept` is what was played before, `reported` whether its
    time was.
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
                # what was there already counts as done
                progress(runs - todo + new, runs)
            passed = time.perf_counter() - begin
            if not reported and new and passed > _WATCHED:
                reported = tell(passed / new * (todo - new), todo - new, 3)
    finally:
        for future in waiting:
            future.cancel()
    return sorted(done, key=lambda d: int(d[0]))


def _bytes(n: float) -> str:
    """As people write it: 3.2 GB."""
    unit = "B"
    for bigger in ("kB", "MB", "GB", "TB", "PB"):
        if n < 1000:
            break
        n, unit = n / 1000, bigger
    return f"{n:.3g} {unit}"


def _duration(seconds: float) -> str:
    """As people say it: 12 min, 2.5 h, 40 days, 95 years."""
    for unit, each, most in (("s", 1, 120), ("min", 60, 7200), ("h", 3600, 172_800), ("days", 86_400, 6.3e7)):
        if seconds < most:
            return f"{seconds / each:.3g} {unit}"
    return f"{seconds / 31_557_600:.3g} years"
