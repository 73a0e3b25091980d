"""Many instances of one scene side by side in one scene, so that the engine's vectors run across them.

The modules of all instances take turns: what stands at place i of instance k of n stands at place n i + k. Then links of
one instance that stand anywhere are, with those of the others, a row with the stride n, which the engine computes by
vectors; and a tick is begun once for all. This is the best a batch path could do with the kernels there are.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np

import cordis_anima as ca

Row = tuple[str, str, dict[str, Any]]


def string(n: int = 24) -> list[Row]:
    """A string between two walls: one row, along which vectors run already."""
    rows: list[Row] = [("SOL", "l", {}), ("SOL", "r", {})]
    rows += [("MAS", f"p{i}", {"m": 1e-3, "v": 1.0 if i == 5 else 0.0}) for i in range(n)]
    ends = ["l", *(f"p{i}" for i in range(n)), "r"]
    rows += [("REF", f"s{i}", {"between": ends[i : i + 2], "k": 1e3, "z": 1e-3}) for i in range(n + 1)]
    return [*rows, ("SOX", "out", {"from": "p3"})]


def struck() -> list[Row]:
    """The same with a hammer: one contact."""
    rows = [(k, n, {**v, "v": 0.0} if "v" in v else v) for k, n, v in string()]
    hammer: list[Row] = [
        ("MAS", "hammer", {"m": 0.02, "x": -1e-3, "v": 1.0}),
        ("BUT", "strike", {"between": ["hammer", "p8"], "k": 8e3, "z": 0.2}),
    ]
    return [*rows[:-1], *hammer, rows[-1]]


def tangle(n: int = 60) -> list[Row]:
    """Masses joined at random: no two links in a row, so that no vector runs in one instance."""
    draw = np.random.default_rng(1)
    rows: list[Row] = [("CEL", f"p{i}", {"m": 1e-3, "f": 100.0 + 10 * i, "v": float(i == 5)}) for i in range(n)]
    for i in range(2 * n):
        a, b = draw.choice(n, 2, replace=False)
        rows.append(("REF", f"s{i}", {"between": [f"p{a}", f"p{b}"], "k": 500.0, "z": 1e-3}))
    return [*rows, ("SOX", "out", {"from": "p3"})]


def together(rows: list[Row], n: int, only: int | None = None) -> ca.Scene:
    """`n` instances with stiffnesses of their own in one scene, or one of them by itself."""
    m = ca.Model()
    lanes = range(n) if only is None else [only]
    for kind, name, values in rows:
        for k in lanes:
            own = dict(values)
            if "between" in own:
                own["between"] = [f"{end}_{k}" for end in own["between"]]
            if "from" in own:
                own["from_"] = f"{own.pop('from')}_{k}"
            if "k" in own:
                own["k"] *= 1 + 0.01 * k
            m.add(kind, f"{name}_{k}", **own)
    return m.compile()


def table(in_turn: Callable[..., list[float]], seconds: float = 4.0) -> list[tuple[str, float, float, float, int]]:
    """Of each network: how many times more is played than by one scene after the other on one thread; by lanes, by two
    threads, by both; and the number of lanes that did best.
    """
    found = []
    sizes = [4, 8, 16, 32]
    with ThreadPoolExecutor(2) as pool:

        def both(scene: ca.Scene) -> Callable[[], object]:
            return lambda: list(pool.map(lambda _: scene.render(seconds), range(2)))

        for name, rows in [("string of 24", string()), ("struck string", struck()), ("60 masses, tangled", tangle())]:
            alone = together(rows, 8, 3).render(0.1).audio[:, 0]
            assert np.array_equal(together(rows, 8).render(0.1).audio[:, 3], alone), "the same bits"
            one = together(rows, 1)
            merged = [together(rows, n) for n in sizes]
            works: list[Callable[[], object]] = [lambda: one.render(seconds), both(one)]
            works += [lambda s=s, n=n: s.render(seconds / n) for s, n in zip(merged, sizes)]
            works += [both(s) for s in merged]
            # an instance and second of each costs
            per = [1.0, 2.0, *(1.0 for _ in sizes), *(2.0 * n for n in sizes)]
            each = [t / p for t, p in zip(in_turn(works, 15), per)]
            lanes, threads = [each[0] / t for t in each[2 : 2 + len(sizes)]], [each[0] / t for t in each[2 + len(sizes) :]]
            best = int(np.argmax(lanes))
            found.append((name, lanes[best], each[0] / each[1], max(threads), sizes[best]))
    return found
