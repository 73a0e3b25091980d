"""Plots of measurements: energy, modes and accuracy."""

from __future__ import annotations

import numpy as np

from .axes import (
    DEPTH,
    DUST,
    GAIN,
    LOSS,
    STOCK,
    Axes,
    EngFormatter,
    along_x,
    counted,
    decibel,
    given_or_new,
    hertz,
    named,
)
from .._errors import UsageError
from .._render import Render
from .._results import Accuracy, Energy, Modes

#: a longer decay counts as infinite [s]
_DAY = 86400.0


def energy(ledger: Render | Energy, ax: Axes | None = None) -> Axes:
    """Plots the energy ledger as a waterfall: a bar for each entry [J], which begins where the one above ends.

    Raises:
        UsageError: if the render lacks a ledger; request it by ``render(…, energy=True)``.

    >>> import cordis_anima as ca
    >>> from cordis_anima import plot
    >>> ax = plot.energy(ca.load("hammered_string").render(1.0, energy=True))
    >>> [text.get_text() for text in ax.get_yticklabels()]
    ['start', 'work of ports', 'heat', 'error of the scheme', 'changed parameters', 'residual', 'stored at the end']
    """
    e = ledger.energy if isinstance(ledger, Render) else ledger
    if e is None:
        raise UsageError("the render has no energy ledger; record it with `render(…, energy=True)`")
    ax = given_or_new(ax, 3.4)
    rows = [
        ("start", 0.0, e.start, STOCK),
        ("work of ports", e.start, e.work, ""),
        ("heat", e.start + e.work, -e.lost, ""),
        ("error of the scheme", e.start + e.work - e.lost, e.made, ""),
        ("changed parameters", e.start + e.work - e.lost + e.made, e.changed, ""),
        ("residual", e.stored - e.residual, e.residual, DUST),
        ("stored at the end", 0.0, e.stored, STOCK),
    ]
    for k, (_, left, width, colour) in enumerate(rows):
        ax.barh(k, width, left=left, height=0.62, color=colour or (GAIN if width > 0 else LOSS))
        if k + 1 < len(rows) - 1:
            ax.plot([left + width] * 2, [k, k + 1], color=DUST, lw=0.7, zorder=0)
        right = max(left, left + width)
        ax.annotate(_joule(width), (right, k), (5, 0), textcoords="offset points", va="center", fontsize=9)
    ax.set_yticks(range(len(rows)), [name for name, *_ in rows])
    ax.set_ylim(len(rows) - 0.4, -0.6)
    ax.axvline(0, color="black", lw=0.8)
    ends = np.array([0.0] + [end for _, left, width, _ in rows for end in (left, left + width)])
    span = float(np.ptp(ends)) or 1.0
    ax.set_xlim(ends.min() - (0.02 * span if ends.min() < 0 else 0), ends.max() + 0.16 * span)
    ax.xaxis.set_major_formatter(EngFormatter(unit="J"))
    ax.tick_params(axis="y", length=0)
    named(ax, f"energy within {e.seconds:.3g} s", "")
    ax.grid(False, axis="y")
    return ax


def modes(modes: Modes, port: str | None = None, ax: Axes | None = None) -> Axes:
    """Plots the decay time T60 [s] of each mode over its frequency [Hz], or its level at `port` [dB].

    Undamped modes are at the upper edge. Levels are of the displacement at `port`, relative to the loudest.

    Raises:
        UsageError: if the port does not exist, or no mode oscillates.

    >>> import cordis_anima as ca
    >>> from cordis_anima import plot
    >>> m = ca.examples.string().modes()
    >>> plot.modes(m).get_ylabel(), plot.modes(m, "out").get_ylabel()
    ('T60 [s]', 'level at `out` [dB, the loudest = 0]')
    """
    swings = modes.heard > 0
    if not swings.any():
        raise UsageError("no mode oscillates")
    if port is not None and port not in modes.ports:
        raise UsageError(f"no port `{port}`; the modes have levels at {', '.join(modes.ports) or 'none'}")
    ax = given_or_new(ax, 3.6)
    f = modes.heard[swings]
    ax.set_xscale("log")
    if port is None:
        falls = (modes.t60[swings] < _DAY) & ~modes.grows[swings]
        ax.plot(f[falls], modes.t60[swings][falls], "o", ms=4, color=STOCK)
        for which, mark, colour, name in [
            (~falls & ~modes.grows[swings], "^", DUST, "without damping"),
            (modes.grows[swings], "X", LOSS, "grows"),
        ]:
            if which.any():
                ax.plot(f[which], np.full(which.sum(), 0.95), mark, ms=6, color=colour, label=name, transform=along_x(ax))
        if falls.any():
            ax.set_yscale("log")
            # at least a factor of 10, so that nearly equal values look nearly equal
            low, high = float(modes.t60[swings][falls].min()), float(modes.t60[swings][falls].max())
            wide = max(0.2, (1 - np.log10(high / low)) / 2)
            ax.set_ylim(low / 10**wide, high * 10**wide)
            counted(ax.yaxis)
        else:
            ax.set_yticks([])
        if not falls.all():
            ax.legend(loc="lower left", fontsize=8)
        name = "T60 [s]"
    else:
        level = np.abs(modes.levels[swings, modes.ports.index(port)])
        level = decibel((level / max(level.max(), 1e-300)) ** 2)
        seen = level >= -DEPTH
        ax.vlines(f[seen], -DEPTH, level[seen], lw=1, color=STOCK, alpha=0.6)
        ax.plot(f[seen], level[seen], "o", ms=4, color=STOCK)
        ax.set_ylim(max(float(level[seen].min()) - 12, -DEPTH), 3)
        name = f"level at `{port}` [dB, the loudest = 0]"
    ax.set_xlim(f.min() / 1.15, f.max() * 1.15)
    hertz(ax)
    still = int((~swings).sum())
    if still:
        ax.set_title(f"modes not shown (no oscillation): {still}", loc="right", fontsize=8)
    return named(ax, "frequency as heard [Hz]", name)


def accuracy(accuracy: Accuracy, ax: Axes | None = None) -> Axes:
    """Plots the error over the time of one sample [ns]: a line per method, through the multiples of the rate.

    Full dots are methods that no other beats in both; they have names as far as space allows. Errors below the error of
    the reference are drawn at that value; unstable methods are named in the legend.

    >>> import cordis_anima as ca
    >>> from cordis_anima import plot
    >>> a = ca.examples.string().accuracy(0.02, times=[1], reference=4)
    >>> ax = plot.accuracy(a)
    >>> ax.get_xlabel(), ax.get_ylabel()
    ('time of one sample [ns]', 'error, relative')
    """
    ax = given_or_new(ax, 4.6)
    error = np.maximum(accuracy.error, accuracy.known)
    finite = np.isfinite(error)
    colours = {method: f"C{k}" for k, method in enumerate(dict.fromkeys(accuracy.method))}
    for method, colour in colours.items():
        of = np.array([m == method for m in accuracy.method])
        at = np.flatnonzero(of & finite)
        lost = ", ".join(f"×{t}" for t in accuracy.times[of & ~finite])
        name = f"{method} ({lost} diverges)" if lost else method
        ax.plot(accuracy.ns[at], error[at], "-o", lw=0.8, ms=6, color=colour, mfc="white", label=name)
    best = np.flatnonzero(accuracy.front & finite)
    for i in best:
        ax.plot(accuracy.ns[i], error[i], "o", ms=6, color=colours[accuracy.method[i]])
    ax.set_xscale("log")
    ax.set_yscale("log")
    ax.margins(0.1)
    counted(ax.xaxis)
    _names(ax, [(accuracy.ns[i], error[i], f"{accuracy.method[i]} ×{accuracy.times[i]}") for i in best])
    ax.set_title(f"against {accuracy.against}", loc="left", fontsize=8)
    key = ax.legend(loc="upper left", bbox_to_anchor=(1.01, 1), fontsize=8, frameon=False, alignment="left")
    key.set_title("filled: no method is both\nmore accurate and faster")
    key.get_title().set_fontsize(8)
    return named(ax, "time of one sample [ns]", "error, relative")


def _names(ax: Axes, points: list[tuple[float, float, str]]) -> None:
    """Adds names beside points, on a side without overlap with names and axes; else leaves them out."""
    ax.autoscale_view()
    dots = [ax.transData.transform((x, y)) for x, y, _ in points]
    per_point = ax.figure.dpi / 72
    taken = [(x - 3 * per_point, y - 3 * per_point, x + 3 * per_point, y + 3 * per_point) for x, y in dots]
    for (x, y, text), (px, py) in zip(points, dots):
        wide, high = 4.8 * len(text) * per_point, 9 * per_point
        for right, up in [(True, True), (False, False), (True, False), (False, True)]:
            left = px + 5 * per_point if right else px - 5 * per_point - wide
            low = py + 3 * per_point if up else py - 3 * per_point - high
            box = (left, low, left + wide, low + high)
            free = all(box[2] < t[0] or t[2] < box[0] or box[3] < t[1] or t[3] < box[1] for t in taken)
            if free and left >= ax.bbox.x0:
                taken.append(box)
                ha, va = ("left" if right else "right"), ("bottom" if up else "top")
                at = (5 if right else -5, 3 if up else -3)
                ax.annotate(text, (x, y), at, textcoords="offset points", ha=ha, va=va, fontsize=8)
                break


def _joule(energy: float) -> str:
    """Formats an energy with a common unit or a power of ten."""
    for factor, unit in [(1.0, "J"), (1e-3, "mJ"), (1e-6, "µJ"), (1e-9, "nJ")]:
        if factor <= abs(energy) < 1000 * factor:
            return f"{energy / factor:.3g} {unit}".replace("-", "−")
    return f"{energy:.2g} J".replace("-", "−") if energy else "0 J"
