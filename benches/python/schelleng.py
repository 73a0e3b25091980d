"""Schelleng map of the bowed string: slips per period over speed, place and force of the bow.

    python benches/python/schelleng.py [CA]

writes `docs/measured/bowed-string.md` and its figures in `docs/measured/bowed-string/`. It needs NumPy and matplotlib, and the
command `ca`, by default `target/release/ca`.

Each point is one render of 1.3 s: the bow is pressed first, then drawn, at full speed within 50 ms. In a slip the string moves
back against the hair by more than 0.3 of the speed of the bow; slips are counted over the last 0.5 s.
"""

from __future__ import annotations

import sys
from concurrent.futures import ThreadPoolExecutor
from itertools import product

import matplotlib

matplotlib.use("agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.patches import Patch
from matplotlib.ticker import ScalarFormatter
from played import RATE, ROOT, Array, play, table

MODEL = ROOT / "models/bowed_string.ca.toml"
PAGE = ROOT / "docs/measured/bowed-string.md"
SHOWN = ROOT / "docs/measured/bowed-string"
#: pitch of the open string [Hz]; largest sticking force [N] and its position [m]; sliding force of the hair [N]
PITCH, MOST, DEEP, SLIDE = 146.83, 6.0, 0.25, 0.6
#: mass that is bowed, and number of masses
NODE, MASSES = 11, 100
SPEEDS = np.geomspace(0.03, 0.6, 14)
FORCES = np.geomspace(0.65, 6, 20)
NODES = [5, 7, 9, 11, 14, 18, 23]
#: limits in the header of the model [N s/m]
LEAST, LARGEST = 3.5, 10.0
KINDS = ["no slip that lasts", "one slip a period (Helmholtz)", "several slips", "less than one: raucous"]


def stroke(speed: float, force: float) -> dict[str, list[tuple[float, float]]]:
    """Presses the bow, then draws it."""
    start, ramp = -0.22, 0.05
    draw = [(0.0, start), (0.1, start)]
    draw += [(0.1 + ramp * k / 10, start + speed * ramp * (k / 10) ** 2 / 2) for k in range(1, 11)]
    draw.append((2.1 + ramp, start + speed * (ramp / 2 + 2)))
    return {"bow.draw": draw, "bow.press": [(0.0, 0.0), (0.05, force / MOST * DEEP)]}


def slips(command: str, speed: float, force: float, node: int) -> float:
    """Returns the slips per period."""
    text = MODEL.read_text()
    assert text.count(f'on = "low[{NODE}]"') == 1
    text = text.replace(f'on = "low[{NODE}]"', f'on = "low[{node}]"')
    hair, string = "bow.hair", f"low[{node}]"
    r = play(command, text, stroke(speed, force), 1.3, [hair, string])
    relative = (np.diff(r.probes[string]) - np.diff(r.probes[hair])) * RATE
    slipping = relative[-RATE // 2 :] < -0.3 * speed
    return float((slipping[1:] & ~slipping[:-1]).sum() / (0.5 * PITCH))


def kind(found: float) -> int:
    if found < 0.05:
        return 0
    return 1 if 0.93 <= found <= 1.07 else 2 if found > 1.07 else 3


def edges(grid: Array) -> Array:
    return np.r_[grid[0] / np.sqrt(grid[1] / grid[0]), np.sqrt(grid[1:] * grid[:-1]), grid[-1] * np.sqrt(grid[-1] / grid[-2])]


def picture(by_speed: Array, by_place: Array) -> None:
    colours = ListedColormap(["#dddddd", "#2b8a3e", "#f2b84b", "#c0392b"])
    figure, axes = plt.subplots(1, 2, figsize=(12, 5.2))
    places = (np.array(NODES) + 1) / (MASSES + 1)
    shown = [(SPEEDS, by_speed, "speed of the bow [m/s]"), (places, by_place, "place of the bow, from the bridge [length]")]
    for ax, (grid, found, label) in zip(axes, shown):
        ax.pcolormesh(edges(grid), edges(FORCES), np.vectorize(kind)(found), cmap=colours, vmin=-0.5, vmax=3.5)
        ax.set(xscale="log", yscale="log", xlabel=label, ylabel="force that the hair sticks with [N]")
        ax.set_yticks([0.6, 1, 2, 3, 4, 6])
        for axis in (ax.xaxis, ax.yaxis):
            axis.set_major_formatter(ScalarFormatter())
            axis.minorticks_off()
        for (i, force), (j, x) in product(enumerate(FORCES), enumerate(grid)):
            ax.text(x, force, f"{found[i, j]:.1f}", ha="center", va="center", fontsize=6)
    axes[0].set_xticks([0.03, 0.05, 0.1, 0.2, 0.3, 0.6])
    axes[1].set_xticks([0.06, 0.08, 0.1, 0.12, 0.15, 0.2, 0.24])
    speed = np.geomspace(0.03, 0.6)
    for slope in (LEAST, LARGEST):
        axes[0].plot(speed, SLIDE + slope * speed, "k--", lw=1)
    axes[0].set_ylim(0.6, 6.5)
    axes[0].set_title(f"place {places[NODES.index(NODE)]:.3f}; dashed: {SLIDE} N + {LEAST} and {LARGEST:.0f} N s/m times speed")
    axes[1].set_title("speed 0.2 m/s")
    figure.legend(handles=[Patch(color=colours(i), label=k) for i, k in enumerate(KINDS)], ncol=4, loc="lower center")
    figure.tight_layout(rect=(0, 0.05, 1, 1))
    figure.savefig(SHOWN / "schelleng.webp", dpi=90, pil_kwargs={"quality": 80})


def csv(by_speed: Array, by_place: Array) -> str:
    rows = ["map,speed_m_s,place,force_N,slips_per_period"]
    for i, force in enumerate(FORCES):
        at = (NODE + 1) / (MASSES + 1)
        rows += [f"speed,{v:.4f},{at:.4f},{force:.4f},{by_speed[i, j]:.3f}" for j, v in enumerate(SPEEDS)]
        rows += [
            f"place,0.2000,{(n + 1) / (MASSES + 1):.4f},{force:.4f},{by_place[i, j]:.3f}" for j, n in enumerate(NODES)
        ]
    return "\n".join(rows) + "\n"


def span(found: Array) -> str:
    """Formats the least and largest force with one slip a period, and how many of the forces between have it."""
    hits = [i for i, s in enumerate(found) if kind(s) == 1]
    if not hits:
        return "– | – | 0 of 0"
    return f"{FORCES[hits[0]]:.2f} | {FORCES[hits[-1]]:.2f} | {len(hits)} of {hits[-1] - hits[0] + 1}"


def page(by_speed: Array, by_place: Array) -> str:
    kinds = np.vectorize(kind)(by_speed)
    counts = [int((kinds == k).sum()) for k in range(4)]
    forces = FORCES[:, None] - SLIDE
    between = (forces > LEAST * SPEEDS) & (forces < LARGEST * SPEEDS)
    inside = f"{int((kinds[between] == 1).sum())} of {int(between.sum())}"
    outside = f"{int((kinds[~between] == 1).sum())} of {int((~between).sum())}"
    out = f"""# Bow speed and force of the bowed string

Made by `python benches/python/schelleng.py`: do not edit.

`models/bowed_string.ca.toml`, each point one render: the bow is pressed first, then drawn, and reaches full speed within 50 ms. Slips
are counted for half a second, 0.65 s later. In a slip the string moves back against the hair by more than 0.3 of the speed of
the bow. One slip per period (0.93 to 1.07) is Helmholtz motion; less force makes several, more force makes the sound raucous
(J. C. Schelleng, *The bowed string and the player*, JASA 53, 1973).

![slips per period over speed and force, and over place and force](bowed-string/schelleng.webp)

All points are in [schelleng.csv](bowed-string/schelleng.csv). At the place where the model is bowed, {(NODE + 1) / (MASSES + 1):.3f} of the string
from the bridge, {counts[1]} of {kinds.size} points have one slip a period, {counts[2]} have several, {counts[3]} are raucous and {counts[0]} fall silent. Between
the lines {SLIDE} N + {LEAST} N s/m and {SLIDE} N + {LARGEST:.0f} N s/m times the speed, which the header of the model gives, {inside}
have one; beyond them {outside}.

## Over the speed of the bow

The least and the largest of the {len(FORCES)} forces with one slip per period, and how many of the forces between them have one.

| speed (m/s) | least (N) | largest (N) | forces |
|---|---|---|---|
"""
    for j, v in enumerate(SPEEDS):
        out += f"| {v:.3f} | {span(by_speed[:, j])} |\n"
    out += """
## Over the place of the bow

At 0.2 m/s. Nearer the bridge both limits of force are higher, as Schelleng found.

| place (length) | least (N) | largest (N) | forces |
|---|---|---|---|
"""
    for j, n in enumerate(NODES):
        out += f"| {(n + 1) / (MASSES + 1):.3f} | {span(by_place[:, j])} |\n"
    out += """
To hear one point:

    ca render bowed_string --gesture docs/measured/bowed-string/stroke.csv --seconds 1.3 --probe bow.hair --probe 'low[11]'

The bow moves at 0.2 m/s and sticks with 2 N.
"""
    return out


def main() -> None:
    command = sys.argv[1] if len(sys.argv) > 1 else str(ROOT / "target/release/ca")
    points = [(v, f, NODE) for f in FORCES for v in SPEEDS] + [(0.2, f, n) for f in FORCES for n in NODES]
    with ThreadPoolExecutor(2) as pool:
        found = np.array(list(pool.map(lambda p: slips(command, *p), points)))
    by_speed = found[: FORCES.size * SPEEDS.size].reshape(FORCES.size, SPEEDS.size)
    by_place = found[by_speed.size :].reshape(FORCES.size, len(NODES))
    SHOWN.mkdir(exist_ok=True)
    picture(by_speed, by_place)
    (SHOWN / "schelleng.csv").write_text(csv(by_speed, by_place))
    (SHOWN / "stroke.csv").write_text(table(stroke(0.2, 2.0)))
    PAGE.write_text(page(by_speed, by_place))


main()
