"""Plots of what was heard and measured, by matplotlib: ``pip install "cordis-anima[plot]"``.

>>> import cordis_anima as ca
>>> from cordis_anima import plot
>>> ax = plot.spectrum(ca.examples.string().render(1.0))
>>> ax.get_xlabel(), ax.get_ylabel()
('frequency [Hz]', 'level of a sine [dBFS]')

Each function draws one record and returns its Axes, a new one where none is given as `ax`; all else that matplotlib can
do with it is left to the caller.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
import numpy.typing as npt

from ._errors import MissingError, UsageError
from ._render import Render
from ._results import Accuracy, Energy, Floats, Modes, Sound
from ._sweep import Sweep
from ._take import Take

try:
    import matplotlib.pyplot as plt
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.lines import Line2D
    from matplotlib.ticker import EngFormatter, FixedFormatter, FixedLocator, FuncFormatter, LogLocator, NullFormatter
    from matplotlib.transforms import Affine2D, Transform
except ImportError as e:
    raise MissingError('plots need matplotlib: pip install "cordis-anima[plot]"', name="matplotlib") from e

Ints = npt.NDArray[np.int64]
#: from the lowest pitch that is heard up [Hz]
_LOWEST = 20.0
#: how far below the loudest a spectrum and a spectrogram are shown [dB]
_DEPTH, _DARK = 120.0, 90.0
#: level of what is silent [dB]
_NOTHING = -300.0
#: most columns of a spectrogram
_COLUMNS = 640
#: longest window of a spectrum [samples]: bins 0.4 Hz apart at 48 kHz
_WINDOW = 1 << 17
#: what rings longer than a day does not fall [s]
_DAY = 86400.0
#: columns of a sweep that say nothing of a run which was not played to its end
_HEARD = ("peak", "rms", "partial", "t60", "residual")
#: what columns of a sweep are counted in; those of parameters are in SI units
_UNITS = {"partial": "Hz", "t60": "s", "failed": "s", "run_time": "s", "peak": "full scale = 1", "rms": "full scale = 1"}
#: colours of what is gained, given away, there, and of no weight
_GAIN, _LOSS, _STOCK, _DUST = "#2a9d6f", "#d1603d", "#3b6ea5", "#777777"
#: colours of how a force is meant
_MODES = {"off": "#b8b8b8", "ramp": "#f2d16b", "on": "#a9d8b8", "damp": "#f0a35e", "fault": "#e08080"}
#: the share of the longest way of all degrees of freedom below which one does not move: a sensor makes noise
_STILL = 0.01


def sound(render: Render, ax: Axes | None = None) -> Axes:
    """The waveform, a lane for each channel: samples over time [s], at full scale they are 1.

    >>> import cordis_anima as ca
    >>> from cordis_anima import plot
    >>> r = ca.load("hammered_string").render(1.0)
    >>> ax = plot.sound(r)
    >>> [line.get_label() for line in ax.lines], bool((ax.lines[1].get_ydata() == r.audio[:, 1]).all())
    (['left', 'right'], True)
    """
    _heard(render)
    lanes = render.audio.shape[1]
    ax = _axes(ax, 1.6 + 1.2 * lanes)
    top = float(np.abs(render.audio).max()) or 1.0
    apart = 2.2 * top
    tick = _below(top)
    ticks, texts = [], []
    for k, name in enumerate(render.channels):
        # samples stay what they are: the lane is in how they are drawn
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
    return _named(ax, "time [s]", "sound [full scale = 1]")


def spectrum(render: Render, modes: Modes | None = None, ax: Axes | None = None) -> Axes:
    """The level of each channel over frequency [Hz]: a sine at full scale reads 0 dBFS, as in ``ca report``.

    Windows of up to 2.7 s that overlap by half, whose powers are averaged. Where `modes` are given, a line stands at
    each frequency that is heard, with a number [Hz] as far as there is room.

    >>> import cordis_anima as ca
    >>> from cordis_anima import plot
    >>> scene = ca.examples.string()
    >>> ax = plot.spectrum(scene.render(2.0), scene.modes())
    >>> ax.texts[0].get_text()
    '110.0'
    """
    _heard(render)
    ax = _axes(ax, 4.0)
    rate = len(render.audio) / render.seconds
    highest = rate / 2
    lowest = min(_LOWEST, highest / 10)
    loudest = _NOTHING
    for k, name in enumerate(render.channels):
        f, level = _outline(*_levels(render.audio[:, k], rate), lowest, highest)
        loudest = max(loudest, float(level.max()))
        ax.plot(f, level, lw=0.8, color=f"C{k}", label=name, alpha=0.85)
    ax.set_xscale("log")
    ax.set_xlim(lowest, highest)
    loudest = loudest if loudest > _NOTHING else 0.0
    ax.set_ylim(loudest - _DEPTH, loudest + 6)
    _hertz(ax)
    if modes is not None:
        heard = modes.heard[(modes.heard >= lowest) & (modes.heard <= highest)]
        ax.vlines(heard, 0, 1, transform=_above(ax), color="black", lw=0.5, alpha=0.35, label="modes [Hz]", zorder=0)
        room = np.log(highest / lowest) * 0.021
        last = -np.inf
        for f in heard:
            if np.log(f) - last >= room:
                last = float(np.log(f))
                ax.annotate(
                    f"{f:.1f}",
                    (f, 0.999),
                    (0, 4),
                    xycoords=_above(ax),
                    textcoords="offset points",
                    # not beside the axes where somebody looks closer
                    annotation_clip=True,
                    rotation=90,
                    ha="center",
                    va="bottom",
                    fontsize=7,
                )
    if modes is not None or len(render.channels) > 1:
        ax.legend(loc="lower left", fontsize=8)
    return _named(ax, "frequency [Hz]", "level of a sine [dBFS]")


def spectrogram(render: Render, ax: Axes | None = None) -> Axes:
    """How the spectrum goes with time [s]: the power of all channels, a sine at full scale is 0 dBFS.

    Windows of up to 0.1 s; rows are equal ratios of frequency and show the loudest that is in them.

    >>> import cordis_anima as ca
    >>> from cordis_anima import plot
    >>> ax = plot.spectrogram(ca.examples.string().render(1.0))
    >>> ax.get_yscale(), ax.collections[0].colorbar.ax.get_ylabel()
    ('log', 'level of a sine [dBFS]')
    """
    _heard(render)
    ax = _axes(ax, 4.0)
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
    level = _decibel(np.array(columns).T)
    loudest = float(level.max())
    loudest = loudest if loudest > _NOTHING else 0.0
    # it begins where the sound does, and each where the one before ends
    centre = (starts + window / 2) / rate
    begin = (centre[each::each] + centre[each - 1 : -1 : each]) / 2
    times = np.concatenate([[0.0], begin, [n / rate]])
    mesh = ax.pcolormesh(times, edges, level, vmin=loudest - _DARK, vmax=loudest, cmap="magma", rasterized=True)
    ax.set_yscale("log")
    _hertz(ax, "y")
    bar = ax.figure.colorbar(mesh, ax=ax, pad=0.01)
    bar.set_label("level of a sine [dBFS]")
    ax.grid(False)
    return _named(ax, "time [s]", "frequency [Hz]", grid=False)


def energy(book: Render | Energy, ax: Axes | None = None) -> Axes:
    """The energy book as an account: a bar for each entry [J], which begins where the one above ends.

    Raises:
        UsageError: the render kept none; ask for it by ``render(…, energy=True)``.

    >>> import cordis_anima as ca
    >>> from cordis_anima import plot
    >>> ax = plot.energy(ca.load("hammered_string").render(1.0, energy=True))
    >>> [text.get_text() for text in ax.get_yticklabels()]
    ['start', 'work of ports', 'heat', 'made by the scheme', 'changed parameters', 'residual', 'stored at the end']
    """
    e = book.energy if isinstance(book, Render) else book
    if e is None:
        raise UsageError("no energy book was kept: `render(…, energy=True)`")
    ax = _axes(ax, 3.4)
    rows = [
        ("start", 0.0, e.start, _STOCK),
        ("work of ports", e.start, e.work, ""),
        ("heat", e.start + e.work, -e.lost, ""),
        ("made by the scheme", e.start + e.work - e.lost, e.made, ""),
        ("changed parameters", e.start + e.work - e.lost + e.made, e.changed, ""),
        ("residual", e.stored - e.residual, e.residual, _DUST),
        ("stored at the end", 0.0, e.stored, _STOCK),
    ]
    for k, (_, left, width, colour) in enumerate(rows):
        ax.barh(k, width, left=left, height=0.62, color=colour or (_GAIN if width > 0 else _LOSS))
        if k + 1 < len(rows) - 1:
            ax.plot([left + width] * 2, [k, k + 1], color=_DUST, lw=0.7, zorder=0)
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
    _named(ax, f"energy within {e.seconds:.3g} s", "")
    ax.grid(False, axis="y")
    return ax


def modes(modes: Modes, port: str | None = None, ax: Axes | None = None) -> Axes:
    """How long each mode rings, T60 [s], over the frequency that is heard [Hz]; or how loud it is at `port` [dB].

    What has no damping stands at the upper edge; levels are those of the displacement at `port`, the loudest is 0 dB.

    Raises:
        UsageError: no such port, or nothing swings.

    >>> import cordis_anima as ca
    >>> from cordis_anima import plot
    >>> m = ca.examples.string().modes()
    >>> plot.modes(m).get_ylabel(), plot.modes(m, "out").get_ylabel()
    ('T60 [s]', 'level at `out` [dB, the loudest = 0]')
    """
    swings = modes.heard > 0
    if not swings.any():
        raise UsageError("nothing in it swings")
    if port is not None and port not in modes.ports:
        raise UsageError(f"no port `{port}`; the modes have levels at {', '.join(modes.ports) or 'none'}")
    ax = _axes(ax, 3.6)
    f = modes.heard[swings]
    ax.set_xscale("log")
    if port is None:
        falls = (modes.t60[swings] < _DAY) & ~modes.grows[swings]
        ax.plot(f[falls], modes.t60[swings][falls], "o", ms=4, color=_STOCK)
        for which, mark, colour, name in [
            (~falls & ~modes.grows[swings], "^", _DUST, "without damping"),
            (modes.grows[swings], "X", _LOSS, "grows"),
        ]:
            if which.any():
                ax.plot(f[which], np.full(which.sum(), 0.95), mark, ms=6, color=colour, label=name, transform=_above(ax))
        if falls.any():
            ax.set_yscale("log")
            # no narrower than a factor of 10, so that nearly equal ones look so
            low, high = float(modes.t60[swings][falls].min()), float(modes.t60[swings][falls].max())
            wide = max(0.2, (1 - np.log10(high / low)) / 2)
            ax.set_ylim(low / 10**wide, high * 10**wide)
            _counted(ax.yaxis)
        else:
            ax.set_yticks([])
        if not falls.all():
            ax.legend(loc="lower left", fontsize=8)
        name = "T60 [s]"
    else:
        level = np.abs(modes.levels[swings, modes.ports.index(port)])
        level = _decibel((level / max(level.max(), 1e-300)) ** 2)
        seen = level >= -_DEPTH
        ax.vlines(f[seen], -_DEPTH, level[seen], lw=1, color=_STOCK, alpha=0.6)
        ax.plot(f[seen], level[seen], "o", ms=4, color=_STOCK)
        ax.set_ylim(max(float(level[seen].min()) - 12, -_DEPTH), 3)
        name = f"level at `{port}` [dB, the loudest = 0]"
    ax.set_xlim(f.min() / 1.15, f.max() * 1.15)
    _hertz(ax)
    still = int((~swings).sum())
    if still:
        ax.set_title(f"{still} that {'does' if still == 1 else 'do'} not swing left out", loc="right", fontsize=8)
    return _named(ax, "frequency as heard [Hz]", name)


def accuracy(accuracy: Accuracy, ax: Axes | None = None) -> Axes:
    """Error against the time of one sample [ns]: a line for each method, through the multiples of the sound rate.

    Full dots are beaten by nothing in both, and have names as far as there is room. Errors less than the reference is
    known by stand where it is known; what blows up is named in the legend.

    >>> import cordis_anima as ca
    >>> from cordis_anima import plot
    >>> a = ca.examples.string().accuracy(0.02, times=[1], reference=4)
    >>> ax = plot.accuracy(a)
    >>> ax.get_xlabel(), ax.get_ylabel()
    ('time of one sample [ns]', 'error, relative')
    """
    ax = _axes(ax, 4.6)
    error = np.maximum(accuracy.error, accuracy.known)
    finite = np.isfinite(error)
    colours = {method: f"C{k}" for k, method in enumerate(dict.fromkeys(accuracy.method))}
    for method, colour in colours.items():
        of = np.array([m == method for m in accuracy.method])
        at = np.flatnonzero(of & finite)
        lost = ", ".join(f"×{t}" for t in accuracy.times[of & ~finite])
        name = f"{method} ({lost} blows up)" if lost else method
        ax.plot(accuracy.ns[at], error[at], "-o", lw=0.8, ms=6, color=colour, mfc="white", label=name)
    best = np.flatnonzero(accuracy.front & finite)
    for i in best:
        ax.plot(accuracy.ns[i], error[i], "o", ms=6, color=colours[accuracy.method[i]])
    ax.set_xscale("log")
    ax.set_yscale("log")
    ax.margins(0.1)
    _counted(ax.xaxis)
    _names(ax, [(accuracy.ns[i], error[i], f"{accuracy.method[i]} ×{accuracy.times[i]}") for i in best])
    ax.set_title(f"against {accuracy.against}", loc="left", fontsize=8)
    key = ax.legend(loc="upper left", bbox_to_anchor=(1.01, 1), fontsize=8, frameon=False, alignment="left")
    key.set_title("full: nothing is both\nmore exact and quicker")
    key.get_title().set_fontsize(8)
    return _named(ax, "time of one sample [ns]", "error, relative")


def probes(render: Render, selector: str | Sequence[str] | None = None, ax: Axes | None = None) -> Axes:
    """What was listened to besides, over time [s]: displacements [m], and forces [N] by an axis of their own.

    Args:
        selector: one or several of those the render was asked for; all if none.

    Raises:
        UsageError: the render has no such probe.

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
        raise UsageError("the render has no probes: `render(…, probes=[…])`")
    ax = _axes(ax, 3.4)
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
            # of many, the first and the last say what the colours mean
            if not many or k in (0, len(columns) - 1):
                drawn.append(line)
    for unit, side in sides.items():
        _named(side, "time [s]", "displacement" if unit == "m" else "force", grid=side is ax)
        side.yaxis.set_major_formatter(EngFormatter(unit=unit))
    if len(sides) > 1:
        sides[units[1]].spines["right"].set_visible(True)
    ax.set_xlim(0, render.seconds)
    # above, where it hides nothing
    ax.legend(handles=drawn, loc="lower left", bbox_to_anchor=(0, 1), ncols=6, fontsize=8, frameon=False)
    return ax


def sweep(sweep: Sweep, x: str, y: str, *, color: str | None = None, ax: Axes | None = None) -> Axes:
    """One column of a sweep over another, a dot for each run; texts are categories.

    Runs that clip are triangles. All others that are not ok are crosses; they stand at the upper or right edge where the
    column is measured of a sound, since theirs was not played to its end. Runs that have no place at all are counted
    above. Axes are linear: where values were drawn by ratios, ``ax.set_xscale("log")`` shows them so.

    Args:
        x: name of a column.
        y: name of another.
        color: name of a column that colours dots and triangles: a bar for numbers, a legend for texts.

    Raises:
        UsageError: the sweep has no such column.

    >>> import cordis_anima as ca
    >>> from cordis_anima import plot
    >>> s = ca.sweep(ca.examples.string(), {"low.m": ["1 g", "2 g", "4 g"]}, seconds=0.1)
    >>> ax = plot.sweep(s, "low.m", "partial")
    >>> ax.get_xlabel(), ax.get_ylabel(), len(ax.collections[0].get_offsets())
    ('low.m', 'partial [Hz]', 3)
    """
    for name in [x, y] if color is None else [x, y, color]:
        if name not in sweep:
            raise UsageError(f"no column `{name}`; the sweep has {', '.join(sweep)}")
    ax = _axes(ax, 4.0)
    (across, texts_x), (up, texts_y) = _numbers(sweep, x), _numbers(sweep, y)
    status = sweep["status"].astype(str)
    played = (status == "ok") | (status == "clipped")
    has_x, has_y = (np.isfinite(v) & (played | (name not in _HEARD)) for v, name in ((across, x), (up, y)))
    _dots(sweep, color, played & has_x & has_y, across, up, ax)
    for k, bad in enumerate(np.unique(status[~played])):
        for which, px, py, where in [
            (has_x & has_y, across, up, ax.transData),
            (has_x & ~has_y, across, np.full(len(up), 0.97), _above(ax)),
            (~has_x & has_y, np.full(len(up), 0.985), up, ax.get_yaxis_transform()),
        ]:
            at = which & (status == bad)
            if at.any():
                colour = _LOSS if bad == "unstable" else f"C{k + 4}"
                ax.plot(px[at], py[at], "x", ms=6, color=colour, label=str(bad), transform=where)
    for axis, texts in ((ax.xaxis, texts_x), (ax.yaxis, texts_y)):
        if texts:
            axis.set_major_locator(FixedLocator(list(range(len(texts)))))
            axis.set_major_formatter(FixedFormatter(texts))
    lost = int(np.where(played, ~(has_x & has_y), ~(has_x | has_y)).sum())
    if lost:
        ax.set_title(f"{lost} without a place left out", loc="right", fontsize=8)
    # one entry for a label, wherever its marks are
    marks = {str(mark.get_label()): mark for mark in [*ax.collections, *ax.lines]}
    if list(marks) != ["ok"]:
        # above, where it hides nothing
        key = ax.legend(list(marks.values()), list(marks), loc="lower left", bbox_to_anchor=(0, 1), ncols=4, fontsize=8)
        key.set_frame_on(False)
    return _named(ax, _counted_in(x), _counted_in(y))


def _dots(sweep: Sweep, color: str | None, which: npt.NDArray[np.bool_], across: Floats, up: Floats, ax: Axes) -> None:
    """Runs that were played to their end, coloured by a column if there is one."""
    shade, texts = (np.zeros(len(up)), [""]) if color is None else _numbers(sweep, color)
    known = shade[which & np.isfinite(shade)]
    ends = (float(known.min()), float(known.max())) if known.size else (0.0, 1.0)
    viridis = plt.get_cmap("viridis").with_extremes(bad=_DUST)
    drawn = None
    for status, marker in [("ok", "o"), ("clipped", "^")]:
        for k, text in enumerate(texts or [""]):
            at = which & (sweep["status"] == status) & (shade == k if texts else True)
            if not at.any():
                continue
            if texts:
                colour = _STOCK if color is None else f"C{k}"
                label = status if color is None else f"{color} = {text}" + (", clipped" if status == "clipped" else "")
                ax.scatter(across[at], up[at], 16, color=colour, marker=marker, label=label)
            else:
                of = {"c": shade[at], "cmap": viridis, "vmin": ends[0], "vmax": ends[1], "plotnonfinite": True}
                drawn = ax.scatter(across[at], up[at], 16, marker=marker, label=status, **of)
    if drawn is not None and color is not None:
        ax.figure.colorbar(drawn, ax=ax, pad=0.01).set_label(_counted_in(color))


def take(
    take: Take,
    device: str | None = None,
    dof: int | Sequence[int] | None = None,
    *,
    axes: tuple[Axes, Axes] | None = None,
) -> tuple[Axes, Axes]:
    """Where a hand was [mm] and the force it got [N], over time [s], above each other.

    Colours behind them say how the force was meant: off, ramp, on, damp or fault; a line stands where forces ended, with
    the cause. Positions are taken for metres, as a device that is calibrated says them.

    Args:
        device: its name; the first of the take if none.
        dof: one or several of its degrees of freedom; those that move if none.
        axes: for the positions and for the forces.

    Raises:
        UsageError: the take has no such device or degree of freedom, or no frame of it.

    >>> import cordis_anima as ca, tempfile, os
    >>> from cordis_anima import plot
    >>> t = ca.record(ca.load("hammered_string"), os.path.join(tempfile.mkdtemp(), "blow.mcap"), 0.5)
    >>> position, force = plot.take(t)
    >>> position.get_ylabel(), force.get_ylabel(), [line.get_label() for line in force.lines]
    ('position [mm]', 'force [N]', ['tgr12 0'])
    """
    hands = take.hands
    name = next(iter(hands), "") if device is None else device
    if name not in hands:
        what = f"no device `{device}`; the take has" if device is not None else "nothing to show: the take has"
        raise UsageError(f"{what} {', '.join(hands) or 'no device'}")
    hand = hands[name]
    if not len(hand.time) or not len(hand.force_time):
        raise UsageError(f"no frames of `{name}` in the take")
    if dof is None:
        way = np.ptp(hand.position, axis=0)
        # all that move; the first where all stand still
        asked = np.flatnonzero((way > 0) & (way >= _STILL * way.max())).tolist() or [0]
    else:
        asked = [dof] if isinstance(dof, int) else list(dof)
    for k in asked:
        if not 0 <= k < hand.dof:
            raise UsageError(f"no degree of freedom {k}; `{name}` has 0 to {hand.dof - 1}")
    if axes is None:
        made = plt.subplots(2, figsize=(8, 4.6), layout="constrained", sharex=True)[1]
        axes = (made[0], made[1])
    above, below = axes
    for n, k in enumerate(asked):
        colour, label = f"C{n}", f"{name} {k}"
        above.plot(hand.time, 1e3 * hand.position[:, k], lw=0.9, color=colour, label=label)
        # a device holds a force until the next one comes
        below.plot(hand.force_time, hand.force[:, k], lw=0.9, color=colour, label=label, drawstyle="steps-post")
    # each lasts until the next begins
    begin = np.flatnonzero(np.concatenate([[True], hand.mode[1:] != hand.mode[:-1]]))
    ends = np.append(hand.force_time[begin[1:]], max(hand.force_time[-1], hand.time[-1]))
    for a, b in zip(begin, ends):
        mode = str(hand.mode[a])
        for ax in axes:
            ax.axvspan(hand.force_time[a], b, color=_MODES[mode], alpha=0.35, lw=0, label=mode, zorder=0)
    for fault in take.faults:
        if fault.device == name:
            for ax in axes:
                ax.axvline(fault.time, color=_LOSS, lw=1)
            # where no force is any more
            at, beside = (fault.time, 0.25), (3, 0)
            below.annotate(fault.cause, at, beside, xycoords=_above(below), textcoords="offset points", fontsize=8, color=_LOSS)
    start = min(hand.force_time[0], hand.time[0])
    for ax in axes:
        ax.set_xlim(start, max(ends[-1], start + 1e-3))
    handles: dict[object, Artist] = {}
    for artist in [*above.lines[: len(asked)], *above.patches]:
        handles.setdefault(artist.get_label(), artist)
    above.legend(handles=list(handles.values()), loc="lower left", bbox_to_anchor=(0, 1), ncols=8, fontsize=8, frameon=False)
    _named(above, "", "position [mm]")
    _named(below, "time [s]", "force [N]")
    return axes


def _axes(ax: Axes | None, height: float) -> Axes:
    """Those that were given, or new ones [inches]."""
    if ax is not None:
        return ax
    made: Axes = plt.subplots(figsize=(8, height), layout="constrained")[1]
    return made


def _named(ax: Axes, x: str, y: str, grid: bool = True) -> Axes:
    """With names of the axes, and no more ink than that needs."""
    ax.set_xlabel(x)
    ax.set_ylabel(y)
    ax.spines[["top", "right"]].set_visible(False)
    ax.set_axisbelow(True)
    if grid:
        ax.grid(True, alpha=0.25, lw=0.6)
    return ax


def _above(ax: Axes) -> Transform:
    """Data along x, from 0 at the bottom to 1 at the top along y."""
    return ax.get_xaxis_transform()


def _hertz(ax: Axes, which: Literal["x", "y"] = "x") -> None:
    """Frequencies as people write them: 20, 50, 100, 1k."""
    axis = ax.xaxis if which == "x" else ax.yaxis
    axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axis.set_major_formatter(FuncFormatter(lambda f, _: f"{f:g}" if f < 1000 else f"{f / 1000:g}k"))
    axis.set_minor_formatter(NullFormatter())


def _counted(axis: Axis) -> None:
    """A logarithmic axis with plain numbers: 0.5, 1, 2, 5."""
    axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
    axis.set_minor_formatter(NullFormatter())


def _numbers(sweep: Sweep, name: str) -> tuple[Floats, list[str]]:
    """A column as numbers; for texts, which of the names that follow it is."""
    column = sweep[name]
    if column.dtype.kind in "iuf":
        return column.astype(np.float64), []
    # what has no text is empty in some stores
    texts, at = np.unique(np.array([str(t or "none") for t in column.tolist()]), return_inverse=True)
    return at.astype(np.float64), [str(t) for t in texts]


def _counted_in(name: str) -> str:
    """The name of a column, with its unit where that is known."""
    return f"{name} [{_UNITS[name]}]" if name in _UNITS else name


def _names(ax: Axes, points: list[tuple[float, float, str]]) -> None:
    """Names beside points, above or below, right or left, where they meet no other and no axis; else none."""
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
    """With a unit people know, or a power of ten."""
    for factor, unit in [(1.0, "J"), (1e-3, "mJ"), (1e-6, "µJ"), (1e-9, "nJ")]:
        if factor <= abs(energy) < 1000 * factor:
            return f"{energy / factor:.3g} {unit}".replace("-", "−")
    return f"{energy:.2g} J".replace("-", "−") if energy else "0 J"


def _below(top: float) -> float:
    """The greatest of 1, 2 and 5 times a power of ten that is not above."""
    power = 10.0 ** np.floor(np.log10(top))
    return float(max(d * power for d in (1, 2, 5) if d * power <= top * (1 + 1e-9)))


def _heard(render: Render) -> None:
    if render.audio.size == 0:
        raise UsageError("the render has no sound: a model is heard where it has a SOX or SOF, for longer than no time")


def _time(render: Render) -> Floats:
    """When each sample is [s]."""
    n = len(render.audio)
    return np.arange(n, dtype=np.float64) / (n / render.seconds)


def _starts(n: int, window: int, hop: int) -> Ints:
    """Where windows begin that are at most so far apart, from the first sample to the last."""
    return np.linspace(0, n - window, 1 + -(-(n - window) // hop)).astype(np.int64)


def _power(x: Sound, starts: Ints, window: int, size: int) -> Floats:
    """Power (windows, bins) by windows of Hann; a sine of amplitude A has A² at its bin."""
    hann: Floats = 0.5 - 0.5 * np.cos(2 * np.pi * (np.arange(window) + 0.5) / window)
    scale = 2 / hann.sum()
    power = np.empty((len(starts), size // 2 + 1))
    for row, start in zip(power, starts):
        row[:] = (scale * np.abs(np.fft.rfft(hann * x[start : start + window], size))) ** 2
    return power


def _decibel(power: Floats) -> Floats:
    """Level of a power [dB]."""
    level: Floats = 10 * np.log10(np.maximum(power, 10 ** (_NOTHING / 10)))
    return level


def _levels(x: Sound, rate: float) -> tuple[Floats, Floats]:
    """Frequencies [Hz] and levels [dBFS] of a sound."""
    window = min(len(x), _WINDOW)
    size = 1 << (2 * window - 1).bit_length()
    power = _power(x, _starts(len(x), window, window // 2 + 1), window, size).mean(axis=0)
    return np.arange(len(power), dtype=np.float64) * (rate / size), _decibel(power)


def _outline(f: Floats, level: Floats, lowest: float, highest: float) -> tuple[Floats, Floats]:
    """The loudest bin of each column a picture has room for, at its own frequency."""
    edges = np.searchsorted(f, np.geomspace(lowest, highest, 1501))
    bins = [a + int(np.argmax(level[a:b])) for a, b in zip(edges[:-1], edges[1:]) if b > a]
    return f[bins], level[bins]
