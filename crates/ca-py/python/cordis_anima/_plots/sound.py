"""Plots of sounds, their spectra, and probes.

A spectrum shows a sine at its level, whatever the window.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from .axes import (
    DEPTH,
    NOTHING,
    Affine2D,
    Axes,
    EngFormatter,
    FixedFormatter,
    FixedLocator,
    Line2D,
    along_x,
    decibel,
    given_or_new,
    hertz,
    named,
    plt,
)
from .._errors import UsageError
from .._render import Render
from .._results import Floats, Modes, Sound

Ints = npt.NDArray[np.int64]

#: lowest audible frequency [Hz]
_LOWEST = 20.0
#: range of levels shown in a spectrogram, below the loudest [dB]
_DARK = 90.0
#: most columns of a spectrogram
_COLUMNS = 640
#: longest window of a spectrum [samples]: bins 0.4 Hz apart at 48 kHz
_WINDOW = 1 << 17


def sound(render: Render, ax: Axes | None = None) -> Axes:
    """Plots the waveform, one lane per channel: samples over time [s], where full scale is 1.

    >>> import cordis_anima as ca
    >>> from cordis_anima import plot
    >>> r = ca.load("hammered_string").render(1.0)
    >>> ax = plot.sound(r)
    >>> [line.get_label() for line in ax.lines], bool((ax.lines[1].get_ydata() == r.audio[:, 1]).all())
    (['left', 'right'], True)
    """
    _heard(render)
    lanes = render.audio.shape[1]
    ax = given_or_new(ax, 1.6 + 1.2 * lanes)
    top = float(np.abs(render.audio).max()) or 1.0
    apart = 2.2 * top
    tick = _below(top)
    ticks, texts = [], []
    for k, name in enumerate(render.channels):
        # the data stay unchanged; a transform makes the lane
        down = -k * apart
        lane = Affine2D().translate(0, down) + ax.transData
        ax.plot(_time(render), render.audio[:, k], lw=0.6, color=f"C{k}", label=name, transform=lane)
        ticks += [down - tick, down, down + tick]
        texts += [f"−{tick:g}", "0", f"{tick:g}"]
        if lanes > 1:
            ax.text(0.995, down + top, name, transform=ax.get_yaxis_transform(), ha="right", va="top", color=f"C{k}")
    ax.set_xlim(0, render.seconds)
    ax.set_ylim(-(lanes - 1) * apart - 1.1 * top, 1.1 * top)
    ax.yaxis.set_major_locator(FixedLocator(ticks))
    ax.yaxis.set_major_formatter(FixedFormatter(texts))
    return named(ax, "time [s]", "sound [full scale = 1]")


def spectrum(render: Render, modes: Modes | None = None, ax: Axes | None = None) -> Axes:
    """Plots the level of each channel over frequency [Hz]: a sine at full scale reads 0 dBFS, as in ``ca report``.

    It averages the powers of windows of up to 2.7 s that overlap by half. With `modes`, a line marks each heard
    frequency, labelled [Hz] as far as space allows.

    >>> import cordis_anima as ca
    >>> from cordis_anima import plot
    >>> scene = ca.examples.string()
    >>> ax = plot.spectrum(scene.render(2.0), scene.modes())
    >>> ax.texts[0].get_text()
    '110.0'
    """
    _heard(render)
    ax = given_or_new(ax, 4.0)
    rate = len(render.audio) / render.seconds
    highest = rate / 2
    lowest = min(_LOWEST, highest / 10)
    loudest = NOTHING
    for k, name in enumerate(render.channels):
        f, level = _outline(*_levels(render.audio[:, k], rate), lowest, highest)
        loudest = max(loudest, float(level.max()))
        ax.plot(f, level, lw=0.8, color=f"C{k}", label=name, alpha=0.85)
    ax.set_xscale("log")
    ax.set_xlim(lowest, highest)
    loudest = loudest if loudest > NOTHING else 0.0
    ax.set_ylim(loudest - DEPTH, loudest + 6)
    hertz(ax)
    if modes is not None:
        heard = modes.heard[(modes.heard >= lowest) & (modes.heard <= highest)]
        ax.vlines(heard, 0, 1, transform=along_x(ax), color="black", lw=0.5, alpha=0.35, label="modes [Hz]", zorder=0)
        room = np.log(highest / lowest) * 0.021
        last = -np.inf
        for f in heard:
            if np.log(f) - last >= room:
                last = float(np.log(f))
                ax.annotate(
                    f"{f:.1f}",
                    (f, 0.999),
                    (0, 4),
                    xycoords=along_x(ax),
                    textcoords="offset points",
                    # hides labels outside the axes after zooming
                    annotation_clip=True,
                    rotation=90,
                    ha="center",
                    va="bottom",
                    fontsize=7,
                )
    if modes is not None or len(render.channels) > 1:
        ax.legend(loc="lower left", fontsize=8)
    return named(ax, "frequency [Hz]", "level of a sine [dBFS]")


def spectrogram(render: Render, ax: Axes | None = None) -> Axes:
    """Plots the spectrum over time [s]: the power of all channels; a sine at full scale is 0 dBFS.

    Windows are up to 0.1 s long. Rows have equal frequency ratios and show the loudest bin in them.

    >>> import cordis_anima as ca
    >>> from cordis_anima import plot
    >>> ax = plot.spectrogram(ca.examples.string().render(1.0))
    >>> ax.get_yscale(), ax.collections[0].colorbar.ax.get_ylabel()
    ('log', 'level of a sine [dBFS]')
    """
    _heard(render)
    ax = given_or_new(ax, 4.0)
    n = len(render.audio)
    rate = n / render.seconds
    window = min(n, 1 << int(np.log2(max(2.0, 0.1 * rate))))
    size = 1 << (2 * window - 1).bit_length()
    starts = _starts(n, window, max(min(window // 2, n // _COLUMNS), window // 4, 1))
    step, highest = rate / size, rate / 2
    edges = np.geomspace(min(2 * _LOWEST, highest / 10), highest, 221)
    # a row between two bins shows the next one
    first = np.minimum(np.ceil(edges[:-1] / step).astype(int), size // 2)
    end = np.maximum(np.ceil(edges[1:] / step).astype(int), first + 1)
    # a column shows the loudest of its windows
    each = -(-len(starts) // _COLUMNS)
    columns = []
    for some in (starts[k : k + each] for k in range(0, len(starts), each)):
        power = np.sum([_power(x, some, window, size) for x in render.audio.T], axis=0).max(axis=0)
        columns.append([power[a:b].max() for a, b in zip(first, end)])
    level = decibel(np.array(columns).T)
    loudest = float(level.max())
    loudest = loudest if loudest > NOTHING else 0.0
    # the first column begins with the sound, each other where the one before ends
    centre = (starts + window / 2) / rate
    begin = (centre[each::each] + centre[each - 1 : -1 : each]) / 2
    times = np.concatenate([[0.0], begin, [n / rate]])
    mesh = ax.pcolormesh(times, edges, level, vmin=loudest - _DARK, vmax=loudest, cmap="magma", rasterized=True)
    ax.set_yscale("log")
    hertz(ax, "y")
    bar = ax.figure.colorbar(mesh, ax=ax, pad=0.01)
    bar.set_label("level of a sine [dBFS]")
    ax.grid(False)
    return named(ax, "time [s]", "frequency [Hz]", grid=False)


def probes(render: Render, selector: str | Sequence[str] | None = None, ax: Axes | None = None) -> Axes:
    """Plots probes over time [s]: displacements [m], and forces [N] on a second axis.

    Args:
        selector: one or several selectors of the render; default: all.

    Raises:
        UsageError: if the render lacks the probe.

    >>> import cordis_anima as ca
    >>> from cordis_anima import plot
    >>> r = ca.examples.string().render(0.1, probes=["hammer", "strike"])
    >>> ax = plot.probes(r, "strike")
    >>> ax.get_ylabel(), bool((ax.lines[0].get_ydata() == r.probes["strike"]).all())
    ('force', True)
    """
    asked = list(render.probes) if selector is None else [selector] if isinstance(selector, str) else list(selector)
    for name in asked:
        if name not in render.probes:
            raise UsageError(f"no probe `{name}`; the render has {', '.join(render.probes) or 'none'}")
    if not asked:
        raise UsageError("the render has no probes; record them with `render(…, probes=[…])`")
    ax = given_or_new(ax, 3.4)
    units = list(dict.fromkeys(render.units[name] for name in asked))
    sides = {units[0]: ax}
    if len(units) > 1:
        sides[units[1]] = ax.twinx()
    time = _time(render)
    drawn: list[Line2D] = []
    for probe in asked:
        side, columns = sides[render.units[probe]], render.columns[probe]
        values = render.probes[probe].reshape(len(time), len(columns))
        many = len(columns) > 8
        for k, column in enumerate(columns):
            colour = plt.get_cmap("viridis")(k / (len(columns) - 1)) if many else f"C{len(drawn)}"
            name = column if side is ax else f"{column} (right)"
            (line,) = side.plot(time, values[:, k], lw=0.8, color=colour, label=name)
            # of many, only the first and the last are in the legend
            if not many or k in (0, len(columns) - 1):
                drawn.append(line)
    for unit, side in sides.items():
        named(side, "time [s]", "displacement" if unit == "m" else "force", grid=side is ax)
        side.yaxis.set_major_formatter(EngFormatter(unit=unit))
    if len(sides) > 1:
        sides[units[1]].spines["right"].set_visible(True)
    ax.set_xlim(0, render.seconds)
    # placed above, where it hides no data
    ax.legend(handles=drawn, loc="lower left", bbox_to_anchor=(0, 1), ncols=6, fontsize=8, frameon=False)
    return ax


def _below(top: float) -> float:
    """Largest number of 1, 2 and 5 times a power of ten that is not above the given one."""
    power = 10.0 ** np.floor(np.log10(top))
    return float(max(d * power for d in (1, 2, 5) if d * power <= top * (1 + 1e-9)))


def _heard(render: Render) -> None:
    if render.audio.size == 0:
        raise UsageError("the render has no sound; add a SOX or SOF to the model, and render more than 0 s")


def _time(render: Render) -> Floats:
    """Time of each sample [s]."""
    n = len(render.audio)
    return np.arange(n, dtype=np.float64) / (n / render.seconds)


def _starts(n: int, window: int, hop: int) -> Ints:
    """Start indices of windows at most this far apart, from the first sample to the last."""
    return np.linspace(0, n - window, 1 + -(-(n - window) // hop)).astype(np.int64)


def _power(x: Sound, starts: Ints, window: int, size: int) -> Floats:
    """Power (windows, bins) with Hann windows; a sine of amplitude A has A² at its bin."""
    hann: Floats = 0.5 - 0.5 * np.cos(2 * np.pi * (np.arange(window) + 0.5) / window)
    scale = 2 / hann.sum()
    power = np.empty((len(starts), size // 2 + 1))
    for row, start in zip(power, starts):
        row[:] = (scale * np.abs(np.fft.rfft(hann * x[start : start + window], size))) ** 2
    return power


def _levels(x: Sound, rate: float) -> tuple[Floats, Floats]:
    """Frequencies [Hz] and levels [dBFS] of a sound."""
    window = min(len(x), _WINDOW)
    size = 1 << (2 * window - 1).bit_length()
    power = _power(x, _starts(len(x), window, window // 2 + 1), window, size).mean(axis=0)
    return np.arange(len(power), dtype=np.float64) * (rate / size), decibel(power)


def _outline(f: Floats, level: Floats, lowest: float, highest: float) -> tuple[Floats, Floats]:
    """Loudest bin of each pixel column, at its own frequency."""
    edges = np.searchsorted(f, np.geomspace(lowest, highest, 1501))
    bins = [a + int(np.argmax(level[a:b])) for a, b in zip(edges[:-1], edges[1:]) if b > a]
    return f[bins], level[bins]
