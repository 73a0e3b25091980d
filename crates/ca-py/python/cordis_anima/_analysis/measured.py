"""What is measured of a scene without hearing it: modes, matrices, accuracy."""

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

#: called with what is done and how much there is; an exception ends the call
Progress = Callable[[int, int], object]


class Measured:
    """The part of `Scene` that measures."""

    __slots__ = ()
    _compiled: _core.Scene
    _model: _core.Model
    _asked: tuple[float | None, bool]

    def modes(self) -> Modes:
        """Modes of its linear part: frequencies with and without the scheme, decay, shapes, and levels at ports.

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
        """The linear part of the scene at load as sparse matrices, and a tick made of them. Needs SciPy: ``pip install
        "cordis-anima[linear]"``.

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
        """Error against run time over all methods the scene can take, at multiples of its rate.

        Args:
            seconds: how long it is played; without, as the model says, up to one second.
            times: multiples of the sound rate.
            reference: that of the reference, a multiple of 4.
            probes: what is compared; without, what the outputs listen to.

        >>> import cordis_anima as ca
        >>> a = ca.examples.string().accuracy(0.02, times=[1], reference=4)
        >>> a.method[0], len(a) == len(a.error) == len(a.ns)
        ('as written', True)
        """
        seconds = None if seconds is None else number("seconds", seconds, "s")
        times = [int(t) for t in times]
        if not times or min(times) < 1 or max(times) > 1_000_000 or not 4 <= reference <= 1_000_000 or reference % 4:
            raise UsageError("`times` are whole numbers from 1 on, `reference` is a multiple of 4")
        probes = [probes] if isinstance(probes, str) else list(probes)
        raw = self._model.accuracy(
            rate=self._asked[0], seconds=seconds, probes=probes, times=times, reference=reference, progress=progress
        )
        return Accuracy(**_frozen(raw))


def _frozen(raw: Mapping[str, Any]) -> dict[str, Any]:
    """With tuples in place of lists."""
    return {k: tuple(v) if isinstance(v, list) else v for k, v in raw.items()}
