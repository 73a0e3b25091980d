"""Fits numbers of a model to a recorded sound."""

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
    """Distance of a model from a recording."""

    #: root mean square of the differences of levels [dB]
    levels: float
    #: residual of the samples, relative to the recording [dB]
    samples: float


class Fitted(NamedTuple):
    """A fitted number, in SI units."""

    #: fitted value
    value: float
    #: one standard deviation; ``None`` if the sound does not determine it, the search has not settled or may be in
    #: another minimum, or the model does not explain the sound
    deviation: float | None
    #: unit; empty for a plain number
    unit: str
    #: start value
    start: float
    #: true if it is at an end of its range
    at_end: bool


class Pitch(NamedTuple):
    """Pitches [Hz], from the period at which a sound repeats best; ``None`` for sounds without pitch."""

    #: pitch of the recording
    recording: float | None
    #: pitch of the model at the start
    start: float | None
    #: pitch of the fitted model
    found: float | None
    #: true if it started more than a semitone from the recording; deviations are then given only if the samples agree
    far: bool
    #: true if it ended at another pitch, i.e. in another minimum; all deviations are then ``None``
    elsewhere: bool


class Beyond(NamedTuple):
    """Prediction of the part of the recording after the fitted time."""

    #: length [s]
    seconds: float
    #: distance of the model
    model: Distance
    #: distance of damped sinusoids with at least as many free numbers
    sinusoids: Distance
    #: number of sinusoids
    n: int


@dataclass(frozen=True)
class Fit:
    """Result of `fit`."""

    #: scene with the fitted values
    scene: Scene
    #: fitted numbers by name
    numbers: Mapping[str, Fitted]
    #: gain of the model in the recording
    gain: float
    #: delay of the model in the recording [s]
    delay: float
    #: number of renders
    renders: int
    #: length of the recording that was fitted [s]
    seconds: float
    #: distance that decided
    stage: Literal["levels", "samples"]
    #: true if the search converged; if not, all deviations are ``None``
    settled: bool
    #: true if the residual is small enough for the sound to come from this model; if not, all deviations are ``None``
    explained: bool
    #: pitches of the recording and of the model
    pitch: Pitch
    #: warnings about the values, one sentence each
    warnings: tuple[str, ...]
    #: distance at the start
    before: Distance
    #: distance at the end
    after: Distance
    #: prediction of the rest of the recording, if it is long enough
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
    """Fits numbers of a model to a recorded sound, as ``ca fit`` does.

    Args:
        scene: start of the search.
        target: a WAV or FLAC file, or samples ``(frames,)`` or ``(frames, channels)``.
        vary: names of numbers, as for `Scene.replace`.
        sr: rate of the samples [Hz]; default: the rate of the scene. A file has its own.
        ranges: smallest and largest values of numbers, as numbers or text with units.
        seconds: length of the recording to fit, from its onset; default: up to 4 s.
        gain: gain of the model in the recording; default: fitted.
        renders: largest number of renders.
        gesture: as for `Scene.render`.
        report: path of a page about the fit.
        progress: called with the numbers of renders done and allowed.

    Raises:
        UsageError: if a number does not exist or cannot be varied, a range does not include its value, or no renders
            are allowed.
        FailedError: if the recording is silent or too short, or the model is silent.
        FileError: if the recording cannot be read.

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
            raise UsageError("`sr` is only for samples, because a file contains its rate; leave it out")
        given = os.fspath(target)
    else:
        if np.iscomplexobj(target):
            raise UsageError("a recording must contain real numbers")
        samples = np.asarray(target, dtype=np.float64)
        if samples.ndim == 1:
            samples = samples[:, None]
        transposed(samples)
        if samples.ndim != 2 or not samples.size or not np.isfinite(samples).all():
            raise UsageError("a recording must be an array (frames,) or (frames, channels) of finite numbers")
        given = (float(scene.rate if sr is None else sr), np.ascontiguousarray(samples))
    renders = whole("renders", renders, 1, 2**32 - 1)
    pairs: list[tuple[str, str, str]] = []
    for name, ends in (ranges or {}).items():
        try:
            low, high = ends
        except (TypeError, ValueError):
            raise UsageError(f"ranges: the range of `{name}` must be two numbers, not {ends!r}") from None
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
