"""A device behind a serial line: a microcontroller with one motor and one position sensor.

    python serial_device.py /dev/ttyACM0 finger

Needs `iceoryx2` and no compiler: ``pip install iceoryx2==0.10.0``, and a copy of `device.py` beside this file if the
package `cordis_anima` is not installed.

Each period is one exchange of five bytes. To the microcontroller: ``F``, a counter, the force as a signed 16-bit number
[mN], low byte first, and the sum of these four bytes modulo 256. From it, in the same form: ``P``, the same counter,
the position [10 µm] measured before the new force acts, and the sum. `docs/devices.md` has its firmware.
"""

from __future__ import annotations

import os
import select
import struct
import sys
import termios
import time
import tty

try:
    from cordis_anima.device import Device
except ImportError:
    from device import Device  # type: ignore[import-not-found,no-redef]

#: exchanges per second, largest force [N], travel [m]
RATE, FORCE, TRAVEL = 500, 1.5, 0.05
#: longest wait for an answer [s]: half a period
PATIENCE = 0.5 / RATE


class Link:
    """The serial line."""

    def __init__(self, path: str, speed: int = termios.B115200) -> None:
        self.port = os.open(path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        tty.setraw(self.port)
        set = termios.tcgetattr(self.port)
        set[4] = set[5] = speed
        termios.tcsetattr(self.port, termios.TCSANOW, set)
        self.count = 0

    def exchange(self, force: float) -> float | None:
        """Sends a force [N] and returns the position measured before [m]; ``None`` without a complete answer."""
        self.count = (self.count + 1) % 256
        limited = min(max(force, -FORCE), FORCE)
        body = b"F" + struct.pack("<Bh", self.count, round(1000 * limited))
        os.write(self.port, body + bytes([sum(body) % 256]))
        read, end = b"", time.monotonic() + PATIENCE
        while (left := end - time.monotonic()) > 0:
            if not select.select([self.port], [], [], left)[0]:
                break
            read += os.read(self.port, 64)
            while (at := read.find(b"P")) >= 0 and len(read) >= at + 5:
                answer = read[at : at + 5]
                if sum(answer[:4]) % 256 != answer[4]:
                    # part of another message
                    read = read[at + 1 :]
                    continue
                read = read[at + 5 :]
                # the answer to an abandoned exchange has an old position
                if answer[1] == self.count:
                    return float(struct.unpack("<h", answer[2:4])[0]) * 1e-5
        return None


def real_time(priority: int = 75) -> None:
    """Asks for a real-time priority above the 70 of the engine, which waits for this process."""
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
    except OSError as e:
        print(f"no real-time priority ({e.strerror}); raise `rtprio` in /etc/security/limits.conf", file=sys.stderr)


def main(path: str, name: str, periods: int) -> None:
    link, missed, held = Link(path), 0, 0
    real_time()
    with Device(name, rate=RATE, low=-TRAVEL, high=TRAVEL, force=FORCE, model="serial") as device:
        for _ in range(periods):
            force = device.force()[0]
            given = device.ack
            x = link.exchange(force)
            if x is None:
                # no frame without a position: the engine handles a gap itself
                missed += 1
            else:
                # measured before `force` acted: the hand moved here under the force of the exchange before
                device.send(x, ack=held)
            # after a lost exchange the force at the motor is unknown
            held = given if x is not None else 0
            device.wait()
        link.exchange(0.0)
        took = "" if device.latency is None else f", last latency {1e3 * device.latency:.2f} ms"
        print(f"{periods} periods, {missed} without an answer, seen {device.seen}{took}")


if __name__ == "__main__":
    path, name, periods = (sys.argv[1:] + ["finger", "30000"][len(sys.argv) - 2 :])[:3]
    main(path, name, int(periods))
