"""Common parts of all plots: labelled axes, colours, and matplotlib itself.

The other plot files import matplotlib from here, so that a missing matplotlib is reported in one place.
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

#: range of levels shown below the loudest, over frequency [dB]
DEPTH = 120.0
#: level of silence [dB]
NOTHING = -300.0
#: colours of gains, losses, stored amounts and negligible ones
GAIN, LOSS, STOCK, DUST = "#2a9d6f", "#d1603d", "#3b6ea5", "#777777"


def given_or_new(ax: Axes | None, height: float) -> Axes:
    """Returns the given axes, or new ones of this height [inches]."""
    if ax is not None:
        return ax
    made: Axes = plt.subplots(figsize=(8, height), layout="constrained")[1]
    return made


def named(ax: Axes, x: str, y: str, grid: bool = True) -> Axes:
    """Labels the axes and removes unneeded lines."""
    ax.set_xlabel(x)
    ax.set_ylabel(y)
    ax.spines[["top", "right"]].set_visible(False)
    ax.set_axisbelow(True)
    if grid:
        ax.grid(True, alpha=0.25, lw=0.6)
    return ax


def along_x(ax: Axes) -> Transform:
    """Transform with data along x, and 0 (bottom) to 1 (top) along y."""
    return ax.get_xaxis_transform()


def hertz(ax: Axes, which: Literal["x", "y"] = "x") -> None:
    """Labels frequencies as 20, 50, 100, 1k."""
    axis = ax.xaxis if which == "x" else ax.yaxis
    axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axis.set_major_formatter(FuncFormatter(lambda f, _: f"{f:g}" if f < 1000 else f"{f / 1000:g}k"))
    axis.set_minor_formatter(NullFormatter())


def counted(axis: Axis) -> None:
    """Makes a logarithmic axis with plain numbers: 0.5, 1, 2, 5."""
    axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
    axis.set_minor_formatter(NullFormatter())


def decibel(power: Floats) -> Floats:
    """Level of a power [dB]."""
    level: Floats = 10 * np.log10(np.maximum(power, 10 ** (NOTHING / 10)))
    return level
