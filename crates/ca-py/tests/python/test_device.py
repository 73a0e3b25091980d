"""Rules for the forces at the motors of a Python device, one by one, as in `host/force_watchdog.rs`."""

from __future__ import annotations

import math
import os
import time
from pathlib import Path
from typing import Any

import pytest

import cordis_anima as ca
from cordis_anima import device
from cordis_anima.device import Device, Status


class Lines:
    """Stands in for shared memory."""

    def __init__(self) -> None:
        self.waiting: list[Any] = []
        self.sent: list[Any] = []

    def receive(self) -> Any:
        return Sample(self.waiting.pop(0)) if self.waiting else None

    def send_copy(self, frame: Any) -> None:
        self.sent.append(type(frame).from_buffer_copy(frame))

    def update_connections(self) -> None:
        pass

    def delete(self) -> None:
        pass


class Sample:
    def __init__(self, frame: Any) -> None:
        self.contents = frame

    def payload(self) -> Sample:
        return self

    def delete(self) -> None:
        pass


class Alone(Device):
    """A device without shared memory."""

    def _open(self) -> None:
        self.hears, self.sends, self.tells = Lines(), Lines(), Lines()
        self._hears, self._sends, self._tells, self._node = self.hears, self.sends, self.tells, None
        self._lines = []

    def hear(self, seq: int, mode: int, *, session: int = 7, age: int = 0, **other: Any) -> Any:
        """A force of 1.5 N on the first degree of freedom, sent `age` nanoseconds ago."""
        f = device.ForceFrame(
            magic=device.ForceFrame.MAGIC, version=1, layout=device.ForceFrame.LAYOUT, device=self._uid,
            session=session, seq=seq, t_host_ns=time.monotonic_ns() - age, ttl_us=60_000, mode=mode, n=2,
        )  # fmt: skip
        f.force[0] = 1.5
        for name, value in other.items():
            setattr(f, name, value)
        self.hears.waiting.append(f)
        return f


@pytest.fixture
def finger(monkeypatch: pytest.MonkeyPatch) -> Alone:
    """A device whose clock stands still, so that ages of frames do not depend on the machine."""
    now = time.monotonic_ns()
    monkeypatch.setattr(time, "monotonic_ns", lambda: now)
    d = Alone("finger", 2, low=-0.02, high=[0.02, 0.03], force=10.0)
    d.hear(1, 0)
    assert d.force() == [0.0, 0.0] and d.cause == "DISARMED"
    return d


def test_a_force_is_given_while_it_is_fresh_and_meant(finger: Alone) -> None:
    for seq, mode, gives in [(2, 1, True), (3, 2, True), (4, 3, True), (5, 4, False), (6, 77, False), (7, 0, False)]:
        finger.hear(seq, mode)
        assert (finger.force() == [1.5, 0.0]) == gives, mode
    finger.hear(8, 2, age=61_000_000)
    assert finger.force() == [0.0, 0.0] and finger.cause == "WATCHDOG_OUT"
    # no force lives longer than 0.1 s, and a time stamp in the future belongs to another clock
    finger.hear(9, 2, age=101_000_000, ttl_us=2**32 - 1)
    assert finger.force() == [0.0, 0.0]
    finger.hear(10, 2, age=-1_000_000_000)
    assert finger.force() == [0.0, 0.0]


def test_frames_of_others_and_of_the_past_change_nothing(finger: Alone) -> None:
    finger.hear(9, 2)
    assert finger.force() == [1.5, 0.0]
    for other in [{"magic": 1}, {"version": 2}, {"layout": 3}, {"n": 0}, {"n": 33}]:
        f = finger.hear(10, 2, **other)
        f.force[0] = 5.0
        assert finger.force() == [1.5, 0.0], other
    for old in (9, 3):
        finger.hear(old, 2).force[0] = 5.0
        assert finger.force() == [1.5, 0.0], old
    f = finger.hear(10, 2)
    f.device[0] ^= 1
    assert finger.seen == 9 and finger.force() == [1.5, 0.0] and finger.seen == 9


def test_an_engine_that_was_not_seen_at_rest_gives_nothing(finger: Alone) -> None:
    finger.hear(1, 2, session=8)
    assert finger.force() == [0.0, 0.0] and finger.cause == "DISCONNECT"
    finger.hear(2, 0, session=8)
    finger.hear(3, 2, session=8)
    assert finger.force() == [1.5, 0.0]


def test_what_is_no_number_reaches_no_motor(finger: Alone) -> None:
    f = finger.hear(2, 2)
    f.force[1] = math.nan
    assert finger.force() == [0.0, 0.0] and finger.cause == "NONFINITE"


def test_a_frame_says_which_force_was_held_and_why_there_is_none() -> None:
    d = Alone("finger", 2, rate=500)
    d.send([0.001, 0.002])
    first = d.sends.sent[-1]
    assert (first.seq, first.ack, first.n, first.mask, first.period_ns) == (1, 0, 2, 3, 2_000_000)
    assert list(first.pos[:2]) == [0.001, 0.002] and device.CAUSES[first.cause] == "DISARMED"
    d.hear(1, 0)
    d.hear(2, 2)
    assert d.force() == [1.5, 0.0]
    # a force that arrived meanwhile was not held
    d.hear(3, 2)
    d.send([0.0, 0.0])
    assert (d.sends.sent[-1].ack, device.CAUSES[d.sends.sent[-1].cause]) == (2, "NONE")
    d.send([0.0, 0.0], cause="BUTTON", buttons=5, measured=[1.5, 0.0])
    last = d.sends.sent[-1]
    assert (device.CAUSES[last.cause], last.buttons, last.force_measured[0]) == ("BUTTON", 5, 1.5)
    d.hear(4, 2, age=70_000_000)
    d.force()
    d.send([0.0, 0.0])
    assert device.CAUSES[d.sends.sent[-1].cause] == "WATCHDOG_OUT"


def test_what_a_frame_says_of_the_hardware_is_public() -> None:
    d = Alone("finger", 2, simulated=True)
    assert d.status == Status.CONNECTED | Status.POWERED | Status.CALIBRATED | Status.SIMULATED
    d.send([0.0, 0.0], velocity=[0.5, math.nan], mask=0b01, deadman=True)
    frame = d.sends.sent[-1]
    assert (frame.mask, frame.vel_mask, list(frame.vel[:2])) == (1, 1, [0.5, 0.0])
    assert frame.status == int(d.status | Status.DEADMAN)
    d.status &= ~Status.POWERED
    d.send([0.0, 0.0])
    frame = d.sends.sent[-1]
    assert (frame.mask, frame.vel_mask, frame.status) == (3, 0, 1 | 4 | 256)
    for wrong in [{"mask": 4}, {"mask": -1}, {"cause": "TIRED"}, {"velocity": [1.0]}]:
        with pytest.raises(ca.UsageError):
            d.send([0.0, 0.0], **wrong)  # type: ignore[arg-type]


def test_acknowledgement_and_latency_are_public(monkeypatch: pytest.MonkeyPatch) -> None:
    now = time.monotonic_ns()
    monkeypatch.setattr(time, "monotonic_ns", lambda: now)
    d = Alone("finger", 2)
    assert d.ack == 0 and d.latency is None
    d.send([0.0, 0.0])
    now += 2_000_000
    d.hear(1, 0, ack_session=d._session, ack=1)
    d.force()
    assert d.ack == 1 and d.latency == pytest.approx(0.002)
    # for a position measured before that force acted
    d.send([0.0, 0.0], ack=0)
    assert d.sends.sent[-1].ack == 0
    d.send([0.0, 0.0])
    assert d.sends.sent[-1].ack == 1
    # an answer to another process, or to no frame, gives no latency
    now += 5_000_000
    d.hear(2, 0, ack_session=d._session + 1, ack=3)
    d.hear(3, 0, ack_session=d._session, ack=0)
    d.force()
    assert d.ack == 3 and d.latency == pytest.approx(0.002)


def test_it_says_what_it_is_once_a_second() -> None:
    d = Alone("finger", 2, rate=500, low=-0.02, high=[0.02, 0.03], force=10.0, continuous=3.0, model="finger")
    for _ in range(3):
        d.send([0.0, 0.0])
    assert len(d.tells.sent) == 1
    about = d.tells.sent[0]
    assert (about.n, about.axes, about.rate, bytes(about.model).rstrip(b"\0")) == (2, 1, 500, b"finger")
    assert [round(about.high[k], 6) for k in (0, 1, 2)] == [0.02, 0.03, 0.0]
    assert (about.force[1], about.continuous[0]) == (10.0, 3.0)


def test_what_cannot_be_is_refused() -> None:
    for bad in [
        lambda: Alone("a b"),
        lambda: Alone("x" * 17),
        lambda: Alone("finger", 33),
        lambda: Alone("finger", 4, axes=3),
        lambda: Alone("finger", rate=0),
        lambda: Alone("finger", 2, low=[0.0]),
        lambda: Alone("finger", 2).send(0.0),
    ]:
        with pytest.raises(ca.UsageError):
            bad()


def test_a_place_has_one_random_prefix(tmp_path: Path) -> None:
    first, held = device._claim(str(tmp_path))
    assert first == f"ca1-0.10.0-{(tmp_path / 'prefix').read_text()}_"
    assert (tmp_path / "prefix").stat().st_mode & 0o777 == 0o600
    again, other = device._claim(str(tmp_path))
    assert again == first
    held.close()
    other.close()
    for damaged in ("", "12", "xxxxxxxx", "0123456789"):
        (tmp_path / "prefix").write_text(damaged)
        anew, held = device._claim(str(tmp_path))
        held.close()
        assert len(anew) == len(first) and damaged != (tmp_path / "prefix").read_text()


@pytest.mark.skipif(os.getuid() != 0 or not os.path.isdir("/dev/shm"), reason="only root can be another user")
def test_a_prefix_with_a_file_of_another_user_is_replaced_once_no_process_uses_it(tmp_path: Path) -> None:
    first, held = device._claim(str(tmp_path))
    squat = Path(f"/dev/shm/{first}squat")
    squat.touch()
    os.chown(squat, 65534, 65534)
    try:
        same, other = device._claim(str(tmp_path))
        assert same == first, "it is in use"
        device._closed(first)
        held.close()
        other.close()
        second, held = device._claim(str(tmp_path))
        held.close()
        assert second != first and squat.exists()
        assert [path for path, _ in device._named(first)] == [str(squat)], "what was ours there is removed"
    finally:
        squat.unlink()
