"""Shared by tests of plots."""

from __future__ import annotations

from collections.abc import Iterator

import matplotlib.pyplot as plt
import pytest
from matplotlib.axes import Axes


@pytest.fixture(autouse=True)
def closed() -> Iterator[None]:
    """Closes all figures after a test."""
    yield
    plt.close("all")


def drawn(ax: Axes) -> None:
    """Draws the axes, which must both have labels."""
    ax.figure.canvas.draw()
