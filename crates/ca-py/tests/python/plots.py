"""What tests of plots share."""

from __future__ import annotations

from collections.abc import Iterator

import matplotlib.pyplot as plt
import pytest
from matplotlib.axes import Axes


@pytest.fixture(autouse=True)
def closed() -> Iterator[None]:
    """Figures do not stay."""
    yield
    plt.close("all")


def drawn(ax: Axes) -> None:
    """It can be drawn, with a name at each axis."""
    ax.figure.canvas.draw()
