"""Numbers of a model, found by a recorded sound."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from .._errors import UsageError
from .._results import length, number, transposed, whole
from .._gestures import Gesture, Path, made
from .measured import Progress
from .._scene import Scene


class Distance(NamedTuple):
    """How far a model is from a recording."""

    #: root mean square of the differences of levels [dB]
    levels: float
    #: what is left of the samples, beside the recording [dB]
    samples: float


class Fitted(NamedTuple):
    """A number that was fitted, in SI units."""

    #: what was found
    value: float
    #: one standard deviation; ``None`` where the sound does not determine it, the search has not settled or may be in another
    #: minimum, or the model does not explain the sound
    deviation: float | None
    #: its unit; empty for a plain number
    unit: str
    #: where it started
    start: float
    #: whether it is at an end of its range
    at_end: bool


class Pitch(NamedTuple):
    """Pitches [Hz], by the period after which a sound repeats best; ``None`` of what has none."""

    #: of the recording
    recording: float | None
    #: of the model where it started
    start: float | None
    #: of the model with the values found
    found: float | None
    #: whether it started more than a semitone from the recording: then there are deviations only where the samples agree
    far: bool
    #: whether it ended at another pitch, which is another minimum; if so, all deviations are ``None``
    elsewhere: bool


class Beyond(NamedTuple):
    """How well the time that was not fitted is predicted."""

    #: how long [s]
    seconds: float
    #: by the model
    model: Distance
    #: by damped sinusoids with as many free numbers or more
    sinusoids: Distance
    #: how many sinusoids
    n: int


@dataclass(frozen=True)
class Fit:
    """What `fit` found."""

    #: the scene with the values found
    scene: Scene
    #: each number by its name
    numbers: Mapping[str, Fitted]
    #: gain of the model in the recording
    gain: float
    #: its delay there [s]
    delay: float
    #: how many renders it took
    renders: int
    #: how much of the recording was fitted [s]
    seconds: float
    #: which distance decided
    stage: Literal["levels", "samples"]
    #: whether the search arrived; if not, all deviations are ``None``
    settled: bool
    #: whether so little is left that the sound may be one of this model; if not, all deviations are ``None``
    explained: bool
    #: pitches of the recording and of the model
    pitch: Pitch
    #: what somebody should know of the values, a sentence each
    warnings: tuple[str, ...]
    #: distance before
    before: Distance
    #: and after
    after: Distance
    #: that of what was not fitted, where there is enough of it
    beyond: Beyond | None


def fit(
    scene: Scene,
    target: Path | npt.ArrayLike,
    vary: Sequence[str],
    *,
    sr: float | None = None,
    ranges: Mapping[str, tuple[object, object]] | None = None,
    seconds: float | str | None = None,
    gain: float | None = None,
    renders: int = 60,
    gesture: Gesture = None,
    report: Path | None = None,
    progress: Progress | None = None,
) -> Fit:
    """Finds numbers of a model by a recorded sound, as ``ca fit`` does.

    Args:
        scene: where the search starts.
        target: a WAV or FLAC file, or samples ``(frames,)`` or ``(frames, channels)``.
        vary: names of numbers, as `Scene.replace` knows them.
        sr: rate of samples [Hz]; that of the scene if none. A file has its own.
        ranges: how far a number may go, from and to, numbers or text with units.
        seconds: how much of the recording is fitted, from its onset on; up to 4 s if none.
        gain: of the model in the recording; found if none.
        renders: most renders of the model.
        gesture: as for `Scene.render`.
        report: where a page about the fit is written.
        progress: called with the renders so far and the most there may be.

    Raises:
        UsageError: no such number, one that cannot be varied, a range without it, or no renders.
        FailedError: the recording is silent or too short, or the model makes no sound.
        FileError: the recording cannot be read.

    >>> import cordis_anima as ca
    >>> r = ca.examples.string("113 Hz").render(0.3)
    >>> found = ca.fit(ca.examples.string(), r.audio, ["low.f"], sr=r.sr)
    >>> abs(found.numbers["low.f"].value - 113) < 0.01, found.renders < 60
    (True, True)
    """
    vary = [vary] if isinstance(vary, str) else list(vary)
    given: Any
    if isinstance(target, (str, os.PathLike)):
        if sr is not None:
            raise UsageError("`sr` is for samples; a file has its own rate")
        given = os.fspath(target)
    else:
        if np.iscomplexobj(target):
            raise UsageError("a recording is of real numbers")
        samples = np.asarray(target, dtype=np.float64)
        if samples.ndim == 1:
            samples = samples[:, None]
        transposed(samples)
        if samples.ndim != 2 or not samples.size or not np.isfinite(samples).all():
            raise UsageError("a recording is an array (frames,) or (frames, channels) of finite numbers")
        given = (float(scene.rate if sr is None else sr), np.ascontiguousarray(samples))
    renders = whole("renders", renders, 1, 2**32 - 1)
    pairs: list[tuple[str, str, str]] = []
    for name, ends in (ranges or {}).items():
        try:
            low, high = ends
        except (TypeError, ValueError):
            raise UsageError(f"ranges: `{name}` goes from one number to another: {ends!r} is not two") from None
        pairs.append((name, str(low), str(high)))
    model, raw = scene._model.fit(
        given,
        vary,
        ranges=pairs,
        seconds=None if seconds is None else length(seconds),
        gain=None if gain is None else number("gain", gain, ""),
        renders=renders,
        gesture=made(scene._compiled, gesture),
        report=report,
        progress=progress,
    )
    rate = given[0] if isinstance(given, tuple) else None
    beyond = raw.get("beyond")
    return Fit(
        scene=Scene._of(model, scene._asked[0] if rate is None else rate, False),
        numbers={name: Fitted(*rest) for name, *rest in raw["numbers"]},
        gain=raw["gain"],
        delay=raw["delay"],
        renders=raw["renders"],
        seconds=raw["seconds"],
        stage=raw["stage"],
        settled=raw["settled"],
        explained=raw["explained"],
        pitch=Pitch(*raw["pitch"]),
        warnings=tuple(raw["warnings"]),
        before=Distance(**raw["before"]),
        after=Distance(**raw["after"]),
        beyond=None
        if beyond is None
        else Beyond(
            beyond["seconds"], Distance(**beyond["model"]), Distance(**beyond["sinusoids"]), beyond["count"]
        ),
    )
