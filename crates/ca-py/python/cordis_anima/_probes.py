"""Columns of probes by selector."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ._results import Floats


def columns(of: Sequence[int], asked: Sequence[str]) -> dict[str, list[int]]:
    """Returns the column numbers of each selector. `of` has for each column the index of its selector in `asked`."""
    return {selector: [c for c, k in enumerate(of) if k == i] for i, selector in enumerate(asked)}


def chosen(rows: Floats, places: Mapping[str, Sequence[int]]) -> dict[str, Floats]:
    """Returns the data of each selector: (n,), or (n, columns) if it chose several."""
    return {s: rows[:, c[0]] if len(c) == 1 else rows[:, list(c)] for s, c in places.items()}
