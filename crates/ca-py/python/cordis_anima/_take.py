"""Takes: performances with devices, in one MCAP file each."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _core
from ._page import html as _html
from ._results import Floats, length
from ._gestures import Gesture, Path, made
from ._analysis.measured import Progress
from ._scene import Scene
from ._page.view import View

Texts = npt.NDArray[np.object_]
#: how much of a take a page plays [s]: takes are long, and what is played is in the page
_PLAYED = 60.0


class Fault(NamedTuple):
    """Forces that ended."""

    #: name of the device
    device: str
    #: when [s]
    time: float
    #: why, e.g. ``WATCHDOG_IN``
    cause: str


class Verdict(NamedTuple):
    """What a replay found."""

    #: whether all that was compared is as it was, and nothing is missing
    identical: bool
    #: force frames compared
    forces: int
    #: sound samples compared, of all channels
    samples: int
    #: hashes of the state compared
    hashes: int
    #: length [s]
    seconds: float
    #: the first thing that is not as it was
    difference: str | None
    #: where something is missing [s], so that nothing after it was compared
    hole: float | None
    #: how far sound and forces may be apart, as a part of their peak: 0, to the bit, unless the take was played by an older
    #: arithmetic and its scene has something that rounds otherwise since
    tolerance: float = 0.0


@dataclass(frozen=True, repr=False, eq=False)
class Hand:
    """What passed between the engine and one device: m frames came, n went."""

    #: when a frame was looked at (m,) [s], by the clock of the sound
    time: Floats
    #: number of the frame (m,)
    number: npt.NDArray[np.int64]
    #: when it was measured (m,) [s], by the clock of the device; of `record`, the beginning of the frame at whose end the
    #: hand is there
    device_time: Floats
    #: where the device was (m, dof), as it said: [m], or counts where it is calibrated here
    position: Floats
    #: the force it measured (m, dof) [N]; 0 where it measures none
    measured: Floats
    #: flags of the frame (m,): connected, powered, calibrated, …, a bit each
    status: npt.NDArray[np.uint32]
    #: when a force was sent (n,) [s], by the clock of the sound
    force_time: Floats
    #: the force it got (n, dof) [N]
    force: Floats
    #: number of the device frame it answers (n,)
    answers: npt.NDArray[np.int64]
    #: what the guard did to it (n,), a bit each, from the lowest: cut to the largest force, slowed down, damped to stay
    #: passive, weakened for it oscillated, weakened to spare the motors, in the soft edge, from positions that are not
    #: fresh, armed but waiting until nothing pushes, and damping left out for a while since it gave energy
    flags: npt.NDArray[np.uint32]
    #: viscosity that the passivity stage added (n,) [N s/m], the largest of all degrees of freedom
    injected: Floats
    #: ``off``, ``ramp``, ``on``, ``damp`` or ``fault`` (n,)
    mode: Texts
    #: why there was no force (n,), ``NONE`` where there was
    cause: Texts

    @property
    def dof(self) -> int:
        """How many degrees of freedom it has."""
        return int(self.position.shape[1])

    def __repr__(self) -> str:
        return f"<Hand: {self.dof} dof, {len(self.time)} frames in, {len(self.force_time)} out>"


class Take:
    """A take that was written by ``ca serve`` or by `record`: whole gesture frames, the first of them one sample long.

    >>> import cordis_anima as ca, tempfile, os
    >>> folder = tempfile.TemporaryDirectory()
    >>> path = os.path.join(folder.name, "blow.mcap")
    >>> t = ca.record(ca.load("hammered_string"), path, 0.5)
    >>> t.devices, t.audio.shape, t.replay().identical
    (('tgr12',), (24001, 2), True)
    """

    def __init__(self, path: Path) -> None:
        self._core = _core.Take(os.fspath(path))
        self._about = self._core.about()
        self._all: dict[str, Any] | None = None
        self._hands: dict[str, Hand] | None = None
        #: the file
        self.path: str = os.fspath(path)

    def _read(self) -> dict[str, Any]:
        if self._all is None:
            self._all = self._core.read()
        return self._all

    @property
    def title(self) -> str:
        """Title of the model."""
        return str(self._about["title"])

    @property
    def rate(self) -> float:
        """Sound rate [Hz]."""
        return float(self._about["rate"])

    @property
    def gesture_rate(self) -> float:
        """Rate of gesture frames [Hz]."""
        return float(self._about["gesture_rate"])

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the sound channels."""
        return tuple(self._about["channels"])

    @property
    def devices(self) -> tuple[str, ...]:
        """Names of the devices."""
        return tuple(self._about["devices"])

    @property
    def began(self) -> float:
        """When it began [s since 1970]."""
        return float(self._about["began"])

    @property
    def host(self) -> Mapping[str, str]:
        """What wrote it and where."""
        return dict(self._about["host"])

    @property
    def seconds(self) -> float:
        """Length [s]."""
        return float(self._read()["seconds"])

    @property
    def hands(self) -> Mapping[str, Hand]:
        """What passed, by name of the device."""

        if self._hands is None:
            devices = self._read()["devices"].items()
            self._hands = {name: Hand(**{k: _texts(v) for k, v in raw.items()}) for name, raw in devices}
        return self._hands

    @property
    def audio(self) -> Floats:
        """What was heard (frames, channels), in 64 bits as it was computed."""
        sound: Floats = self._read()["audio"]
        return sound

    @property
    def energy(self) -> Mapping[str, Floats]:
        """The energy ledger over time: ``time`` [s], all else [J] as in `Energy`; empty arrays where none was kept."""
        return dict(self._read()["energy"])

    @property
    def realtime(self) -> Mapping[str, Floats]:
        """How the real-time thread did, each second: ``time`` [s]; counts since the start of ``frames``, ``missed``,
        ``stale``, ``dropped``, ``faults``, ``clipped``, ``underruns``; ``late_p50``, ``late_p99``, ``late_max`` [s], how
        late frames of that second began; ``busy``, the part of it spent computing.
        """
        return dict(self._read()["realtime"])

    @property
    def faults(self) -> tuple[Fault, ...]:
        """When forces ended, and why."""
        return tuple(Fault(*f) for f in self._read()["faults"])

    @property
    def lost(self) -> tuple[int, int, int]:
        """Records, sound samples and views that found no room."""
        records, samples, views = self._read()["lost"]
        return records, samples, views

    @property
    def cut(self) -> str | None:
        """Why the file ends early, where it does."""
        why: str | None = self._read()["cut"]
        return why

    @property
    def gesture(self) -> str:
        """What the hands did, for `Scene.render`, `Scene.open` or `record` of this or another model."""
        return self.path

    def scene(self) -> Scene:
        """The scene that was played, compiled anew.

        Raises:
            ModelError: it has errors here: another version wrote it.
        """
        model, rate = self._core.model()
        return Scene._of(model, rate, False)

    def replay(self) -> Verdict:
        """Plays it again, with the frames that came and at the same ticks, and compares every force and every sample."""
        return Verdict(**self._core.replay())

    def view(self) -> View:
        """The moving instrument in step with its sound, as it is when it is played again. See `Scene.view`.

        Raises:
            FileError: it cannot be played again.
        """
        return View(self._core.view())

    def __reduce__(self) -> tuple[Any, ...]:
        return (Take, (self.path,))

    def __repr__(self) -> str:
        hands = ", ".join(self.devices) or "no device"
        return f"<Take {self.title!r}: {self.seconds:.3f} s with {hands}>"

    def _repr_html_(self) -> str:
        hands = (f"{name}: {h.dof} dof, {len(h.time)} frames in, {len(h.force_time)} out" for name, h in self.hands.items())
        faults = (f"{f.cause} at {f.time:.3f} s ({f.device})" for f in self.faults)
        lost = (f"{n} {what}" for n, what in zip(self.lost, ("records", "samples", "views")) if n)
        facts = [
            ("devices", "; ".join(hands) or "none"),
            ("length", f"{self.seconds:.3f} s"),
            ("faults", ", ".join(faults) or "none"),
            ("lost", ", ".join(lost) or "nothing"),
        ]
        if self.cut is not None:
            facts.append(("cut off", self.cut))
        frames = round(_PLAYED * self.rate)
        if len(self.audio) > frames:
            facts.append(("played here", f"the first {_PLAYED:g} s"))
        return _html.take(self.title, facts, self.audio[:frames].astype(np.float32), round(self.rate), self.channels)


def _texts(column: Any) -> Any:
    return np.array(column, object) if isinstance(column, list) else column


def record(
    scene: Scene,
    path: Path,
    seconds: float | str | None = None,
    *,
    gesture: Gesture = None,
    energy: bool = False,
    forces: bool = True,
    progress: Progress | None = None,
) -> Take:
    """Plays a scene by the engine of ``ca serve``, without a device and without a clock, into a take.

    Devices are where the gesture has them, whatever force they get; the guard is that of the device's profile, or of one
    nobody has described. Sound fades in within 50 ms, as that of a server does.

    Args:
        scene: what is played.
        path: the file, which must not be there yet.
        seconds: how long; without, as in `Scene.render`.
        gesture: what drives devices and live parameters; another port cannot be driven in a take, and what the model has
            for one is not played.
        energy: keep the energy ledger.
        forces: arm forces, as soon as the guard lets them.
        progress: called with how many samples of how many are done.

    Raises:
        UsageError: something is driven that is no device and no live parameter.
        FileError: the file is there already, or cannot be written.

    >>> import cordis_anima as ca, tempfile, os
    >>> folder = tempfile.TemporaryDirectory()
    >>> path = os.path.join(folder.name, "blow.mcap")
    >>> key = ca.load("hammered_string")
    >>> t = ca.record(key, path, 0.5)
    >>> t.hands["tgr12"]
    <Hand: 12 dof, 1501 frames in, 1501 out>
    """
    scene._model.record(
        os.fspath(path),
        rate=scene._asked[0],
        seconds=None if seconds is None else length(seconds),
        gesture=made(scene._compiled, gesture),
        energy=energy,
        forces=forces,
        progress=progress,
    )
    return Take(path)
