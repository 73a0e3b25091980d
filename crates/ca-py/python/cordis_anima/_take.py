"""Takes: recorded performances with devices, one MCAP file each."""

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
#: longest part of a take that a notebook page plays [s]; the sound is embedded in the page
_PLAYED = 60.0


class Fault(NamedTuple):
    """A fault: forces ended."""

    #: name of the device
    device: str
    #: time [s]
    time: float
    #: cause, e.g. ``WATCHDOG_IN``
    cause: str


class Verdict(NamedTuple):
    """Result of a replay."""

    #: true if everything compared is identical and nothing is missing
    identical: bool
    #: force frames compared
    forces: int
    #: sound samples compared, in all channels
    samples: int
    #: state hashes compared
    hashes: int
    #: length [s]
    seconds: float
    #: first difference
    difference: str | None
    #: time of the first gap [s], after which nothing could be compared
    hole: float | None
    #: allowed difference of sound and forces, relative to their peak: 0, i.e. to the bit, unless the take was played by
    #: an older arithmetic and its scene has parts that are rounded differently since
    tolerance: float = 0.0


@dataclass(frozen=True, repr=False, eq=False)
class Hand:
    """Frames between the engine and one device: m received, n sent."""

    #: time at which a frame was read (m,) [s], by the sound clock
    time: Floats
    #: number of the frame (m,)
    number: npt.NDArray[np.int64]
    #: time of the measurement (m,) [s], by the device clock; with `record`, the beginning of the frame at whose end the
    #: hand is there
    device_time: Floats
    #: position as sent by the device (m, dof): [m], or counts if it is calibrated here
    position: Floats
    #: force measured by the device (m, dof) [N]; 0 if it measures none
    measured: Floats
    #: flags of the frame (m,), one bit each: connected, powered, calibrated, …
    status: npt.NDArray[np.uint32]
    #: time at which a force was sent (n,) [s], by the sound clock
    force_time: Floats
    #: force sent (n, dof) [N]
    force: Floats
    #: number of the device frame that it answers (n,)
    answers: npt.NDArray[np.int64]
    #: effects of the guard (n,), one bit each, from the lowest: limited to the largest force; limited in rate; damped
    #: for passivity; weakened because of oscillation; weakened to cool the motors; in the soft edge; based on old
    #: positions; armed, but waiting until nothing pushes; passivity damping suspended because it gave energy
    flags: npt.NDArray[np.uint32]
    #: viscosity added by the passivity stage (n,) [N s/m], the largest over degrees of freedom
    injected: Floats
    #: ``off``, ``ramp``, ``on``, ``damp`` or ``fault`` (n,)
    mode: Texts
    #: cause of a zero force (n,); ``NONE`` with a force
    cause: Texts

    @property
    def dof(self) -> int:
        """Number of degrees of freedom."""
        return int(self.position.shape[1])

    def __repr__(self) -> str:
        return f"<Hand: {self.dof} dof, {len(self.time)} frames in, {len(self.force_time)} out>"


class Take:
    """A take written by ``ca serve`` or by `record`. It has whole gesture frames; the first is one sample long.

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
        #: path of the file
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
        """Start time [s since 1970]."""
        return float(self._about["began"])

    @property
    def host(self) -> Mapping[str, str]:
        """Program and machine that wrote it."""
        return dict(self._about["host"])

    @property
    def seconds(self) -> float:
        """Length [s]."""
        return float(self._read()["seconds"])

    @property
    def hands(self) -> Mapping[str, Hand]:
        """Frames of each device, by name."""

        if self._hands is None:
            devices = self._read()["devices"].items()
            self._hands = {name: Hand(**{k: _texts(v) for k, v in raw.items()}) for name, raw in devices}
        return self._hands

    @property
    def audio(self) -> Floats:
        """Sound (frames, channels), in the double precision of the engine."""
        sound: Floats = self._read()["audio"]
        return sound

    @property
    def energy(self) -> Mapping[str, Floats]:
        """Energy ledger over time: ``time`` [s], all else [J] as in `Energy`; empty arrays without a ledger."""
        return dict(self._read()["energy"])

    @property
    def realtime(self) -> Mapping[str, Floats]:
        """Performance of the real-time thread, each second.

        ``time`` [s]; counts since the start: ``frames``, ``missed``, ``stale``, ``dropped``, ``faults``, ``clipped``,
        ``underruns``; delays of the frames of that second: ``late_p50``, ``late_p99``, ``late_max`` [s]; ``busy``, the
        share of it spent computing.
        """
        return dict(self._read()["realtime"])

    @property
    def faults(self) -> tuple[Fault, ...]:
        """Times and causes at which forces ended."""
        return tuple(Fault(*f) for f in self._read()["faults"])

    @property
    def lost(self) -> tuple[int, int, int]:
        """Numbers of records, sound samples and views lost because buffers were full."""
        records, samples, views = self._read()["lost"]
        return records, samples, views

    @property
    def cut(self) -> str | None:
        """Why the file ends early, or ``None``."""
        why: str | None = self._read()["cut"]
        return why

    @property
    def gesture(self) -> str:
        """Motion of the hands as a gesture, for `Scene.render`, `Scene.open` or `record` of this or another model."""
        return self.path

    def scene(self) -> Scene:
        """Compiles the scene that was played.

        Raises:
            ModelError: if it has errors here, because another version wrote it.
        """
        model, rate = self._core.model()
        return Scene._of(model, rate, False)

    def replay(self) -> Verdict:
        """Replays the received frames at the same ticks, and compares every force and every sample."""
        return Verdict(**self._core.replay())

    def view(self) -> View:
        """Shows the moving instrument in step with its sound, by a replay. See `Scene.view`.

        Raises:
            FileError: if it cannot be replayed.
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
    """Plays a scene into a take, with the engine of ``ca serve`` but without a device or a clock.

    Devices follow the gesture, whatever force they get. The guard uses the profile of the device, or the one for
    unknown devices. Sound fades in within 50 ms, as in ``ca serve``.

    Args:
        scene: scene to play.
        path: path of the file, which must not exist yet.
        seconds: length; default: as for `Scene.render`.
        gesture: drives devices and live parameters. Other ports cannot be driven in a take, and the model's own
            gestures for them are not played.
        energy: record the energy ledger.
        forces: arm forces, as soon as the guard allows.
        progress: called with the numbers of samples done and in total.

    Raises:
        UsageError: if the gesture drives anything but devices and live parameters.
        FileError: if the file exists or cannot be written.

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
