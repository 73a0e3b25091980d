"""What all plots share: axes with names and units, colours, and matplotlib itself.

Decides that whoever plots without matplotlib is told so here: the other files of plots have of it what this one has.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from .._errors import MissingError
from .._results import Floats

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

__all__ = [
    "DEPTH",
    "DUST",
    "GAIN",
    "LOSS",
    "NOTHING",
    "STOCK",
    "Affine2D",
    "Artist",
    "Axes",
    "EngFormatter",
    "FixedFormatter",
    "FixedLocator",
    "Line2D",
    "along_x",
    "counted",
    "decibel",
    "given_or_new",
    "hertz",
    "named",
    "plt",
]

#: how far below the loudest levels over frequency are shown [dB]
DEPTH = 120.0
#: level of what is silent [dB]
NOTHING = -300.0
#: colours of what is gained, given away, there, and of no weight
GAIN, LOSS, STOCK, DUST = "#2a9d6f", "#d1603d", "#3b6ea5", "#777777"


def given_or_new(ax: Axes | None, height: float) -> Axes:
    """Those that were given, or new ones [inches]."""
    if ax is not None:
        return ax
    made: Axes = plt.subplots(figsize=(8, height), layout="constrained")[1]
    return made


def named(ax: Axes, x: str, y: str, grid: bool = True) -> Axes:
    """With names of the axes, and no more ink than that needs."""
    ax.set_xlabel(x)
    ax.set_ylabel(y)
    ax.spines[["top", "right"]].set_visible(False)
    ax.set_axisbelow(True)
    if grid:
        ax.grid(True, alpha=0.25, lw=0.6)
    return ax


def along_x(ax: Axes) -> Transform:
    """Data along x, from 0 at the bottom to 1 at the top along y."""
    return ax.get_xaxis_transform()


def hertz(ax: Axes, which: Literal["x", "y"] = "x") -> None:
    """Frequencies as people write them: 20, 50, 100, 1k."""
    axis = ax.xaxis if which == "x" else ax.yaxis
    axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axis.set_major_formatter(FuncFormatter(lambda f, _: f"{f:g}" if f < 1000 else f"{f / 1000:g}k"))
    axis.set_minor_formatter(NullFormatter())


def counted(axis: Axis) -> None:
    """A logarithmic axis with plain numbers: 0.5, 1, 2, 5."""
    axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
    axis.set_minor_formatter(NullFormatter())


def decibel(power: Floats) -> Floats:
    """Level of a power [dB]."""
    level: Floats = 10 * np.log10(np.maximum(power, 10 ** (NOTHING / 10)))
    return level
