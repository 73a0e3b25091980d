"""Measures the feel of a piano key: force over depth, let-off, repetition.

    python benches/python/piano_feel.py [CA]

writes `docs/measured/piano-feel.md` and its figures in `docs/measured/piano-feel/`. It needs NumPy and matplotlib, and the
command `ca`, by default `target/release/ca`.
"""

from __future__ import annotations

import sys

import matplotlib

matplotlib.use("agg")
import matplotlib.pyplot as plt
import numpy as np
from played import RATE, ROOT, Array, Played, Points, play, table

PAGE = ROOT / "docs/measured/piano-feel.md"
SHOWN = ROOT / "docs/measured/piano-feel"
TEXT = (ROOT / "models/piano_key.ca.toml").read_text()
KEYS = [f"key[{i}].key" for i in range(3)]
PROBES = ["key[0].key", "key[0].a.weight", "key[0].a.lever", "key[0].a.hammer", "key[0].strike"]
#: rest position of a key, and the depth to which it is pressed, at its bed [m]
UP, PRESS = -8e-3, 9.3e-3
#: least time between two strokes; contacts closer than this are one stroke [s]
APART = 0.01


def hands(points: Points) -> dict[str, Points]:
    """Moves one key; the others stay."""
    return {key: points if i == 0 else [(0.0, UP)] for i, key in enumerate(KEYS)}


def pressed(command: str, points: Points, seconds: float) -> Played:
    return play(command, TEXT, hands(points), seconds, PROBES)


def felt(r: Played) -> Array:
    """Returns the force at the key, averaged over a gesture frame."""
    return np.convolve(r.probes[PROBES[1]] - r.probes[PROBES[2]], np.ones(16) / 16, "same")


def depth(r: Played) -> Array:
    """Returns the depth of the key; a probe of a position is relative to rest."""
    return r.probes[PROBES[0]]


def strokes(r: Played) -> list[int]:
    """Returns the samples at which the hammer meets its string."""
    touching = np.flatnonzero(r.probes[PROBES[4]] < 0)
    return [int(c) for i, c in enumerate(touching) if i == 0 or c - touching[i - 1] > APART * RATE]


def level(sound: Array) -> float:
    return float(20 * np.log10(np.abs(sound).max()))


def centroid(sound: Array) -> float:
    power = np.abs(np.fft.rfft(sound * np.hanning(sound.size))) ** 2
    return float((power * np.fft.rfftfreq(sound.size, 1 / RATE)).sum() / power.sum())


def slow(command: str, ax: plt.Axes) -> tuple[str, Points]:
    """Presses and releases at 10 mm/s."""
    time = 1.05
    points = [(0.0, UP), (0.5, UP), (0.5 + time, 2.5e-3), (0.7 + time, 2.5e-3), (0.7 + 2 * time, UP)]
    r = pressed(command, points, 0.9 + 2 * time)
    x, f, t = depth(r), felt(r), np.arange(r.sound.size) / RATE
    down, up = (t > 0.5) & (t < 0.5 + time), (t > 0.7 + time) & (t < 0.7 + 2 * time)
    ax.plot(1e3 * x[down], f[down], label="down, 10 mm/s")
    ax.plot(1e3 * x[up], f[up], label="up, 10 mm/s")
    ax.set_ylim(-0.2, 1.6)
    before = x[down] < 9.15e-3
    top = int(np.argmax(f[down] * before))
    at = x[down][top]
    over = np.flatnonzero((x[down] > at) & (f[down] < 0.7))[0]
    assert not strokes(r), "a slow key strikes"
    text = f"""Down and up at 10 mm/s. No hammer arrives (the dampers leave {level(r.sound[RATE // 2 :]):.0f} dBFS). The let-off begins at 7.7 mm, where
the jack meets its button, is largest with {f[down][top]:.2f} N at {1e3 * at:.2f} mm, and below 0.7 N {1e3 * (x[down][over] - at):.2f} mm later. On the way up there is
none: the jack is not held.

| depth (mm) | down (N) | up (N) |
|---|---|---|
"""
    for mm in [0.25, 1, 2, 3, 4, 5, 6, 7, 7.5, 8, 8.5, 8.8, 9, 9.5, 10]:
        a, b = (f[way][np.argmin(np.abs(1e3 * x[way] - mm))] for way in (down, up))
        text += f"| {mm} | {a:.2f} | {b:.2f} |\n"
    return text, points


def fast(command: str, ax: plt.Axes) -> tuple[str, Points]:
    """Presses to the bed at constant speeds."""
    text = """Down to the bed at a constant speed. *Travel* is the largest force between 0.3 and 7 mm: weight, and inertia of hammer, lever and
damper; *most* is the largest force before the bed. Above 0.3 m/s the let-off is hidden by the inertia.

| speed (m/s) | travel (N) | most (N) | contacts | hammer (m/s) | level (dBFS) | centroid (Hz) |
|---|---|---|---|---|---|---|
"""
    shown: Points = []
    for speed in [0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6]:
        time = PRESS / speed
        points = [(0.0, UP), (0.5, UP), (0.5 + time, UP + PRESS), (1.2 + time, UP + PRESS)]
        r = pressed(command, points, 1.2 + time)
        x, f, t = depth(r), felt(r), np.arange(r.sound.size) / RATE
        down = (t > 0.5) & (t < 0.5 + time) & (x < 9.15e-3)
        if speed in (0.1, 0.2, 0.4):
            ax.plot(1e3 * x[down], f[down], label=f"{speed} m/s")
        if speed == 0.4:
            shown = points
        at = strokes(r)
        travel = f[down & (x > 0.3e-3) & (x < 7e-3)].max()
        row = f"| {speed} | {travel:.2f} | {f[down].max():.2f} | {len(at)} | "
        if at:
            hammer = np.diff(r.probes[PROBES[3]])[at[0] - 1] * RATE
            heard = r.sound[int((0.53 + time) * RATE) :][: RATE // 2]
            row += f"{hammer:.2f} | {level(r.sound[RATE // 2 :]):.1f} | {centroid(heard):.0f} |\n"
        else:
            row += "0 | no hammer | |\n"
        text += row
    return text, shown


def again(command: str) -> str:
    """Strikes a second time from a depth."""
    rows, first, last = "", 0.0, 10.0
    for mm in [7, 6, 5.5, 5, 4.5, 4.2, 4, 3.5, 3, 2, 0]:
        down, way = PRESS / 0.3, PRESS - 1e-3 * mm
        back = 0.7 + down + way / 0.2
        points = [(0.0, UP), (0.5, UP), (0.5 + down, UP + PRESS), (0.7 + down, UP + PRESS)]
        points += [(back, UP + 1e-3 * mm), (back + 0.02, UP + 1e-3 * mm), (back + 0.02 + way / 0.3, UP + PRESS)]
        r = pressed(command, points, back + way / 0.3 + 0.2)
        n = len(strokes(r))
        force = f"{-r.probes[PROBES[4]][int(back * RATE) :].min():.2f}" if n > 1 else "–"
        rows += f"| {mm} | {n} | {force} |\n"
        first, last = (max(first, mm), last) if n > 1 else (first, min(last, mm))
    return f"""After a stroke of 0.3 m/s the key comes back at 0.2 m/s to a depth, waits 20 ms, and goes down again at 0.3 m/s. A second
stroke is not possible from {last} mm and deeper; it is possible from {first} mm and above.

| back to (mm) | strokes | force of the second (N) |
|---|---|---|
{rows}"""


def repeated(command: str) -> tuple[str, Points]:
    """Plays eight strokes in a row."""
    text = """Eight strokes in a row, 40 % of the time down, 20 % held, 40 % up; how many sound:

| strokes a second | from half release (4 mm) | from full release |
|---|---|---|
"""
    shown: Points = []
    for rate in [6, 8, 10, 12, 14, 16, 20]:
        cells = []
        for mm in (4, 0):
            points = [(0.0, UP), (0.3, UP)]
            for k in range(8):
                begin = 0.3 + k / rate
                points += [(begin + 0.4 / rate, UP + PRESS), (begin + 0.6 / rate, UP + PRESS)]
                points.append((begin + 1 / rate, UP + 1e-3 * mm))
            if (rate, mm) == (12, 4):
                shown = points
            cells.append(f"{len(strokes(pressed(command, points, 0.4 + 8 / rate)))} of 8")
        text += f"| {rate} | {cells[0]} | {cells[1]} |\n"
    text += "\nAbove ten per second from half release, a hundredth of a millisecond decides which strokes sound.\n"
    return text, shown


def main() -> None:
    command = sys.argv[1] if len(sys.argv) > 1 else str(ROOT / "target/release/ca")
    SHOWN.mkdir(exist_ok=True)
    figure, axes = plt.subplots(1, 2, figsize=(13, 5))
    weight, drawn = slow(command, axes[0])
    (SHOWN / "slow.csv").write_text(table(hands(drawn)))
    speeds, drawn = fast(command, axes[1])
    (SHOWN / "fast.csv").write_text(table(hands(drawn)))
    second = again(command)
    repetition, drawn = repeated(command)
    (SHOWN / "repeat.csv").write_text(table(hands(drawn)))
    for ax in axes:
        ax.set(xlabel="depth of the key [mm]", ylabel="force at the key [N]")
        ax.grid()
        ax.legend()
    figure.tight_layout()
    figure.savefig(SHOWN / "feel.webp", dpi=80, pil_kwargs={"quality": 80})

    def line(file: str, seconds: str, more: str = "") -> str:
        key = "--probe 'key[0].key' --probe 'key[0].a.weight' --probe 'key[0].a.lever'" if not more else "--probe 'key[0].key'"
        return f"    ca render piano_key --gesture docs/measured/piano-feel/{file}.csv --seconds {seconds} {key}{more}\n"

    hammer = " --probe 'key[0].a.jack' --probe 'key[0].a.hammer' --probe 'key[0].strike'"
    PAGE.write_text(f"""# How a key of the piano feels

Made by `python benches/python/piano_feel.py`: do not edit.

Key C4 of `models/piano_key.ca.toml`, alone, moved along a list of positions whatever the force. Depth is counted from rest. The force
at the key is the force of its weight and bed minus the force of the lever to the action (`key[0].a.weight` − `key[0].a.lever`), averaged over
a gesture frame (16 samples). The twelve keys of `hammer_piano` have the same action; [hammer-piano.md](hammer-piano.md) lists its energies.

![force at the key against depth](piano-feel/feel.webp)

## Weight and let-off

{weight}
{line("slow", "3")}
## Speed

{speeds}
{line("fast", "1.2")}
(`fast.csv` is the row of 0.4 m/s.)

## Repetition

{second}
{repetition}
{line("repeat", "1.1", hammer)}
(`repeat.csv` is the row of 12 from 4 mm.)
""")


main()
