"""Compiled scenes: rendering, playing and measuring."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any, Literal

import numpy as np

from . import _core
from ._page import html as _html
from ._errors import Diagnostic, UnstableError, UsageError, diagnostics
from ._gestures import Gesture, Path, made
from ._analysis.gradient import Derivatives
from ._analysis.linear import Rollout
from ._analysis.measured import Measured, Progress
from ._probes import chosen, columns
from ._render import Params, Render
from ._results import Certificate, DType, Param, Port, Status, is_double, length, number, value
from ._results import energy as _energy
from ._page.play import Playing
from ._sim import Sim
from ._page.view import View

#: kinds whose probe is a force
_FORCES = {"SOF", *(code for code, _, _, family, _ in _core.kinds() if family == "LIA")}


class Scene(Measured, Derivatives):
    """A compiled model, ready to play. Scenes are immutable: `replace` returns another one.

    Two scenes are equal if the same values are written in the same order; comments, whitespace and file names do not
    matter. Scenes can be pickled, copied, used as dictionary keys, and shared between threads.

    >>> import cordis_anima as ca
    >>> a = ca.load("hammered_string")
    >>> b = a.replace({"hammer.m": "30 g"})
    >>> a == b, a == ca.load("hammered_string"), len({a, b})
    (False, True, 2)
    """

    __slots__ = ("_asked", "_compiled", "_hash", "_model")
    _model: _core.Model
    _compiled: _core.Scene
    _asked: tuple[float | None, bool]
    _hash: str | None

    def __init__(self, *_: object, **__: object) -> None:
        raise UsageError("use `ca.load`, `ca.parse` or `Model.compile` to make a scene")

    @classmethod
    def _of(cls, model: _core.Model, rate: float | str | None, exact: bool) -> Scene:
        made = cls.__new__(cls)
        rate = None if rate is None else number("rate", rate, "Hz")
        made._model, made._asked, made._hash = model, (rate, exact), None
        made._compiled = model.compile(rate=rate, exact=exact)
        return made

    # properties

    @property
    def name(self) -> str:
        """Name of its file, without folder and extension."""
        return self._model.name

    @property
    def title(self) -> str:
        """Title given by its author."""
        return self._model.title

    @property
    def sr(self) -> int:
        """Sound rate [Hz], rounded to a whole number as in sound files."""
        return round(self.rate)

    @property
    def rate(self) -> float:
        """Sound rate [Hz]."""
        return float(self._compiled.about()["rate"])

    @property
    def gesture_rate(self) -> float:
        """Rate of gesture frames [Hz]."""
        return float(self._compiled.about()["gesture_rate"])

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the sound channels."""
        return tuple(self._compiled.about()["channels"])

    @property
    def inputs(self) -> tuple[Port, ...]:
        """Ports that a gesture can drive."""
        return tuple(Port(*p) for p in self._compiled.inputs)

    @property
    def params(self) -> Params:
        """Live parameters with unit, range and documentation."""
        return Params([Param(*p) for p in self._compiled.params])

    @property
    def presets(self) -> dict[str, dict[str, float]]:
        """Presets of the model by name: values of live parameters (SI). A scene begins with one by `replace`.

        >>> import cordis_anima as ca
        >>> m = ca.Model().param("k", "8 kN/m", live=True).add("MAS", "bob", m="1 g").add("SOL", "wall")
        >>> m = m.add("RES", "spring", between=["wall", "bob"], k="k").add("SOX", "out", from_="bob")
        >>> m.preset("soft", {"k": "2 kN/m"}).compile().presets
        {'soft': {'k': 2000.0}}
        >>> m.compile().replace({"preset": "soft"}).params["k"].value
        2000.0
        """
        return dict(self._compiled.presets)

    @property
    def n_mat(self) -> int:
        """Number of masses, cells and fixed points."""
        return int(self._compiled.about()["n_mat"])

    @property
    def n_lia(self) -> int:
        """Number of links."""
        return int(self._compiled.about()["n_lia"])

    @property
    def passes(self) -> tuple[tuple[str, int], ...]:
        """Passes of a tick: names and numbers of modules."""
        return tuple(self._compiled.about()["passes"])

    @property
    def left_out(self) -> tuple[str, ...]:
        """Modules left out by the compiler because they reach no output, as text."""
        return tuple(self._compiled.about()["left_out"])

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """Warnings and notes of the compiler."""
        return diagnostics(self._compiled.findings()[0])

    @property
    def certificate(self) -> Certificate:
        """Stability certificate.

        >>> import cordis_anima as ca
        >>> ca.load("harmonic_chain").certificate.level
        'proven'
        """
        return Certificate(**self._compiled.certificate())

    @property
    def hash(self) -> str:
        """BLAKE3 hash of the values in their order and of the sound rate: 64 hex digits, equal on every machine."""
        if self._hash is None:
            self._hash = self._compiled.digest()
        return self._hash

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Scene) and self.hash == other.hash

    def __hash__(self) -> int:
        return hash(self.hash)

    def __reduce__(self) -> tuple[Any, ...]:
        return (_again, (self._model.bytes(), self._model.name, *self._asked))

    def __repr__(self) -> str:
        about = self._compiled.about()
        title = self.title or self.name or "Scene"
        return (
            f"<Scene {title!r}: {about['n_mat']} MAT, {about['n_lia']} LIA at {about['rate']:g} Hz, "
            f"{self.certificate.level}>"
        )

    def _repr_html_(self) -> str:
        return _html.scene(repr(self)[1:-1], self.inputs, list(self.params.values()))

    # variants

    def replace(self, changes: Mapping[str, object] | None = None, *, rate: float | str | None = None) -> Scene:
        """Returns the same scene with other values.

        Values are numbers in the model's units or quantities, as for ``ca render --set``.

        Raises:
            UsageError: if a name does not exist; the message suggests the nearest.
            ModelError: if a value is invalid.

        >>> import cordis_anima as ca
        >>> ca.load("hammered_string").replace({"hammer.m": "30 g", "model.title": "heavy"}).title
        'heavy'
        """
        model = self._model.copy()
        for name, given in (changes or {}).items():
            model.set(name, value(name, given))
        asked, exact = self._asked
        return Scene._of(model, asked if rate is None else rate, exact)

    # rendering and running

    def within(
        self,
        error: float,
        seconds: float | str | None = None,
        *,
        times: Sequence[int] = (1, 2, 4),
        reference: int = 16,
        probes: Sequence[str] = (),
        progress: Progress | None = None,
    ) -> Scene:
        """Returns the scene computed by the cheapest proven method and rate with at most this relative RMS error.

        Measures first, see `accuracy`; the arguments are the same.

        Raises:
            UsageError: no method has so small an error, or the reference is not known as well.

        >>> import cordis_anima as ca
        >>> scene = ca.examples.string()
        >>> scene.within(0.9, 0.02, times=[1], reference=4).sr == scene.sr
        True
        """
        found = self.accuracy(seconds, times=times, reference=reference, probes=probes, progress=progress)
        best = found.cheapest(error)
        if best is None:
            why = f"the smallest is {min(found.error):.1e}, and the reference is accurate to {found.known:.1e}"
            raise UsageError(f"no method has an error of at most {error:g}: {why}")
        return self.replace(dict(self._model.changes(*best) or ()))

    def render(
        self,
        seconds: float | str | None = None,
        *,
        gesture: Gesture = None,
        probes: Sequence[str] = (),
        energy: bool = False,
        on_unstable: Literal["keep", "raise"] = "keep",
        dtype: DType = "float32",
        progress: Progress | None = None,
    ) -> Render:
        """Plays the scene to its end. Other threads run meanwhile, and Ctrl-C ends it.

        Args:
            seconds: length, as a number or text such as ``"1.5 s"``. Default: with a MIDI file in the gesture, until
                the file has ended and its sound has decayed, at most 10 s after its last event; otherwise the length
                given by the model, or until its gestures have decayed.
            gesture: drives ports and live parameters, instead of the built-in gestures of the same names. Either a
                mapping from names to numbers, breakpoints ``[(t, value), …]``, arrays at the sound rate, arrays with
                their rate, or files; or a file (CSV, NPY, WAV, MIDI, a take) whose tracks have these names.
            probes: selectors to record in addition: ``"low[3]"``, ``"strike"``, ``"low[*]"``.
            energy: record the energy ledger; slightly slower.
            on_unstable: ``"raise"`` raises `UnstableError` if it diverges; ``"keep"`` returns silence from then on.
            dtype: type of sound samples, ``"float32"`` or, with the full precision of the engine, ``"float64"``.
            progress: called regularly with the numbers of frames done and in total.

        Raises:
            UsageError: if a name is neither a port nor a live parameter, or if values, length or options are invalid.
            FileError: if a gesture file cannot be read.
            ModelError: if a probe matches no module.
            UnstableError: if it diverges, with ``on_unstable="raise"``.

        >>> import cordis_anima as ca
        >>> key = ca.load("hammered_string")
        >>> r = key.render(1.0, gesture={"key": [(0, -0.008), (0.02, 0), (0.5, -0.008)]}, energy=True)
        >>> r.status, abs(r.energy.residual) < 1e-9 * r.energy.peak
        ('ok', True)
        """
        seconds = None if seconds is None else length(seconds)
        if on_unstable not in ("keep", "raise"):
            raise UsageError(f"on_unstable = {on_unstable!r}: must be \"keep\" or \"raise\"")
        probes = [probes] if isinstance(probes, str) else list(probes)
        core = self._listening(probes, energy)
        raw = core.render(seconds, made(self._compiled, gesture), is_double(dtype), progress)
        about = core.about()
        status: Status = raw["status"]
        message, failed = raw["message"], raw["failed"]
        if failed is not None and on_unstable == "raise":
            raise UnstableError(message, *failed)
        if status == "clipped":
            # a render also suggests a gain
            reported = []
            if raw["clipped"]:
                reported.append(f"{raw['clipped']} samples beyond full scale; multiply the gain by {raw['gain']:g} or less")
            if raw["non_finite"]:
                reported.append(f"{raw['non_finite']} samples were not finite and were replaced by silence")
            message = "; ".join(reported)
        places, names = columns(raw["probe_of"], probes), raw["probe_names"]
        return Render(
            audio=raw["audio"],
            sr=round(about["rate"]),
            seconds=len(raw["audio"]) / about["rate"],
            channels=tuple(about["channels"]),
            probes=chosen(raw["probes"], places),
            columns={selector: tuple(names[c] for c in of) for selector, of in places.items()},
            units={selector: self._unit(selector) for selector in probes},
            energy=_energy(raw["energy"]) if "energy" in raw else None,
            status=status,
            message=message,
            failed=failed,
            _view=partial(self.view, seconds, gesture=gesture),
            peak=raw["peak"],
            clipped=raw["clipped"],
            non_finite=raw["non_finite"],
            run_time=raw["run_time"],
        )

    def _unit(self, selector: str) -> str:
        """Unit of a probe: N for links and outputs of force, m for all else."""
        name, index, _ = selector.partition("@")[0].partition("[")
        name = name.strip()
        inner = bool(index) and name.endswith(".link")
        return "N" if inner or any(item == name and kind in _FORCES for kind, item in self._model.items) else "m"

    def open(
        self, *, block: int = 512, energy: bool = False, probes: Sequence[str] = (), dtype: DType = "float32"
    ) -> Sim:
        """Opens a running scene, to play block by block, or frame by frame with `block=1`. See `Sim`.

        Args:
            block: default number of samples in a block.
            energy: keep the energy ledger, readable from `Sim.energy` at any time.
            probes: selectors to record in addition, as for `render`; each block has them in `Block.probes`.
            dtype: type of sound samples, ``"float32"`` or ``"float64"``.

        Raises:
            ModelError: if a probe matches no module.

        >>> import cordis_anima as ca
        >>> with ca.load("hammered_string").open(block=64) as sim:
        ...     audio, force = sim.step({"key": -0.004})
        >>> audio.shape, force.shape
        ((64, 2), (64, 1))
        """
        probes = [probes] if isinstance(probes, str) else list(probes)
        return Sim(self._listening(probes, energy), block, probes, is_double(dtype))

    def _listening(self, probes: Sequence[str], energy: bool) -> _core.Scene:
        """The compiled scene, with probes and energy ledger if requested."""
        if not probes and not energy:
            return self._compiled
        return self._model.compile(rate=self._asked[0], energy=energy, probes=list(probes))

    # pictures and pages

    def view(
        self, seconds: float | str | None = None, *, gesture: Gesture = None, progress: Progress | None = None
    ) -> View:
        """Plays it and records its motion: a page with the moving instrument, as at the top of ``ca report``.

        Modules that reach no output are drawn too. Large or long scenes are shown with fewer pictures or masses; the
        page says so.

        Args:
            seconds: as for `render`.
            gesture: as for `render`.
            progress: as for `render`.

        Raises:
            UsageError: if a name is neither a port nor a live parameter, or the length is invalid.

        >>> import cordis_anima as ca
        >>> ca.load("rattle").view(0.2)._repr_html_().startswith("<iframe srcdoc=")
        True
        """
        return View(self._compiled.view(None if seconds is None else length(seconds), made(self._compiled, gesture), progress))

    def play(self, *args: str, ca: Path | None = None) -> Playing:
        """Plays it interactively in a page, which a notebook shows inline.

        Files that the model refers to need absolute paths. The scene plays in this process; a model with force devices
        is played by the program ``ca``.

        Args:
            args: options of ``ca play``, e.g. ``"--log", "take.mcap"`` or ``"--audio", "page"``.
            ca: path of a program ``ca`` to play it; default: the environment variable ``CA``.

        Raises:
            UsageError: if the program does not exist.
            FailedError: if it fails to play; the message has the reason.

        >>> import cordis_anima as ca
        >>> with ca.load("plucked_string").play("--audio", "page") as playing:
        ...     "<iframe" in playing._repr_html_()
        True
        """
        rate = () if self._asked[0] is None else ("--rate", f"{self._asked[0]!r} Hz")
        devices = any(i.role == "device" for i in self.inputs)
        return Playing._of(self._model, ca, devices, [*rate, *args])

    # measurements

    def rollout(
        self,
        masses: str | Sequence[str],
        seconds: float | str | None = None,
        *,
        gesture: Gesture = None,
        progress: Progress | None = None,
    ) -> Rollout:
        """Plays it and records the positions of masses at each sample, whether or not they reach an output.

        Args:
            masses: selectors of masses, e.g. ``"low[*]"`` or ``["hammer", "low[3]"]``.
            seconds: as for `render`.
            gesture: as for `render`.
            progress: as for `render`.

        Raises:
            UsageError, FileError, ModelError: as for `render`; UsageError also if a selector chooses a link.

        >>> import cordis_anima as ca
        >>> moved = ca.load("hammered_string").rollout(["hammer", "low[*]"], 0.01)
        >>> moved.x.shape == (480, len(moved.places)), moved.places[0]
        (True, 'hammer')
        """
        asked = [masses] if isinstance(masses, str) else list(masses)
        for selector in asked:
            if self._unit(selector) != "m":
                raise UsageError(f"`{selector}` is a force; a rollout records positions of masses only")
        played = self.render(seconds, gesture=gesture, probes=asked, progress=progress)
        heard = [played.probes[s].reshape(len(played.audio), -1) for s in asked]
        places = tuple(name for s in asked for name in played.columns[s])
        x = np.concatenate(heard, axis=1) if heard else np.empty((len(played.audio), 0))
        return Rollout(places, x, self.rate, played.status)


def _again(data: bytes, name: str, rate: float | None, exact: bool) -> Scene:
    """Restores a pickled scene."""
    return Scene._of(_core.Model.from_bytes(data, name), rate, exact)
