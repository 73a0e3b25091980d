"""Measurements of a scene without a render: modes, matrices, accuracy."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

from .. import _core
from .._errors import UsageError
from .gradient import named
from .linear import Linear
from .mode_derivatives import derivatives
from .._results import Accuracy, ModeDerivatives, Modes, number

#: called with the work done and in total; an exception ends the call
Progress = Callable[[int, int], object]


class Measured:
    """Measurements: a base class of `Scene`."""

    __slots__ = ()
    _compiled: _core.Scene
    _model: _core.Model
    _asked: tuple[float | None, bool]

    def modes(self) -> Modes:
        """Computes the modes of its linear part: frequency, decay, shape, and level at ports.

        >>> import cordis_anima as ca
        >>> m = ca.load("harmonic_chain").modes()
        >>> bool((m.heard > 0).all()), m.shapes.shape == (len(m), len(m.places))
        (True, True)
        """
        raw = self._model.modes(self._asked[0])
        return Modes(**_frozen(raw), _derivative=partial(self._of_modes, raw))

    def _of_modes(self, raw: Mapping[str, Any], wrt: Sequence[str]) -> ModeDerivatives:
        def moved(name: str, value: float, unit: str) -> Linear:
            model = self._model.copy()
            model.set(name, f"{value!r} {unit}" if unit else value)
            return Linear._of(model.linear(self._asked[0]))

        parameters = self._compiled.forward(named(wrt)).parameters
        return derivatives(self.linear(), (raw["heard"], raw["t60"], raw["shapes"]), parameters, moved)

    def linear(self) -> Linear:
        """Returns the linear part of the scene at load as sparse matrices, which can compute a tick.

        Needs SciPy: ``pip install "cordis-anima[linear]"``.

        >>> import cordis_anima as ca, numpy as np
        >>> part = ca.load("harmonic_chain").linear()
        >>> part.K.shape == part.M.shape == (len(part), len(part)), bool((part.M.diagonal() > 0).all())
        (True, True)
        """
        return Linear._of(self._model.linear(self._asked[0]))

    def accuracy(
        self,
        seconds: float | str | None = None,
        *,
        times: Sequence[int] = (1, 2, 4),
        reference: int = 32,
        probes: Sequence[str] = (),
        progress: Progress | None = None,
    ) -> Accuracy:
        """Measures error and run time of all methods that the scene supports, at multiples of its rate.

        Args:
            seconds: length to play; default: as given by the model, up to one second.
            times: multiples of the sound rate.
            reference: multiple of the rate for the reference, itself a multiple of 4.
            probes: modules to compare; default: the modules of the outputs.

        >>> import cordis_anima as ca
        >>> a = ca.examples.string().accuracy(0.02, times=[1], reference=4)
        >>> a.method[0], len(a) == len(a.error) == len(a.ns)
        ('as written', True)
        """
        seconds = None if seconds is None else number("seconds", seconds, "s")
        times = [int(t) for t in times]
        if not times or min(times) < 1 or max(times) > 1_000_000 or not 4 <= reference <= 1_000_000 or reference % 4:
            raise UsageError("`times` must be whole numbers from 1 to 1000000, and `reference` a multiple of 4 up to 1000000")
        probes = [probes] if isinstance(probes, str) else list(probes)
        raw = self._model.accuracy(
            rate=self._asked[0], seconds=seconds, probes=probes, times=times, reference=reference, progress=progress
        )
        return Accuracy(**_frozen(raw))


def _frozen(raw: Mapping[str, Any]) -> dict[str, Any]:
    """Replaces lists by tuples."""
    return {k: tuple(v) if isinstance(v, list) else v for k, v in raw.items()}
