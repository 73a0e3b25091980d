"""The serial device example, against a simulated microcontroller at the other end of a pty."""

from __future__ import annotations

import importlib.util
import os
import pty
import re
import shutil
import struct
import subprocess
import sys
import threading
import tty
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import cordis_anima.device
from test_device import Alone

ROOT = Path(os.environ.get("CA_ROOT", Path(__file__).parents[4]))


class Microcontroller(threading.Thread):
    """The firmware of docs/devices.md: 0.1 kg with 2 N s/m, 2 ms per exchange. Answers according to `how`."""

    def __init__(self, port: int) -> None:
        super().__init__(daemon=True)
        self.port, self.how, self.heard, self.x, self.v = port, "at once", list[float](), 0.0, 0.0

    def run(self) -> None:
        read = b""
        while True:
            try:
                read += os.read(self.port, 64)
            except OSError:
                return
            while len(read) >= 5:
                if read[:1] != b"F" or sum(read[:4]) % 256 != read[4]:
                    read = read[1:]
                    continue
                count, force = struct.unpack("<Bh", read[1:4])
                read = read[5:]
                x = self.x
                self.heard.append(force / 1000)
                self.v = (self.v + force / 1000 / 0.1 * 0.002) / (1 + 2 / 0.1 * 0.002)
                self.x += self.v * 0.002
                # last, because a test continues as soon as it has the answer
                self.answer(count, x)

    def answer(self, count: int, x: float) -> None:
        body = b"P" + struct.pack("<Bh", count, round(x * 1e5))
        whole = body + bytes([sum(body) % 256])
        old = b"P" + struct.pack("<Bh", (count - 1) % 256, 4999)
        parts = {
            "at once": [whole],
            "in parts": [whole[:1], whole[1:4], whole[4:]],
            "behind noise": [b"PP\x00F" + whole],
            "behind an old one": [old + bytes([sum(old) % 256]) + whole],
            "wrong": [body + bytes([(sum(body) + 1) % 256])],
            "cut": [whole[:3]],
            "not": [],
        }[self.how]
        for part in parts:
            os.write(self.port, part)


@pytest.fixture
def example() -> Any:
    spec = importlib.util.spec_from_file_location("serial_device", ROOT / "crates/ca-py/examples/serial_device.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def line() -> Iterator[tuple[Microcontroller, str]]:
    far, near = pty.openpty()
    tty.setraw(far)
    board = Microcontroller(far)
    board.start()
    yield board, os.ttyname(near)
    os.close(near)


def test_an_exchange_gives_a_force_and_gets_a_position(example: Any, line: tuple[Microcontroller, str]) -> None:
    board, path = line
    example.PATIENCE = 20.0
    link = example.Link(path)
    board.x = 0.01
    for how in ["at once", "in parts", "behind noise", "behind an old one"]:
        board.how, board.v = how, 0.0
        at = board.x
        assert link.exchange(0.25) == pytest.approx(at, abs=1e-5), how
    assert board.heard == [0.25] * 4
    # limited to the largest force of the motor
    link.exchange(99.0)
    assert board.heard[-1] == example.FORCE
    example.PATIENCE = 0.05
    for how in ["wrong", "cut", "not"]:
        board.how = how
        assert link.exchange(0.0) is None, how


def test_a_frame_says_which_force_moved_the_hand(
    example: Any, line: tuple[Microcontroller, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    board, path = line
    example.PATIENCE = 20.0
    made: list[Alone] = []

    class Played(Alone):
        """Receives a new force each period, and a board that is silent in the sixth."""

        def __init__(self, *args: Any, **named: Any) -> None:
            super().__init__(*args, **named)
            self.period = 0
            made.append(self)

        def force(self) -> list[float]:
            self.period += 1
            example.PATIENCE = 0.05 if self.period == 6 else 20.0
            board.how = "not" if self.period == 6 else "at once"
            f = self.hear(self.period, 0 if self.period == 1 else 2)
            f.force[0] = 0.01 * self.period
            return super().force()

    monkeypatch.setattr(example, "Device", Played)
    monkeypatch.setattr(example, "real_time", lambda: None)
    example.main(path, "finger", 10)
    (device,) = made
    frames = device.sends.sent
    # nine of ten periods had a position; each acknowledges the force of the exchange before, or 0 if that was lost
    assert [f.seq for f in frames] == list(range(1, 10))
    assert [f.ack for f in frames] == [0, 1, 2, 3, 4, 0, 7, 8, 9]
    assert board.heard[1:10] == [pytest.approx(0.01 * k, abs=6e-4) for k in range(2, 11)]
    # off at the end
    assert board.heard[10] == 0.0


#: Arduino interface for a program whose serial line is standard input and output; motor forces go to standard error
BOARD = """
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <poll.h>
#include <unistd.h>
unsigned long millis() { timespec t; clock_gettime(CLOCK_MONOTONIC, &t); return t.tv_sec * 1000ul + t.tv_nsec / 1000000; }
struct { void begin(long) {}
    bool available() { pollfd p = {0, POLLIN, 0}; return poll(&p, 1, 1) > 0; }
    int read() { uint8_t b; if (::read(0, &b, 1) != 1) _exit(0); return b; }
    void write(uint8_t *from, int n) { if (::write(1, from, n) != n) _exit(1); } } Serial;
int last = 9999;
void motor(int force) { if (force != last) fprintf(stderr, "%d\\n", last = force); }
int16_t sensor() { return last; }
"""


def test_the_firmware_of_the_page_answers_and_has_a_watchdog(example: Any, tmp_path: Path) -> None:
    compiler = shutil.which("c++")
    if compiler is None:
        pytest.skip("no C++ compiler")
    page = (ROOT / "docs/devices.md").read_text()
    (firmware,) = re.findall(r"^```c\n(.*?)^```", page, re.DOTALL | re.MULTILINE)
    (tmp_path / "board.cpp").write_text(f"{BOARD}{firmware}\nint main() {{ setup(); for (;;) loop(); }}\n")
    subprocess.run([compiler, "-Wall", "-Werror", "-o", "board", "board.cpp"], cwd=tmp_path, check=True)
    far, near = pty.openpty()
    tty.setraw(far)
    board = subprocess.Popen([tmp_path / "board"], stdin=far, stdout=far, stderr=subprocess.PIPE, text=True)
    example.PATIENCE = 20.0
    link = example.Link(os.ttyname(near))
    assert board.stderr is not None and board.stderr.readline() == "0\n"
    # the position is measured before the force acts: here the force held so far
    assert link.exchange(0.5) == 0.0 and board.stderr.readline() == "500\n"
    # after a silence the motor is off
    assert board.stderr.readline() == "0\n"
    assert link.exchange(-0.25) == 0.0 and board.stderr.readline() == "-250\n"
    os.write(link.port, b"F\x01noise")
    assert board.stderr.readline() == "0\n"
    board.kill()
    board.wait()


def test_the_device_is_one_file_without_the_compiled_half(tmp_path: Path) -> None:
    text = Path(cordis_anima.device.__file__).read_text()
    (tmp_path / "device.py").write_text(text)
    script = """
import sys
sys.modules["iceoryx2"] = None
import device
assert "cordis_anima" not in sys.modules
for wrong in (lambda: device.Device("a b"), lambda: device.Device("x", rate=0)):
    try:
        wrong()
    except device.UsageError:
        continue
    raise SystemExit("not refused")
try:
    device.Device("finger")
except ImportError as e:
    assert "pip install iceoryx2==0.10.0" in str(e), e
"""
    env = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
    done = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True, env=env)
    assert done.returncode == 0, done.stderr
