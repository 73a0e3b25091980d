"""Derivatives of the sound and the energy of a scene by its parameters."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from .. import _core
from .._errors import UsageError
from .._gestures import Gesture, made
from .._results import Floats, length, reals, transposed, whole

#: returns for a sound (frames, channels) the value of a loss, and its derivatives by each sample in the same shape
Loss = Callable[[Floats], "tuple[float, npt.ArrayLike]"]
#: direction of differentiation; `auto` is reverse, or forward for scenes that reverse mode does not support
Mode = Literal["auto", "reverse", "forward"]


@dataclass(frozen=True, eq=False)
class Tangents:
    """A sound with its derivatives.

    Attributes:
        audio: the sound (frames, channels), in double precision.
        tangents: its derivatives (frames, channels, parameters), per unit of the parameter.
        wrt: names of the parameters.
        values: their values (parameters).
        units: their SI units; empty for plain numbers.
        sr: sound rate [Hz].
    """

    audio: Floats
    tangents: Floats
    wrt: tuple[str, ...]
    values: Floats
    units: tuple[str, ...]
    sr: int

    def __getitem__(self, name: str) -> Floats:
        """Derivatives by one parameter (frames, channels)."""
        return self.tangents[:, :, _place(self.wrt, name)]

    def __repr__(self) -> str:
        frames, channels = self.audio.shape
        return f"<Tangents: {frames} frames x {channels} at {self.sr} Hz by {', '.join(self.wrt)}>"

    def gradient(self, cotangent: npt.ArrayLike) -> Floats:
        """Gradient (parameters) of a loss whose derivatives by the samples are `cotangent` (frames, channels)."""
        found: Floats = np.einsum("fc,fcp->p", _cotangent(cotangent, self.audio.shape), self.tangents)
        return found


#: energy accounts, by their names in `Energy`
_ACCOUNTS = ("start", "stored", "lost", "made", "work", "changed", "residual")


@dataclass(frozen=True, eq=False)
class EnergyTangents:
    """Energy accounts with their derivatives, at some instants.

    ``stored = start + work − lost + made + changed + residual`` holds for the accounts and for their derivatives.

    Attributes:
        energy: each account (instants) [J], by its name in `Energy`: ``"start"``, ``"stored"``, ``"lost"``, ``"made"``,
            ``"work"``, ``"changed"`` and ``"residual"``.
        tangents: its derivatives (instants, parameters) [J] per unit of the parameter, by the same names.
        seconds: time covered by the ledger (instants) [s]; a tick is booked when the next one begins.
        wrt: names of the parameters.
        values: their values (parameters).
        units: their SI units; empty for plain numbers.
    """

    energy: Mapping[str, Floats]
    tangents: Mapping[str, Floats]
    seconds: Floats
    wrt: tuple[str, ...]
    values: Floats
    units: tuple[str, ...]

    def __getitem__(self, name: str) -> dict[str, Floats]:
        """Derivatives of each account (instants) by one parameter."""
        place = _place(self.wrt, name)
        return {account: all[:, place] for account, all in self.tangents.items()}

    def __repr__(self) -> str:
        return f"<EnergyTangents: {len(self.seconds)} instants by {', '.join(self.wrt)}>"


@dataclass(frozen=True, eq=False)
class Gradient:
    """A gradient of a loss.

    Attributes:
        loss: value of the loss; ``None`` if its cotangent was given.
        gradient: its derivatives (parameters), per unit of the parameter.
        wrt: names of the parameters.
        values: their values (parameters).
        units: their SI units; empty for plain numbers.
        inputs: derivatives by the input of each port in each sample (frames), per m or N, by port name. For a device
            they are at the samples in which its frames end, and at the last one. Ports that position a moving point,
            devices with a `latency`, and forward mode have none.
        mode: ``"reverse"`` or ``"forward"``.
    """

    loss: float | None
    gradient: Floats
    wrt: tuple[str, ...]
    values: Floats
    units: tuple[str, ...]
    inputs: Mapping[str, Floats]
    mode: str

    def __getitem__(self, name: str) -> float:
        """Derivative by one parameter."""
        return float(self.gradient[_place(self.wrt, name)])

    def __repr__(self) -> str:
        by = ", ".join(f"{name}: {slope:.6g}" for name, slope in zip(self.wrt, self.gradient))
        inputs = f"; inputs {', '.join(self.inputs)}" if self.inputs else ""
        loss = "" if self.loss is None else f"loss {self.loss:.6g}, "
        return f"<Gradient: {loss}{by or 'no parameters'}{inputs}, {self.mode} mode>"


def _place(names: Sequence[str], name: str) -> int:
    if name not in names:
        raise UsageError(f"no derivative by `{name}` was computed, only by {', '.join(f'`{n}`' for n in names)}")
    return names.index(name)


def _cotangent(given: npt.ArrayLike, shape: tuple[int, ...] | None) -> Floats:
    values = reals("cotangent", given)
    if values.ndim == 1:
        values = values[:, np.newaxis]
    if shape is None:
        transposed(values)
    if values.ndim != 2 or (shape is not None and values.shape != shape):
        wanted = "(frames, channels)" if shape is None else str(shape)
        turned = "; transpose it with `.T`" if values.shape[::-1] == shape else ""
        raise UsageError(f"the cotangent has the shape {np.shape(given)}; it must be {wanted}{turned}")
    return np.ascontiguousarray(values)


def named(wrt: object) -> list[str]:
    """Checks names of parameters, at least one.

    Raises:
        UsageError: if they are not names.
    """
    names: list[Any] = [wrt] if isinstance(wrt, str) or not isinstance(wrt, Iterable) else list(wrt)
    if not names or not all(isinstance(name, str) for name in names):
        what = f"wrt = {wrt!r}: must be" if names else "`wrt` is empty; it needs"
        raise UsageError(f"{what} names of parameters, e.g. [\"low.f\"]")
    return names


def _about(forward: _core.Forward | _core.Energy | _core.Reverse) -> tuple[tuple[str, ...], Floats, tuple[str, ...]]:
    all = forward.parameters
    return tuple(p[0] for p in all), np.array([p[1] for p in all], float), tuple(p[2] for p in all)


class Derivatives:
    """Derivatives: a base class of `Scene`."""

    __slots__ = ()
    _compiled: _core.Scene

    def tangents(
        self, wrt: Sequence[str], seconds: float | str | None = None, *, gesture: Gesture = None
    ) -> Tangents:
        """Plays it with the derivatives of each sample by parameters, in forward mode.

        They are the exact derivatives of the ticks, not differences. The sound is the one before clipping at full scale
        by `render`.

        Args:
            wrt: names as for `replace`, e.g. ``"low.f"``, ``"hammer.v"``, and entries of lists, e.g. ``"ball.v[1]"``.
            seconds: as for `render`.
            gesture: as for `render`; it drives ports.

        Raises:
            UsageError: if a name does not exist, is a whole number, a word or a flag (they cannot be differentiated),
                or changes the structure of the scene. Also for groups at the gesture rate, parameters driven by
                gestures, and a scene that diverges.

        >>> import cordis_anima as ca
        >>> t = ca.examples.string().tangents(["hammer.v", "low.f"], 0.1)
        >>> t.audio.shape, t.tangents.shape, t["low.f"].shape, t.units
        ((4800, 1), (4800, 1, 2), (4800, 1), ('m/s', 'Hz'))
        """
        seconds = None if seconds is None else length(seconds)
        forward, about = self._forward(wrt), self._compiled.about()
        audio, all = forward.tangents(seconds, made(self._compiled, gesture))
        names, values, units = _about(forward)
        return Tangents(audio=audio, tangents=all, wrt=names, values=values, units=units, sr=round(about["rate"]))

    def energy_tangents(
        self, wrt: Sequence[str], seconds: float | str | None = None, *, gesture: Gesture = None, instants: int = 1
    ) -> EnergyTangents:
        """Plays it with the energy ledger and the derivatives of its accounts by parameters, in forward mode.

        Args:
            wrt: as for `tangents`.
            seconds: as for `render`.
            gesture: as for `tangents`.
            instants: number of evenly spaced instants with accounts; the last is the end, and 1 is the end alone.

        Raises:
            UsageError: as for `tangents`; also for a scene without a ledger (`method = "pefrl"`), and if `instants` is
                0 or above the number of samples.

        >>> import cordis_anima as ca
        >>> t = ca.examples.string().energy_tangents(["hammer.v", "hammer.m"], 0.1, instants=4)
        >>> t.tangents["lost"].shape, t["hammer.v"]["stored"].shape, t.units
        ((4, 2), (4,), ('m/s', 'kg'))
        >>> v, start = t.values[0], t.energy["start"][-1]    # ½ m v² at load
        >>> bool(abs(t["hammer.v"]["start"][-1] * v / 2 - start) < 1e-9 * start)
        True
        """
        seconds = None if seconds is None else length(seconds)
        many = whole("instants", instants, 1, 2**53)
        energy = self._compiled.energy_forward(named(wrt))
        covered, values, all = energy.tangents(seconds, made(self._compiled, gesture), many)
        names, given, units = _about(energy)
        return EnergyTangents(
            energy={name: values[:, k] for k, name in enumerate(_ACCOUNTS)},
            tangents={name: all[:, k, :] for k, name in enumerate(_ACCOUNTS)},
            seconds=covered,
            wrt=names,
            values=given,
            units=units,
        )

    def gradient(
        self,
        wrt: Sequence[str] = (),
        *,
        loss: Loss | None = None,
        cotangent: npt.ArrayLike | None = None,
        seconds: float | str | None = None,
        gesture: Gesture = None,
        mode: Mode = "auto",
    ) -> Gradient:
        """Computes the gradient of a loss of its sound, by parameters and by the inputs of ports.

        It stores no derivatives of samples. In reverse mode it takes as long as a few renders, however many parameters
        there are, and about ten times longer if nearly all links are non-linear; each parameter adds a few compilations
        of the model. In forward mode its time grows with the number of parameters. Both give the same result, to
        rounding.

        Args:
            wrt: as for `tangents`; empty if only `inputs` are wanted.
            loss: called with the sound (frames, channels) in double precision; returns the loss, and its derivatives by
                each sample.
            cotangent: these derivatives (frames, channels), instead of a loss; its length is the length played.
            seconds: as for `render`, with a loss.
            gesture: as for `tangents`.
            mode: ``"reverse"``, ``"forward"``, or ``"auto"``: reverse, or forward for scenes that reverse mode does not
                support (waveguides, several ticks per sample, and those named in docs/numerics.md §9).

        Raises:
            UsageError: as for `tangents`; also if both or neither of loss and cotangent are given, if a shape is wrong,
                or with ``mode="reverse"`` for a scene that does not support it; the message says why.

        >>> import cordis_anima as ca
        >>> g = ca.examples.string().gradient(["hammer.v"], loss=lambda y: ((y**2).sum(), 2 * y), seconds=0.1)
        >>> g.loss > 0, g["hammer.v"] > 0
        (True, True)
        >>> bar = ca.parse("[CEL]\\nbar = { m = '1 g', f = '220 Hz', t60 = '1 s' }\\n[ENF]\\npush = { to = 'bar' }\\n[SOX]\\nout = { from = 'bar' }\\n")
        >>> g = bar.gradient(cotangent=np.ones(480), gesture={"push": [[0, 0], [0.01, 1.0]]})
        >>> g.inputs["push"].shape, g.mode
        ((480,), 'reverse')
        """
        if mode not in ("auto", "reverse", "forward"):
            raise UsageError(f"mode = {mode!r}: must be `auto`, `reverse` or `forward`")
        if cotangent is not None and (loss is not None or seconds is not None):
            raise UsageError("`cotangent` replaces `loss` and `seconds`; leave these out")
        seconds = None if seconds is None else length(seconds)
        way, driven = self._way(wrt, mode), made(self._compiled, gesture)
        # a port may be moving at load, which depends on the gesture
        if mode == "auto" and isinstance(way, _core.Reverse) and way.parameters and not way.knows(driven):
            way = self._forward(wrt)
        value, played = None, None
        if loss is not None:
            if not callable(loss):
                raise UsageError("`loss` must be a function of the sound, which returns its value and derivatives by each sample")
            if isinstance(way, _core.Reverse):
                audio, played = way.play(seconds, driven)
            else:
                audio = way.audio(seconds, driven)
            found = loss(audio)
            if not isinstance(found, tuple) or len(found) != 2:
                raise UsageError(f"`loss` must return its value and its derivatives by each sample, not {type(found).__name__}")
            value, of = found
            try:
                value = float(value)
            except (TypeError, ValueError):
                raise UsageError(f"the value of a loss must be a number, not {type(value).__name__}") from None
            given = _cotangent(of, audio.shape)
        elif cotangent is not None:
            given = _cotangent(cotangent, None)
        else:
            raise UsageError("a gradient needs a `loss` or a `cotangent`; use `tangents` for the derivatives of each sample")
        names, values, units = _about(way)
        inputs: dict[str, Floats] = {}
        if isinstance(way, _core.Reverse):
            slopes, all = way.gradient(given, driven) if played is None else played.gradient(given)
            inputs = {name: all[:, k] for k, name in enumerate(way.ports)}
        else:
            slopes = way.gradient(given, driven)
        return Gradient(
            value,
            gradient=slopes,
            wrt=names,
            values=values,
            units=units,
            inputs=inputs,
            mode="reverse" if isinstance(way, _core.Reverse) else "forward",
        )

    def _way(self, wrt: Sequence[str], mode: Mode) -> _core.Forward | _core.Reverse:
        names = [] if isinstance(wrt, (tuple, list)) and not wrt else named(wrt)
        if mode != "forward":
            try:
                way = self._compiled.reverse(names)
                if names or way.ports:
                    return way
            except UsageError:
                if mode == "reverse" or not names:
                    raise
        # without names, forward mode has nothing to compute
        return self._compiled.forward(named(names))

    def _forward(self, wrt: Sequence[str]) -> _core.Forward:
        return self._compiled.forward(named(wrt))
