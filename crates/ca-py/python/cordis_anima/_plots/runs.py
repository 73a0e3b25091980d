"""Plots of what was run: the runs of a sweep, and takes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from .axes import DUST, LOSS, STOCK, Artist, Axes, FixedFormatter, FixedLocator, along_x, given_or_new, named, plt
from .._errors import UsageError
from .._results import Floats
from .._sweeps.sweep import Sweep
from .._take import Take

#: columns of a sweep that say nothing of a run which was not played to its end
_HEARD = ("peak", "rms", "partial", "t60", "residual")
#: what columns of a sweep are counted in; those of parameters are in SI units
_UNITS = {"partial": "Hz", "t60": "s", "failed": "s", "run_time": "s", "peak": "full scale = 1", "rms": "full scale = 1"}
#: colours of how a force is meant
_MODES = {"off": "#b8b8b8", "ramp": "#f2d16b", "on": "#a9d8b8", "damp": "#f0a35e", "fault": "#e08080"}
#: the share of the longest way of all degrees of freedom below which one does not move: a sensor makes noise
_STILL = 0.01


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
        ax.set_title(f"{lost} without a place left out", loc="right", fontsize=8)
    # one entry for a label, wherever its marks are
    marks = {str(mark.get_label()): mark for mark in [*ax.collections, *ax.lines]}
    if list(marks) != ["ok"]:
        # above, where it hides nothing
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
                ax.axvline(fault.time, color=LOSS, lw=1)
            # where no force is any more
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
    """Runs that were played to their end, coloured by a column if there is one."""
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
