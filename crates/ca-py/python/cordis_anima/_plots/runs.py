"""Plots of runs of a sweep, and of takes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from .axes import DUST, LOSS, STOCK, Artist, Axes, FixedFormatter, FixedLocator, along_x, given_or_new, named, plt
from .._errors import UsageError
from .._results import Floats
from .._sweeps.sweep import Sweep
from .._take import Take

#: columns of a sweep that are meaningless for a run that was not played to its end
_HEARD = ("peak", "rms", "partial", "t60", "residual")
#: units of sweep columns; parameters are in SI units
_UNITS = {"partial": "Hz", "t60": "s", "failed": "s", "run_time": "s", "peak": "full scale = 1", "rms": "full scale = 1"}
#: colours of the modes of a force
_MODES = {"off": "#b8b8b8", "ramp": "#f2d16b", "on": "#a9d8b8", "damp": "#f0a35e", "fault": "#e08080"}
#: travel, relative to the longest over all degrees of freedom, below which motion counts as sensor noise
_STILL = 0.01


def sweep(sweep: Sweep, x: str, y: str, *, color: str | None = None, ax: Axes | None = None) -> Axes:
    """Plots one column of a sweep over another, with a dot for each run; texts are categories.

    Clipped runs are triangles. Other runs that are not ok are crosses, at the upper or right edge if the column is
    measured from the sound, because theirs was not played to its end. The number of runs that cannot be placed is shown
    above. Axes are linear; for values drawn by ratios use ``ax.set_xscale("log")``.

    Args:
        x: name of a column.
        y: name of another.
        color: name of a column for the colour of dots and triangles, with a colour bar for numbers or a legend for
            texts.

    Raises:
        UsageError: if the sweep lacks a column.

    >>> import cordis_anima as ca
    >>> from cordis_anima import plot
    >>> s = ca.sweep(ca.examples.string(), {"low.m": ["1 g", "2 g", "4 g"]}, seconds=0.1, measure=True)
    >>> ax = plot.sweep(s, "low.m", "partial")
    >>> ax.get_xlabel(), ax.get_ylabel(), len(ax.collections[0].get_offsets())
    ('low.m', 'partial [Hz]', 3)
    >>> ax.set_xscale("log")
    """
    for name in [x, y] if color is None else [x, y, color]:
        if name not in sweep:
            raise UsageError(f"{sweep._missing(name)}; the sweep has {', '.join(sweep)}")
    ax = given_or_new(ax, 4.0)
    (across, texts_x), (up, texts_y) = _numbers(sweep, x), _numbers(sweep, y)
    status = sweep["status"].astype(str)
    played = (status == "ok") | (status == "clipped")
    has_x, has_y = (np.isfinite(v) & (played | (name not in _HEARD)) for v, name in ((across, x), (up, y)))
    _dots(sweep, color, played & has_x & has_y, across, up, ax)
    for k, bad in enumerate(np.unique(status[~played])):
        for which, px, py, where in [
            (has_x & has_y, across, up, ax.transData),
            (has_x & ~has_y, across, np.full(len(up), 0.97), along_x(ax)),
            (~has_x & has_y, np.full(len(up), 0.985), up, ax.get_yaxis_transform()),
        ]:
            at = which & (status == bad)
            if at.any():
                colour = LOSS if bad == "unstable" else f"C{k + 4}"
                ax.plot(px[at], py[at], "x", ms=6, color=colour, label=str(bad), transform=where)
    for axis, texts in ((ax.xaxis, texts_x), (ax.yaxis, texts_y)):
        if texts:
            axis.set_major_locator(FixedLocator(list(range(len(texts)))))
            axis.set_major_formatter(FixedFormatter(texts))
    lost = int(np.where(played, ~(has_x & has_y), ~(has_x | has_y)).sum())
    if lost:
        ax.set_title(f"runs not shown: {lost}", loc="right", fontsize=8)
    # one legend entry per label
    marks = {str(mark.get_label()): mark for mark in [*ax.collections, *ax.lines]}
    if list(marks) != ["ok"]:
        # placed above, where it hides no data
        key = ax.legend(list(marks.values()), list(marks), loc="lower left", bbox_to_anchor=(0, 1), ncols=4, fontsize=8)
        key.set_frame_on(False)
    return named(ax, _counted_in(x), _counted_in(y))


def take(
    take: Take,
    device: str | None = None,
    dof: int | Sequence[int] | None = None,
    *,
    axes: tuple[Axes, Axes] | None = None,
) -> tuple[Axes, Axes]:
    """Plots the position of a hand [mm] above the force on it [N], over time [s].

    The background colour is the mode of the force: off, ramp, on, damp or fault. A line with the cause marks the end of
    forces. Positions are taken as metres, which holds for calibrated devices.

    Args:
        device: name of the device; default: the first of the take.
        dof: one or several degrees of freedom; default: those that move.
        axes: axes for positions and for forces.

    Raises:
        UsageError: if the take lacks the device, the degree of freedom, or any frame of it.

    >>> import cordis_anima as ca, tempfile, os
    >>> from cordis_anima import plot
    >>> folder = tempfile.TemporaryDirectory()
    >>> t = ca.record(ca.load("hammered_string"), os.path.join(folder.name, "blow.mcap"), 0.5)
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
        # the first one if none moves
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
        # a device holds a force until the next arrives
        below.plot(hand.force_time, hand.force[:, k], lw=0.9, color=colour, label=label, drawstyle="steps-post")
    # each mode lasts until the next begins
    begin = np.flatnonzero(np.concatenate([[True], hand.mode[1:] != hand.mode[:-1]]))
    ends = np.append(hand.force_time[begin[1:]], max(hand.force_time[-1], hand.time[-1]))
    for a, b in zip(begin, ends):
        mode = str(hand.mode[a])
        for ax in axes:
            ax.axvspan(hand.force_time[a], b, color=_MODES[mode], alpha=0.35, lw=0, label=mode, zorder=0)
    for fault in take.faults:
        if fault.device == name:
            for ax in axes:
                ax.axvline(fault.time, color=LOSS, lw=1)
            # below the line, since the force has ended
            at, beside = (fault.time, 0.25), (3, 0)
            below.annotate(fault.cause, at, beside, xycoords=along_x(below), textcoords="offset points", fontsize=8, color=LOSS)
    start = min(hand.force_time[0], hand.time[0])
    for ax in axes:
        ax.set_xlim(start, max(ends[-1], start + 1e-3))
    handles: dict[object, Artist] = {}
    for artist in [*above.lines[: len(asked)], *above.patches]:
        handles.setdefault(artist.get_label(), artist)
    above.legend(handles=list(handles.values()), loc="lower left", bbox_to_anchor=(0, 1), ncols=8, fontsize=8, frameon=False)
    named(above, "", "position [mm]")
    named(below, "time [s]", "force [N]")
    return axes


def _dots(sweep: Sweep, color: str | None, which: npt.NDArray[np.bool_], across: Floats, up: Floats, ax: Axes) -> None:
    """Plots the complete runs, coloured by a column if given."""
    shade, texts = (np.zeros(len(up)), [""]) if color is None else _numbers(sweep, color)
    known = shade[which & np.isfinite(shade)]
    ends = (float(known.min()), float(known.max())) if known.size else (0.0, 1.0)
    viridis = plt.get_cmap("viridis").with_extremes(bad=DUST)
    drawn = None
    for status, marker in [("ok", "o"), ("clipped", "^")]:
        for k, text in enumerate(texts or [""]):
            at = which & (sweep["status"] == status) & (shade == k if texts else True)
            if not at.any():
                continue
            if texts:
                colour = STOCK if color is None else f"C{k}"
                label = status if color is None else f"{color} = {text}" + (", clipped" if status == "clipped" else "")
                ax.scatter(across[at], up[at], 16, color=colour, marker=marker, label=label)
            else:
                of = {"c": shade[at], "cmap": viridis, "vmin": ends[0], "vmax": ends[1], "plotnonfinite": True}
                drawn = ax.scatter(across[at], up[at], 16, marker=marker, label=status, **of)
    if drawn is not None and color is not None:
        ax.figure.colorbar(drawn, ax=ax, pad=0.01).set_label(_counted_in(color))


def _numbers(sweep: Sweep, name: str) -> tuple[Floats, list[str]]:
    """A column as numbers; for texts, indices into the returned names."""
    column = sweep[name]
    if column.dtype.kind in "iuf":
        return column.astype(np.float64), []
    # a missing text is empty in some stores
    texts, at = np.unique(np.array([str(t or "none") for t in column.tolist()]), return_inverse=True)
    return at.astype(np.float64), [str(t) for t in texts]


def _counted_in(name: str) -> str:
    """Name of a column, with its unit if known."""
    return f"{name} [{_UNITS[name]}]" if name in _UNITS else name
