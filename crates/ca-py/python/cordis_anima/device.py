"""A device process: sends positions and receives forces over shared memory.

    from cordis_anima.device import Device

    with Device("finger", low=-0.02, high=0.02, force=10.0) as device:
        while running:
            device.send(read_sensor())
            motor(device.force())
            device.wait()

Needs the wheel `iceoryx2==0.10.0`, imported when a `Device` is made, and nothing else of the package: a copy of this
file beside a program is enough (``from device import Device``). The rules for forces that may reach a motor follow
`host/force_watchdog.rs`, and the contents of frames `host/client.rs`; `ca device conformance NAME` checks both.
"""

from __future__ import annotations

import contextlib
import ctypes as c
import enum
import fcntl
import functools
import importlib
import math
import os
import re
import secrets
import stat
import time
from collections.abc import Sequence
from typing import Any

try:
    from ._errors import FailedError, UsageError, needed
except ImportError:
    # a copy of this file, without the package

    class UsageError(ValueError):  # type: ignore[no-redef]
        """The request is invalid."""

    class FailedError(RuntimeError):  # type: ignore[no-redef]
        """The request is valid but failed."""

    def needed(name: str, extra: str) -> Any:
        """Imports a required package."""
        try:
            return importlib.import_module(name)
        except ImportError as e:
            raise ImportError(f"this needs {name}: pip install {name}==0.10.0", name=name) from e


__all__ = ["CAUSES", "MODES", "Device", "Status"]

#: largest number of degrees of freedom
DOF = 32
#: causes of a zero force, by their numbers on the wire
CAUSES = (
    "NONE", "DISARMED", "BUTTON", "DEADMAN", "VELOCITY", "WATCHDOG_IN", "WATCHDOG_OUT", "NONFINITE", "IMPLAUSIBLE",
    "THERMAL", "DISCONNECT", "SOFTWARE", "MODEL_UNSTABLE",
)  # fmt: skip
#: modes of a force, by their numbers on the wire
MODES = ("off", "ramp", "on", "damp", "fault")


class Status(enum.IntFlag):
    """Hardware state in each frame. Forces need the first three bits, and none of the bits that end forces."""

    #: the process reaches its hardware
    CONNECTED = 1
    #: the motors have power
    POWERED = 2
    #: positions are in metres, forces in newtons
    CALIBRATED = 4
    #: held by a hand
    IN_USE = 8
    #: a dead man's switch exists and is released: ends forces
    DEADMAN = 16
    #: the motors are shorted: ends forces
    BRAKE = 32
    #: the motors are too warm: ends forces
    THERMAL = 64
    #: at the edge of the travel
    EDGE = 128
    #: simulated, without hardware
    SIMULATED = 256


#: number of frames whose send time is stored, for the latency of forces
_SENT = 1024
_NONE, _DISARMED, _WATCHDOG, _NONFINITE, _DISCONNECT = 0, 1, 6, 7, 10
#: longest life of a force, whatever its frame says [ns]
_LONGEST = 100_000_000
_SIZES: dict[str, Any] = {"uint8": c.c_uint8, "uint16": c.c_uint16, "uint32": c.c_uint32, "uint64": c.c_uint64,
          "float32": c.c_float, "float64": c.c_double}  # fmt: skip


def _fnv(text: str) -> int:
    return functools.reduce(lambda h, b: (h ^ b) * 0x100000001B3 % 2**64, text.encode(), 0xCBF29CE484222325)


def _record(name: str, magic: bytes, fields: str) -> Any:
    """Creates a structure from its message definition. `LAYOUT` is the hash of that text."""
    text = "".join(f"{kind} {field}\n" for kind, field in (f.split() for f in fields.split(",")))
    typed: list[tuple[str, Any]] = []
    for line in text.splitlines():
        kind, field = line.split()
        base, _, count = kind.rstrip("]").partition("[")
        typed.append((field, _SIZES[base] * int(count) if count else _SIZES[base]))
    of = {"_fields_": typed, "type_name": staticmethod(lambda: f"ca.v1.{name}"), "LAYOUT": _fnv(text),
          "MAGIC": int.from_bytes(magic, "little")}  # fmt: skip
    return type(name, (c.Structure,), of)


_HEAD = "uint32 magic,uint32 version,uint64 layout,uint8[16] device,uint64 session,"
#: from the device: position of the hand
DeviceFrame = _record("DeviceFrame", b"caDF", _HEAD + (
    "uint64 seq,uint64 ack,uint64 t_device_ns,uint64 t_host_ns,uint64 calibration,uint64 tick,uint32 period_ns,"
    "uint32 status,uint16 cause,uint16 n,uint32 mask,uint32 vel_mask,uint32 buttons,float64[32] pos,float64[32] vel,"
    "float32[32] force_measured,float32[4] quat,float32[4] aux,float32 temperature,uint32 reserved"))  # fmt: skip
#: from the engine: force on the hand
ForceFrame = _record("ForceFrame", b"caFF", _HEAD + (
    "uint64 seq,uint64 ack_session,uint64 ack,uint64 t_host_ns,uint64 tick,uint64 calibration,uint32 ttl_us,"
    "uint32 mode,uint16 cause,uint16 n,uint32 flags,float32 inject,uint32 reserved,float32[32] force"))  # fmt: skip
#: from the device, once a second: its properties
About = _record("About", b"caAB", _HEAD + (
    "uint64 calibration,uint8[32] model,uint8[32] serial,uint8[16] firmware,uint32 rate,uint16 n,uint16 axes,"
    "float32[32] low,float32[32] high,float32[32] force,float32[32] continuous,float32[32] stiffness,"
    "float32[32] damping"))  # fmt: skip


#: file that iceoryx2 0.10.0 creates with mode 0666, and its first bytes: see `host/file_ownership.rs`
_COUNTER, _RELEASE = "9204dd183d1c4d8e1ff592a30766ffa6765aa8b5_node.0_10_0.global_mgmt", 10 << 16
_SHM = "/dev/shm"
#: longest wait for a process that writes a new prefix [s]
_LIMIT = 2.0


def _named(prefix: str) -> list[tuple[str, os.stat_result]]:
    """Files in `/dev/shm` with this prefix. Files that vanish meanwhile are left out."""
    found = []
    for name in os.listdir(_SHM) if os.path.isdir(_SHM) else []:
        if name.startswith(prefix):
            with contextlib.suppress(FileNotFoundError):
                found.append((f"{_SHM}/{name}", os.lstat(f"{_SHM}/{name}")))
    return found


def _foreign(prefix: str) -> list[tuple[str, os.stat_result]]:
    return [f for f in _named(prefix) if f[1].st_uid != os.getuid() or not stat.S_ISREG(f[1].st_mode)]


def _share(file: int, end: float) -> None:
    while True:
        try:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
            return
        except BlockingIOError:
            if time.monotonic() > end:
                raise
            time.sleep(0.001)


def _claim(root: str) -> tuple[str, Any]:
    """Returns the prefix of all names at this place, and the file whose lock protects it: see `host/shm/prefix.rs`."""

    def prefix() -> str:
        digits = os.pread(file, 9, 0).decode("ascii", "replace")
        return f"ca1-0.10.0-{digits}_" if re.fullmatch("[0-9a-fA-F]{8}", digits) else ""

    file = os.open(f"{root}/prefix", os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
    held, end = os.fdopen(file, "rb+", buffering=0), time.monotonic() + _LIMIT
    while True:
        _share(file, end)
        old = prefix()
        if old and not _foreign(old):
            return old, held
        fcntl.flock(file, fcntl.LOCK_UN)
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            _share(file, end)
            # other processes use it
            if old and (now := prefix()):
                return now, held
            fcntl.flock(file, fcntl.LOCK_UN)
        else:
            # another process may have been faster
            if prefix() == old:
                for path, about in _named(old) if old else []:
                    if about.st_uid == os.getuid():
                        with contextlib.suppress(OSError):
                            os.unlink(path)
                os.pwrite(file, secrets.token_hex(4).encode(), 0)
                os.ftruncate(file, 8)
            fcntl.flock(file, fcntl.LOCK_UN)
        if time.monotonic() > end:
            raise FailedError(f"`{root}/prefix` is locked by another process; try again")


def _closed(prefix: str) -> None:
    """Creates the counter file for this user alone; iceoryx2 would create it with mode 0666."""
    if not os.path.isdir(_SHM):
        return
    path, fresh = f"{_SHM}/{prefix}{_COUNTER}", f"{_SHM}/{prefix}{os.getpid()}-{secrets.token_hex(4)}.new"
    with contextlib.suppress(FileNotFoundError):
        about = os.lstat(path)
        if about.st_uid == os.getuid() and stat.S_ISREG(about.st_mode) and about.st_mode & 0o777 == 0o600:
            return
    with os.fdopen(os.open(fresh, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "wb") as new:
        new.write(_RELEASE.to_bytes(8, "little") + bytes(8))
    os.rename(fresh, path)


def _unmixed(prefix: str, before: list[tuple[str, os.stat_result]]) -> None:
    """Raises an error if this process has mapped a file owned by another user, who could change its contents."""
    inodes = {about.st_ino for _, about in [*before, *_foreign(prefix)]}
    if not inodes:
        return
    with open("/proc/self/maps") as maps:
        for line in maps:
            if f"{_SHM}/{prefix}" in line and int(line.split()[4]) in inodes:
                raise FailedError(f"`{line.split()[5]}` belongs to another user; stop all servers and devices")


class Device:
    """A device of `n` degrees of freedom, connected by shared memory. ``ca serve`` may start before or after it.

    Args:
        name: 1 to 16 letters, digits, ``_``, ``-``, ``.``, as in the model.
        n: degrees of freedom, at most 32.
        axes: number of consecutive degrees of freedom that form one force vector: 1 for keys, 3 for a stylus.
        rate: frames per second.
        low, high: travel [m], of each degree of freedom or of all.
        force: largest force [N], of each degree of freedom or of all.
        continuous: largest permanent force [N]; default: `force`.
        stiffness: largest stiffness it renders [N/m], if known.
        model: make and model, for display.
        simulated: true without hardware.

    Raises:
        UsageError: if the name, the degrees of freedom or the rate are invalid.
        MissingError: if the wheel `iceoryx2` is not installed.
        FailedError: if the folder of the shared memory belongs to another user, or another device has this name.
    """

    def __init__(
        self,
        name: str,
        n: int = 1,
        *,
        axes: int = 1,
        rate: int = 1000,
        low: float | Sequence[float] = -0.01,
        high: float | Sequence[float] = 0.01,
        force: float | Sequence[float] = 0.0,
        continuous: float | Sequence[float] | None = None,
        stiffness: float | Sequence[float] = 0.0,
        model: str = "",
        simulated: bool = False,
    ) -> None:
        if not (1 <= len(name) <= 16 and all(a.isascii() and (a.isalnum() or a in "_-.") for a in name)):
            raise UsageError(f"{name!r} is not a valid device name; use 1 to 16 characters of a-z A-Z 0-9 _ - .")
        if not (1 <= n <= DOF and 1 <= axes <= 3 and n % axes == 0):
            raise UsageError(f"{n} degrees of freedom in vectors of {axes}; use 1 to {DOF}, in whole vectors of 1, 2 or 3")
        if rate < 1:
            raise UsageError(f"rate = {rate}: must be at least 1 frame per second")
        #: degrees of freedom
        self.n = n
        self._name, self._period = name, 1_000_000_000 // int(rate)
        self._uid, self._session = (c.c_uint8 * 16)(*name.encode()), secrets.randbits(63) + 1
        self._about = self._fill(About, rate=int(rate), n=n, axes=axes, model=(c.c_uint8 * 32)(*model.encode()[:32]))
        given = {"low": low, "high": high, "force": force, "stiffness": stiffness,
                 "continuous": force if continuous is None else continuous}  # fmt: skip
        for field, value in given.items():
            values = [float(v) for v in value] if isinstance(value, Sequence) else [float(value)] * n
            if len(values) != n:
                raise UsageError(f"`{field}` has {len(values)} numbers for {n} degrees of freedom; give one, or one for each")
            getattr(self._about, field)[:n] = values
        #: hardware state in the next frames, e.g. ``device.status &= ~Status.POWERED``
        self.status = Status.CONNECTED | Status.POWERED | Status.CALIBRATED
        if simulated:
            self.status |= Status.SIMULATED
        self._seq, self._told, self._due = 0, 0, time.monotonic_ns()
        # send times of the last frames [ns], by their number, and the latency of the newest force
        self._sent = [0] * _SENT
        self._latency: float | None = None
        self._last: Any = None
        self._rested = False
        self._held: Any = None
        self._open()

    def _fill(self, kind: Any, **rest: Any) -> Any:
        return kind(magic=kind.MAGIC, version=1, layout=kind.LAYOUT, device=self._uid, session=self._session, **rest)

    def _open(self) -> None:
        iox = needed("iceoryx2", "device")
        root = os.environ.get("CA_SHM_ROOT") or f"/tmp/ca-{os.getuid()}"
        root = root.rstrip("/")
        os.makedirs(root, mode=0o700, exist_ok=True)
        about = os.stat(root)
        if about.st_uid != os.getuid() or about.st_mode & 0o022:
            what = "belongs to another user or can be written by others"
            raise FailedError(f"`{root}` {what}; set `CA_SHM_ROOT` to another folder")
        prefix, self._held = _claim(root)
        _closed(prefix)
        foreign = _foreign(prefix)
        config = iox.config.default()
        config.global_cfg.root_path = iox.Path.new(root)
        config.global_cfg.prefix = iox.FileName.new(prefix)
        iox.set_log_level_from_env_or(iox.LogLevel.Fatal)
        self._node: Any = iox.NodeBuilder.new().config(config).create(iox.ServiceType.Ipc)

        def line(end: str, kind: Any, history: int) -> Any:
            service = iox.ServiceName.new(f"ca/v1/{self._name}/{end}")
            of = self._node.service_builder(service).publish_subscribe(kind).enable_safe_overflow(True)
            of = of.history_size(history).subscriber_max_buffer_size(4).subscriber_max_borrowed_samples(2)
            return of.max_publishers(1).max_subscribers(8).max_nodes(32).open_or_create()

        self._lines = [line("in", DeviceFrame, 0), line("out", ForceFrame, 0), line("about", About, 1)]
        try:
            self._sends: Any = self._lines[0].publisher_builder().create()
        except iox.PublisherCreateError as e:
            raise FailedError(f"the device `{self._name}` is already running; stop it, or use another name") from e
        self._hears: Any = self._lines[1].subscriber_builder().create()
        self._tells: Any = self._lines[2].publisher_builder().create()
        _unmixed(prefix, foreign)

    def send(
        self,
        position: float | Sequence[float],
        *,
        velocity: float | Sequence[float] | None = None,
        mask: int | None = None,
        measured: float | Sequence[float] | None = None,
        buttons: int = 0,
        deadman: bool = False,
        cause: str = "NONE",
        ack: int | None = None,
    ) -> None:
        """Sends the position of the hand [m], a number or one number for each degree of freedom.

        Call it once per period with a new position, whatever comes back. Without a new position, send nothing: the
        engine would take an old one for a hand at rest.

        Args:
            position: of each degree of freedom [m].
            velocity: of each degree of freedom [m/s], if the hardware measures it; NaN where it does not.
            mask: valid positions, one bit each; default: all. The engine drops a frame that lacks one of its profile.
            measured: forces measured at the motors [N].
            buttons: one bit each.
            deadman: true if the dead man's switch is released, in addition to `status`.
            cause: reason for which the device itself gives no force, one of `CAUSES`.
            ack: number of the force frame that the motors held while the hand moved to this position; default:
                `Device.ack`.

        Raises:
            UsageError: if the number of values does not match the degrees of freedom, the cause is unknown, or the mask
                has too many bits.
        """
        if cause not in CAUSES:
            raise UsageError(f"cause = {cause!r}: must be one of {', '.join(CAUSES)}")
        whole = 2**self.n - 1
        mask = whole if mask is None else mask
        if not 0 <= mask <= whole:
            raise UsageError(f"mask = {mask:#x}: only the lowest {self.n} bits may be set, one per degree of freedom")
        now = time.monotonic_ns()
        if now - self._told >= 1_000_000_000:
            self._tells.send_copy(self._about)
            self._told = now
        else:
            # gives the last message to a process that has connected since
            self._tells.update_connections()
        self._seq += 1
        found = CAUSES.index(cause)
        if found == _NONE:
            # a cause found by the device; otherwise, if the engine gives no force, that none was requested
            found = self._cause(now) if self._last is not None else _DISARMED
            found = found if found in (_NONE, _WATCHDOG, _DISCONNECT) else _DISARMED
        frame = self._fill(
            DeviceFrame, seq=self._seq, ack=self.ack if ack is None else ack, t_device_ns=now, t_host_ns=now,
            period_ns=self._period, status=int(self.status | (Status.DEADMAN if deadman else 0)), cause=found, n=self.n,
            mask=mask, buttons=buttons,
        )  # fmt: skip
        frame.pos[: self.n] = self._each(position)
        if velocity is not None:
            speeds = self._each(velocity)
            frame.vel_mask = sum(1 << k for k, v in enumerate(speeds) if math.isfinite(v))
            frame.vel[: self.n] = [v if math.isfinite(v) else 0.0 for v in speeds]
        if measured is not None:
            frame.force_measured[: self.n] = self._each(measured)
        self._sent[self._seq % _SENT] = now
        self._sends.send_copy(frame)

    def _each(self, value: float | Sequence[float]) -> list[float]:
        values = [float(v) for v in value] if isinstance(value, Sequence) else [float(value)]
        if len(values) != self.n:
            raise UsageError(f"{len(values)} numbers for {self.n} degrees of freedom; give one for each")
        return values

    def force(self) -> list[float]:
        """Returns the force that may reach the motors now [N], one number per degree of freedom.

        It is zero when the last frame has expired, when forces are off or at fault, and from an engine that has not
        been seen at rest yet. The next `send` reports that this force was held.
        """
        while (sample := self._hears.receive()) is not None:
            frame = ForceFrame.from_buffer_copy(sample.payload().contents)
            sample.delete()
            self._take(frame)
        if self._cause(time.monotonic_ns()) != _NONE:
            return [0.0] * self.n
        return [float(f) for f in self._last.force[: self.n]]

    def _take(self, f: Any) -> None:
        ours = (ForceFrame.MAGIC, 1, ForceFrame.LAYOUT, bytes(self._uid))
        if (f.magic, f.version, f.layout, bytes(f.device)) != ours or not 1 <= f.n <= DOF:
            return
        same = self._last is not None and f.session == self._last.session
        if same and f.seq <= self._last.seq:
            return
        self._rested = (self._rested and same) or f.mode not in (1, 2, 3)
        self._last = f
        if f.ack_session == self._session and f.ack > 0 and 0 <= self._seq - f.ack < _SENT:
            self._latency = (time.monotonic_ns() - self._sent[f.ack % _SENT]) * 1e-9

    def _cause(self, now: int) -> int:
        f = self._last
        if f is None:
            return _DISCONNECT
        if not 0 <= now - f.t_host_ns <= min(f.ttl_us * 1000, _LONGEST):
            return _WATCHDOG
        if f.mode not in (1, 2, 3):
            return int(f.cause) if 0 < f.cause < len(CAUSES) else _DISARMED
        if not self._rested:
            return _DISCONNECT
        return _NONE if all(math.isfinite(x) for x in f.force) else _NONFINITE

    @property
    def cause(self) -> str:
        """Why `force` returns zeros; ``NONE`` if it returns a force."""
        return CAUSES[self._cause(time.monotonic_ns())]

    @property
    def mode(self) -> str:
        """Mode of the newest force, one of `MODES`; ``none`` before the first."""
        return "none" if self._last is None else MODES[min(self._last.mode, 4)]

    @property
    def seen(self) -> int:
        """Number of the newest force frame; 0 before the first."""
        return 0 if self._last is None else int(self._last.seq)

    @property
    def ack(self) -> int:
        """Number of the force frame that `force` returned last; 0 before the first.

        The next `send` acknowledges it by default. Over a serial line the position is measured before the new force
        acts, so `send` needs the number before.
        """
        return self.seen

    @property
    def latency(self) -> float | None:
        """Time from sending a frame to receiving the newest force that answers it [s]; ``None`` before the first."""
        return self._latency

    def wait(self) -> None:
        """Sleeps until the next frame is due. Missed periods are skipped, not made up for."""
        now = time.monotonic_ns()
        self._due += self._period * max(1, (now - self._due) // self._period)
        time.sleep(max(0, self._due - now) * 1e-9)

    def close(self) -> None:
        """Disconnects from shared memory."""
        for port in (self._sends, self._hears, self._tells):
            if port is not None:
                port.delete()
        self._sends = self._hears = self._tells = self._node = None
        self._lines = []
        if self._held is not None:
            self._held.close()

    def __enter__(self) -> Device:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
