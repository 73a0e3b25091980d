"""What is heard of a scene."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ._page import html as _html
from ._results import Energy, Floats, Param, Sound, Status
from ._page.view import View


@dataclass(frozen=True, repr=False, eq=False)
class Render:
    """What was heard of a scene.

    >>> import cordis_anima as ca
    >>> r = ca.examples.string().render(0.5, probes=["low[8]", "low[*]"])
    >>> r.audio.shape, r.audio.dtype, r.sr, r.status
    ((24000, 1), dtype('float32'), 48000, 'ok')
    >>> r.probes["low[8]"].shape, r.probes["low[*]"].shape, r.columns["low[*]"][0], r.units["low[*]"]
    ((24000,), (24000, 40), 'low[0]', 'm')
    """

    #: sound (frames, channels), within ±1; what was louder is counted in `clipped`
    audio: Sound
    #: sound rate [Hz]
    sr: int
    #: length [s]
    seconds: float
    #: names of the channels
    channels: tuple[str, ...]
    #: what was listened to besides, by its selector: displacement [m] of a mass, force [N] of a link; (frames,), or
    #: (frames, n) where a selector chose several
    probes: Mapping[str, Floats]
    #: names of the columns of each probe
    columns: Mapping[str, tuple[str, ...]]
    #: unit of each probe: ``m`` or ``N``
    units: Mapping[str, str]
    #: the energy ledger, where `energy=True` asked for it
    energy: Energy | None
    #: ``ok``; ``unstable``, it diverged; ``clipped``, louder than full scale; ``refused``, an input had no value; ``mute``,
    #: neither outputs nor probes; ``gained``, with `energy=True`: the scheme made more energy than it received
    status: Status
    #: what is wrong and what to do; empty where nothing is
    message: str
    #: when it diverged [s], and the module to blame
    failed: tuple[float, str] | None
    #: greatest |sample| of each channel before the ceiling
    peak: Floats
    #: samples cut off at ±1
    clipped: int
    #: samples without a value, which became silence
    non_finite: int
    #: time it took [s]
    run_time: float
    #: plays the same once more and keeps how it moves
    _view: Callable[[], View]

    @property
    def rtf(self) -> float:
        """Run time over length: below 1 is faster than real time."""
        return self.run_time / self.seconds

    def view(self) -> View:
        """The moving instrument in step with what is heard: the scene is played once more by the same gesture, since positions
        are not kept. See `Scene.view`.

        >>> import cordis_anima as ca
        >>> ca.load("rattle").render(0.2).view().html.startswith("<!DOCTYPE html>")
        True
        """
        return self._view()

    def __repr__(self) -> str:
        n, c = self.audio.shape
        peak = 20 * np.log10(self.peak.max()) if self.peak.size and self.peak.max() > 0 else -np.inf
        what = f"<Render: {n} frames x {c} at {self.sr} Hz, peak {peak:.1f} dBFS, {self.status}"
        return f"{what}: {self.message}>" if self.message else f"{what}>"

    def _repr_html_(self) -> str:
        return _html.render(repr(self)[1:-1], self.audio, self.sr, self.channels)


class Params(Mapping[str, Param]):
    """Live parameters by name, read only; those of a running scene are changed at `Sim.params`.

    >>> import cordis_anima as ca
    >>> bow = ca.examples.bowed_string().params
    >>> all(p.min <= p.value <= p.max for p in bow.values())
    True
    """

    def __init__(self, all: Sequence[Param]) -> None:
        self._all = {p.name: p for p in all}

    def __getitem__(self, name: str) -> Param:
        return self._all[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._all)

    def __len__(self) -> int:
        return len(self._all)

    def __repr__(self) -> str:
        one = (f"{p.name} = {p.value:g} {p.unit} ({p.min:g} … {p.max:g}){': ' + p.doc if p.doc else ''}" for p in self.values())
        return "\n".join(one) or "no live parameters"
