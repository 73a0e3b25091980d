"""Which columns a selector chose, and what they heard."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ._results import Floats


def columns(of: Sequence[int], asked: Sequence[str]) -> dict[str, list[int]]:
    """The columns of each selector; `of` has for each column the place of its selector in `asked`."""
    return {selector: [c for c, k in enumerate(of) if k == i] for i, selector in enumerate(asked)}


def chosen(rows: Floats, places: Mapping[str, Sequence[int]]) -> dict[str, Floats]:
    """What each selector heard: (n,), or (n, columns) where it chose several."""
    return {s: rows[:, c[0]] if len(c) == 1 else rows[:, list(c)] for s, c in places.items()}
