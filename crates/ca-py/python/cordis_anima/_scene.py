"""Scenes: compiled models, and what is heard of them."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, Literal, Union

import numpy as np
import numpy.typing as npt

from . import _core, _gradient, _html
from ._errors import Diagnostic, UnstableError, UsageError, diagnostics
from ._linear import Linear, Rollout
from ._gradient import Gradient, Loss, Tangents
from ._render import Params, Render
from ._results import Accuracy, Certificate, Floats, Modes, Param, Port, Status, length, number, reals, value
from ._results import energy as _energy
from ._play import Playing
from ._sim import Sim
from ._view import View

#: called with what is done and how much there is; an exception ends the call
Progress = Callable[[int, int], object]
Path = Union[str, "os.PathLike[str]"]
#: what drives one port or live parameter: a number that stays; breakpoints (n, 2) of time [s] and value; samples (n,) at
#: the sound rate; samples and their rate [Hz]; a file with one track; an array in a file, and its rate [Hz]
Curve = Union[float, npt.ArrayLike, "tuple[npt.ArrayLike, float]", Path, "tuple[Path, float]"]
#: curves by what they drive, or a file whose tracks are called by it
Gesture = Union[Mapping[str, Curve], str, "os.PathLike[str]", None]
#: kinds that are heard as a force
_FORCES = {"SOF", *(code for code, _, _, family, _ in _core.kinds() if family == "LIA")}


class Scene:
    """A compiled model, ready to be played. It never changes: `replace` makes another.

    Scenes are equal where the same values are written in the same order, whatever comments, blanks and names of files;
    they can be pickled, copied and used as keys. Threads may share one.

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
        raise UsageError("a scene comes from `ca.load`, `ca.parse` or `Model.compile`")

    @classmethod
    def _of(cls, model: _core.Model, rate: float | str | None, exact: bool) -> Scene:
        made = cls.__new__(cls)
        rate = None if rate is None else number("rate", rate, "Hz")
        made._model, made._asked, made._hash = model, (rate, exact), None
        made._compiled = model.compile(rate=rate, exact=exact)
        return made

    # what it is

    @property
    def name(self) -> str:
        """Name of its file, without folder and extension."""
        return self._model.name

    @property
    def title(self) -> str:
        """The title its author gave it."""
        return self._model.title

    @property
    def sr(self) -> int:
        """Sound rate [Hz], as sound files have it: a whole number."""
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
        """Live parameters, with unit, range and document."""
        return Params([Param(*p) for p in self._compiled.params])

    @property
    def n_mat(self) -> int:
        """How many masses, cells and fixed points it has."""
        return int(self._compiled.about()["n_mat"])

    @property
    def n_lia(self) -> int:
        """How many links it has."""
        return int(self._compiled.about()["n_lia"])

    @property
    def passes(self) -> tuple[tuple[str, int], ...]:
        """What runs in a tick: names of passes and how many modules each has."""
        return tuple(self._compiled.about()["passes"])

    @property
    def left_out(self) -> tuple[str, ...]:
        """What the compiler left out since nobody hears it, in words."""
        return tuple(self._compiled.about()["left_out"])

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """Warnings and notes of the compiler."""
        return diagnostics(self._compiled.findings()[0])

    @property
    def certificate(self) -> Certificate:
        """What is proven of its stability.

        >>> import cordis_anima as ca
        >>> ca.load("harmonic_chain").certificate.level
        'proven'
        """
        return Certificate(**self._compiled.certificate())

    @property
    def hash(self) -> str:
        """BLAKE3 of the values written, in their order, and of the sound rate: 64 digits, the same on every machine."""
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

    # others like it

    def replace(self, changes: Mapping[str, object] | None = None, *, rate: float | str | None = None) -> Scene:
        """The same scene with other values, as ``ca render --set`` takes them: numbers in the model's units, or quantities.

        Raises:
            UsageError: no such name, with the nearest one.
            ModelError: a value that cannot be.

        >>> import cordis_anima as ca
        >>> ca.load("hammered_string").replace({"hammer.m": "30 g", "model.title": "heavy"}).title
        'heavy'
        """
        model = self._model.copy()
        for name, given in (changes or {}).items():
            model.set(name, value(name, given))
        asked, exact = self._asked
        return Scene._of(model, asked if rate is None else rate, exact)

    # what is heard

    def render(
        self,
        seconds: float | str | None = None,
        *,
        gesture: Gesture = None,
        probes: Sequence[str] = (),
        energy: bool = False,
        on_unstable: Literal["keep", "raise"] = "keep",
        progress: Progress | None = None,
    ) -> Render:
        """Plays the scene to its end. Other threads run meanwhile; Ctrl-C ends it.

        Args:
            seconds: how long, a number or text such as ``"1.5 s"``; without, as the model says, or until its gestures have died away.
            gesture: what drives ports and live parameters; takes the place of the built-in gesture of the same name.
                A mapping of names to numbers, breakpoints ``[(t, value), …]``, arrays at the sound rate, arrays and
                their rate, or files; or a file (CSV, NPY, WAV, MIDI, a take) whose tracks are called by them.
            probes: selectors to listen to besides: ``"low[3]"``, ``"strike"``, ``"low[*]"``.
            energy: keep the energy ledger; a little slower.
            on_unstable: ``"raise"`` for an `UnstableError` where it diverges; else silence from there on.
            progress: called now and then with how many frames of how many are done.

        Raises:
            UsageError: nothing is driven by such a name, values that are none, a length or an option that makes no sense.
            FileError: a file of a gesture cannot be read.
            ModelError: a probe that chooses nothing.
            UnstableError: it diverged, where that was asked for.

        >>> import cordis_anima as ca
        >>> key = ca.load("hammered_string")
        >>> r = key.render(1.0, gesture={"key": [(0, -0.008), (0.02, 0), (0.5, -0.008)]}, energy=True)
        >>> r.status, abs(r.energy.residual) < 1e-9 * r.energy.peak
        ('ok', True)
        """
        seconds = None if seconds is None else length(seconds)
        if on_unstable not in ("keep", "raise"):
            raise UsageError(f"on_unstable = {on_unstable!r}: \"keep\" or \"raise\"")
        probes = [probes] if isinstance(probes, str) else list(probes)
        core = self._compiled
        if probes or energy:
            core = self._model.compile(rate=self._asked[0], energy=energy, probes=list(probes))
        raw = core.render(seconds, self._gesture(gesture), progress)
        about = core.about()
        failed, message = None, ""
        if raw["broke"] is not None:
            time, module, message = raw["broke"]
            failed = (time, module)
            if on_unstable == "raise":
                raise UnstableError(message, time, module)
        status: Status = "ok"
        if failed is not None:
            status = "unstable"
        elif raw["clipped"] or raw["non_finite"]:
            status = "clipped"
            reported = []
            if raw["clipped"]:
                reported.append(f"{raw['clipped']} samples beyond full scale; multiply the gain by {raw['gain']:g} or less")
            if raw["non_finite"]:
                reported.append(f"{raw['non_finite']} samples had no value and became silence")
            message = "; ".join(reported)
        elif raw["refused"]:
            status, message = "refused", f"{raw['refused']} inputs had no value"
        heard, names = _probes(raw, probes)
        return Render(
            audio=raw["audio"],
            sr=round(about["rate"]),
            seconds=len(raw["audio"]) / about["rate"],
            channels=tuple(about["channels"]),
            probes=heard,
            columns=names,
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

    # its derivatives

    def tangents(
        self, wrt: Sequence[str], seconds: float | str | None = None, *, gesture: Gesture = None
    ) -> Tangents:
        """Plays it with the derivatives of each sample by parameters, in forward mode: those of its ticks, and not differences.

        Args:
            wrt: names as `replace` takes them, e.g. ``"low.f"``, ``"hammer.v"``, and numbers of lists, e.g. ``"ball.v[1]"``.
            seconds: as for `render`.
            gesture: as for `render`; it drives ports.

        Raises:
            UsageError: no such name; a whole number, a word or a flag, by which there are no derivatives; a parameter that changes
                what is built; groups at the gesture rate; parameters that ports or gestures drive; a scene that diverges.

        >>> import cordis_anima as ca
        >>> t = ca.examples.string().tangents(["hammer.v", "low.f"], 0.1)
        >>> t.audio.shape, t.tangents.shape, t["low.f"].shape, t.units
        ((4800, 1), (4800, 1, 2), (4800, 1), ('m/s', 'Hz'))
        """
        seconds = None if seconds is None else length(seconds)
        return _gradient.tangents(self._forward(wrt), seconds, self._gesture(gesture), self.sr)

    def gradient(
        self,
        wrt: Sequence[str],
        *,
        loss: Loss | None = None,
        cotangent: npt.ArrayLike | None = None,
        seconds: float | str | None = None,
        gesture: Gesture = None,
    ) -> Gradient:
        """The gradient of a loss of its sound, without memory for the derivatives of samples.

        Args:
            wrt: as for `tangents`.
            loss: called with the sound (frames, channels) in double precision; gives the loss, and its derivatives by each sample.
            cotangent: these derivatives (frames, channels), where there is no loss to call; it says how long is played.
            seconds: as for `render`, with a loss.
            gesture: as for `tangents`.

        Raises:
            UsageError: as `tangents`; neither a loss nor a cotangent, or one of another shape.

        >>> import cordis_anima as ca
        >>> g = ca.examples.string().gradient(["hammer.v"], loss=lambda y: ((y**2).sum(), 2 * y), seconds=0.1)
        >>> g.loss > 0, g["hammer.v"] > 0
        (True, True)
        """
        if cotangent is not None and (loss is not None or seconds is not None):
            raise UsageError("a cotangent says how long is played, and of which loss it is")
        seconds = None if seconds is None else length(seconds)
        return _gradient.gradient(self._forward(wrt), seconds, self._gesture(gesture), cotangent, loss)

    def _forward(self, wrt: Sequence[str]) -> _core.Forward:
        names = [wrt] if isinstance(wrt, str) else list(wrt)
        if not names:
            raise UsageError("`wrt` names no parameter")
        return self._compiled.forward(names)

    def _unit(self, selector: str) -> str:
        """What a probe is counted in: links are forces, and so are outputs of force; all else are places."""
        name, index, _ = selector.partition("@")[0].partition("[")
        name = name.strip()
        inner = bool(index) and name.endswith(".link")
        return "N" if inner or any(item == name and kind in _FORCES for kind, item in self._model.items) else "m"

    def _file(self, path: str | os.PathLike[str], port: str | None, rate: float | None) -> _core.Gesture:
        """A gesture from a file; notes that move no port are a warning."""
        gesture = self._compiled.gesture(os.fspath(path), port, rate)
        if gesture.unheard is not None:
            warnings.warn(f"`{os.fspath(path)}`: {gesture.unheard}", stacklevel=4)
        return gesture

    def _gesture(self, gesture: Gesture) -> _core.Gesture | None:
        if gesture is None:
            return None
        if isinstance(gesture, (str, os.PathLike)):
            return self._file(gesture, None, None)
        if not isinstance(gesture, Mapping):
            raise UsageError("a gesture is a file, or names of ports with what drives them")
        files: list[_core.Gesture] = []
        tracks: list[tuple[str, Any]] = []
        for name, curve in gesture.items():
            if isinstance(curve, (str, os.PathLike)):
                files.append(self._file(curve, name, None))
            elif isinstance(curve, tuple) and len(curve) == 2 and isinstance(curve[0], (str, os.PathLike)):
                files.append(self._file(curve[0], name, number(f"rate of `{name}`", curve[1], "Hz")))
            elif isinstance(curve, tuple) and len(curve) == 2 and _ndim(curve[0]) == 1 and _ndim(curve[1]) == 0:
                tracks.append((name, (number(f"rate of `{name}`", curve[1], "Hz"), reals(name, curve[0], dense=True))))
            else:
                values = reals(name, curve)
                if values.ndim == 0:
                    tracks.append((name, float(values)))
                elif values.ndim == 1:
                    tracks.append((name, (self.rate, values)))
                elif values.ndim == 2 and values.shape[1] == 2:
                    tracks.append((name, values))
                else:
                    raise UsageError(f"gesture `{name}` has the shape {values.shape}: (n,) samples, or (n, 2) times and values")
        return _core.Gesture.together([_core.Gesture(tracks), *files]) if files else _core.Gesture(tracks)

    def open(self, *, block: int = 512, energy: bool = False, probes: Sequence[str] = ()) -> Sim:
        """A running scene: block by block, or frame by frame with `block=1`. See `Sim`.

        Args:
            block: samples of a block where nothing says how many.
            energy: keep the energy ledger, to be read from `Sim.energy` at any time.
            probes: selectors to listen to besides, as for `render`; each block has them as `Block.probes`.

        Raises:
            ModelError: a probe that chooses nothing.

        >>> import cordis_anima as ca
        >>> with ca.load("hammered_string").open(block=64) as sim:
        ...     audio, force = sim.step({"key": -0.004})
        >>> audio.shape, force.shape
        ((64, 2), (64, 1))
        """
        probes = [probes] if isinstance(probes, str) else list(probes)
        core = self._compiled
        if probes or energy:
            core = self._model.compile(rate=self._asked[0], energy=energy, probes=list(probes))
        return Sim(core, block, probes)

    # seen and touched

    def view(
        self, seconds: float | str | None = None, *, gesture: Gesture = None, progress: Progress | None = None
    ) -> View:
        """Plays it once more and keeps how it moves: a page with the moving instrument, as at the head of ``ca report``. Modules
        that nothing hears are drawn, too. Large scenes and long ones have fewer pictures or masses, which the page tells.

        Args:
            seconds: as for `render`.
            gesture: as for `render`.
            progress: as for `render`.

        Raises:
            UsageError: nothing is driven by such a name, or a length that makes no sense.

        >>> import cordis_anima as ca
        >>> ca.load("rattle").view(0.2)._repr_html_().startswith("<iframe srcdoc=")
        True
        """
        return View(self._compiled.view(None if seconds is None else length(seconds), self._gesture(gesture), progress))

    def play(self, *args: str, ca: Path | None = None) -> Playing:
        """Plays it by hand in the page of ``ca play``, a program of its own, which is shown inline in a notebook. What the model
        reads from files beside it has to be named by whole paths.

        Args:
            args: more for the program, as on the command line, e.g. ``"--log", "take.mcap"`` or ``"--audio", "page"``.
            ca: the program; without, that in the environment variable ``CA``, or ``ca`` on the path.

        Raises:
            UsageError: there is no such program.
            FailedError: it does not play; what it says.

        >>> import cordis_anima as ca
        >>> with ca.load("plucked_string").play("--audio", "page") as playing:
        ...     "<iframe" in playing._repr_html_()
        True
        """
        rate = () if self._asked[0] is None else ("--rate", f"{self._asked[0]!r} Hz")
        return Playing._of(self._model, self._model.toml(), ca, [*rate, *args])

    # what is known of it

    def modes(self) -> Modes:
        """Modes of its linear part: frequencies with and without the scheme, decay, shapes, and levels at ports.

        >>> import cordis_anima as ca
        >>> m = ca.load("harmonic_chain").modes()
        >>> bool((m.heard > 0).all()), m.shapes.shape == (len(m), len(m.places))
        (True, True)
        """
        raw = self._model.modes(self._asked[0])
        return Modes(**_frozen(raw))

    def linear(self) -> Linear:
        """The linear part of the scene at load as sparse matrices, and a tick made of them. Needs SciPy: ``pip install
        "cordis-anima[linear]"``.

        >>> import cordis_anima as ca, numpy as np
        >>> part = ca.load("harmonic_chain").linear()
        >>> part.K.shape == part.M.shape == (len(part), len(part)), bool((part.M.diagonal() > 0).all())
        (True, True)
        """
        return Linear._of(self._model.linear(self._asked[0]))

    def rollout(
        self,
        masses: str | Sequence[str],
        seconds: float | str | None = None,
        *,
        gesture: Gesture = None,
        progress: Progress | None = None,
    ) -> Rollout:
        """Plays it and keeps where masses are at each sample, whether anything hears them or not.

        Args:
            masses: selectors of masses, e.g. ``"low[*]"`` or ``["hammer", "low[3]"]``.
            seconds: as for `render`.
            gesture: as for `render`.
            progress: as for `render`.

        Raises:
            UsageError, FileError, ModelError: as for `render`; also where a selector chooses a link.

        >>> import cordis_anima as ca
        >>> moved = ca.load("hammered_string").rollout(["hammer", "low[*]"], 0.01)
        >>> moved.x.shape == (480, len(moved.places)), moved.places[0]
        (True, 'hammer')
        """
        asked = [masses] if isinstance(masses, str) else list(masses)
        for selector in asked:
            if self._unit(selector) != "m":
                raise UsageError(f"`{selector}` is a force; a rollout keeps where masses are")
        played = self.render(seconds, gesture=gesture, probes=asked, progress=progress)
        columns = [played.probes[s].reshape(len(played.audio), -1) for s in asked]
        places = tuple(name for s in asked for name in played.columns[s])
        x = np.concatenate(columns, axis=1) if columns else np.empty((len(played.audio), 0))
        return Rollout(places, x, self.rate, played.status)

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


def _ndim(given: object) -> int | None:
    """Dimensions of an array; none where its rows are of several lengths."""
    try:
        return np.ndim(given)  # type: ignore[arg-type]
    except ValueError:
        return None


def _frozen(raw: Mapping[str, Any]) -> dict[str, Any]:
    """With tuples in place of lists."""
    return {k: tuple(v) if isinstance(v, list) else v for k, v in raw.items()}


def _probes(raw: Mapping[str, Any], asked: Sequence[str]) -> tuple[Mapping[str, Floats], Mapping[str, tuple[str, ...]]]:
    """Columns by the selector that asked for them."""
    heard: dict[str, Floats] = {}
    names: dict[str, tuple[str, ...]] = {}
    of = np.asarray(raw["probe_of"])
    for k, selector in enumerate(asked):
        columns = np.flatnonzero(of == k)
        names[selector] = tuple(raw["probe_names"][c] for c in columns)
        heard[selector] = raw["probes"][:, columns[0]] if len(columns) == 1 else raw["probes"][:, columns]
    return heard, names


def _again(data: bytes, name: str, rate: float | None, exact: bool) -> Scene:
    """A scene from a pickle."""
    return Scene._of(_core.Model.from_bytes(data, name), rate, exact)
