"""Virtual instruments made of masses and interactions: build, render, play and measure them.

>>> import cordis_anima as ca
>>> r = ca.load("hammered_string").render(2)
>>> r.audio.shape, r.sr
((96000, 2), 48000)

Sound arrays have the shape ``(frames, channels)``, in float32 as `soundfile` and `sounddevice` expect, or as `dtype`
says. Values are in SI units. Errors in a model are raised as `ModelError`, which shows their place in the text.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import NamedTuple

from . import _core, examples
from ._sweeps.batch import Batch, batch
from ._errors import CaError, Diagnostic, FailedError, FileError, MissingError, ModelError, UnstableError, UsageError
from ._analysis.fit import Beyond, Distance, Fit, Fitted, fit
from ._gestures import Curve, Gesture, Points
from ._analysis.gradient import EnergyTangents, Gradient, Tangents
from ._analysis.linear import Linear, Rollout
from ._analysis.measured import Progress
from ._model import Check, Model
from ._page.play import Playing
from ._render import Params, Render
from ._results import Accuracy, Certificate, Energy, ModeDerivatives, Modes, Param, Port
from ._scene import Scene
from ._sim import Block, Inputs, Sim, Snapshot
from ._sweeps.sweep import Range, Sweep, sweep
from ._take import Fault, Hand, Take, Verdict, record
from ._page.view import View

__version__: str = _core.VERSION

__all__ = [
    "Accuracy",
    "Batch",
    "Beyond",
    "Block",
    "CaError",
    "Certificate",
    "Check",
    "Curve",
    "Diagnostic",
    "Distance",
    "Energy",
    "EnergyTangents",
    "FailedError",
    "Fault",
    "FileError",
    "Fit",
    "Fitted",
    "Gesture",
    "Gradient",
    "Hand",
    "Inputs",
    "Kind",
    "Linear",
    "MissingError",
    "ModeDerivatives",
    "Model",
    "ModelError",
    "Modes",
    "Param",
    "Params",
    "Playing",
    "Points",
    "Port",
    "Progress",
    "Range",
    "Render",
    "Rollout",
    "Scene",
    "Sim",
    "Snapshot",
    "Sweep",
    "Take",
    "Tangents",
    "UnstableError",
    "UsageError",
    "Verdict",
    "View",
    "batch",
    "examples",
    "fit",
    "kinds",
    "load",
    "parse",
    "record",
    "sweep",
]


class Kind(NamedTuple):
    """A kind of module."""

    #: section of a model file, e.g. ``MAS``
    code: str
    #: short title
    title: str
    #: law in one line
    equation: str
    #: ``MAT``, ``LIA``, ``port`` or ``generator``
    family: str
    #: parameters: name, unit and documentation
    params: tuple[tuple[str, str, str], ...]


def kinds() -> dict[str, Kind]:
    """Returns all kinds of modules, by code.

    >>> import cordis_anima as ca
    >>> ca.kinds()["RES"].equation
    'F = k e'
    """
    return {k[0]: Kind(*k[:4], tuple(k[4])) for k in _core.kinds()}


def load(
    source: str | os.PathLike[str], changes: Mapping[str, object] | None = None, *, rate: float | str | None = None
) -> Scene:
    """Compiles a scene from a file ``*.ca.toml``, a MIMS file ``*.mdl``, or a bundled model.

    Args:
        source: path of the file, or name of a bundled model; ``examples.names()`` lists the names.
        changes: values set before compilation, e.g. ``{"hammer.m": "30 g"}``.
        rate: sound rate [Hz], or text such as ``"96 kHz"``; default: the rate of the model.

    Raises:
        UsageError: if the model does not exist; the message suggests the nearest name.
        FailedError: if the file cannot be read.
        ModelError: if the model has errors.

    >>> import cordis_anima as ca
    >>> ca.load("rattle").title
    'The rattle, on two keys'
    """
    model = Model.load(source)
    for name, value in (changes or {}).items():
        model.set(name, value)
    return model.compile(rate=rate)


def parse(text: str, *, file: str = "model.ca.toml", rate: float | str | None = None) -> Scene:
    """Compiles a scene from the text of a model.

    >>> import cordis_anima as ca
    >>> ca.parse('[CEL]\\nbar = { m = "2 g", f = "440 Hz", dx0 = "1 mm" }\\n[SOX]\\nout = { from = "bar" }\\n').n_mat
    1
    """
    return Model.parse(text, file).compile(rate=rate)
