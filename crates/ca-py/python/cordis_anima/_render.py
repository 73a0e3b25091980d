"""Results of a render, and live parameters."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ._page import html as _html
from ._results import Energy, Floats, Param, Sound, Status
from ._page.view import View


@dataclass(frozen=True, repr=False, eq=False)
class Render:
    """Result of rendering a scene.

    >>> import cordis_anima as ca
    >>> r = ca.examples.string().render(0.5, probes=["low[8]", "low[*]"])
    >>> r.audio.shape, r.audio.dtype, r.sr, r.status
    ((24000, 1), dtype('float32'), 48000, 'ok')
    >>> r.probes["low[8]"].shape, r.probes["low[*]"].shape, r.columns["low[*]"][0], r.units["low[*]"]
    ((24000,), (24000, 40), 'low[0]', 'm')
    """

    #: sound (frames, channels), within ±1; louder samples are clipped and counted in `clipped`
    audio: Sound
    #: sound rate [Hz]
    sr: int
    #: length [s]
    seconds: float
    #: names of the channels
    channels: tuple[str, ...]
    #: displacement [m] of masses or force [N] of links, by selector; (frames,), or (frames, n) if a selector chose
    #: several
    probes: Mapping[str, Floats]
    #: names of the columns of each probe
    columns: Mapping[str, tuple[str, ...]]
    #: unit of each probe: ``m`` or ``N``
    units: Mapping[str, str]
    #: energy ledger, with `energy=True`
    energy: Energy | None
    #: ``ok``; ``unstable``: it diverged; ``clipped``: louder than full scale; ``refused``: an input was not finite;
    #: ``mute``: neither outputs nor probes; ``gained``, with `energy=True`: the scheme made more energy than it
    #: received
    status: Status
    #: what is wrong and how to fix it; empty if nothing is
    message: str
    #: time of divergence [s], and the module that caused it
    failed: tuple[float, str] | None
    #: largest |sample| of each channel before clipping
    peak: Floats
    #: number of samples clipped at ±1
    clipped: int
    #: number of non-finite samples, which were replaced by silence
    non_finite: int
    #: computation time [s]
    run_time: float
    #: replays the same and records its motion
    _view: Callable[[], View]

    @property
    def rtf(self) -> float:
        """Computation time divided by length; below 1 is faster than real time."""
        return self.run_time / self.seconds

    def view(self) -> View:
        """Shows the moving instrument in step with the sound. See `Scene.view`.

        The scene is played again with the same gesture, because a render does not store positions.

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
    """Live parameters by name, read only. To change them in a running scene, use `Sim.params`.

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
