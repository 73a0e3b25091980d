"""A batch against its alternative: a thread pool that sets the values and renders each instance."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np

import cordis_anima as ca

CELL = "[CEL]\na = { m = '1 g', f = '440 Hz', t60 = '1 s', v = '1 cm/s' }\n[SOX]\nout = { from = 'a', gain = 100 }\n"


def table(in_turn: Callable[..., list[float]], threads: int = 2) -> list[tuple[str, float, int, float, float]]:
    """Returns for each scene: name, length [s], number of instances, ms per instance, and speed-up over the pool."""
    found = []
    scenes = [
        ("one cell", ca.parse(CELL), "a.f", 440.0),
        ("struck string of 41 masses", ca.examples.string(), "low.f", 110.0),
        ("hammered_string", ca.load("hammered_string"), "hammer.m", 0.02),
        ("glass", ca.load("glass"), "rim.f[0]", 500.0),
        ("membrane, 3691 modules", ca.load("membrane"), "skin.f", 90.0),
    ]
    with ThreadPoolExecutor(threads) as pool:
        for name, scene, parameter, value in scenes:
            for seconds, n in [(0.05, 256), (0.2, 128), (1.0, 64)][: 1 if name.startswith("membrane") else 3]:
                values = [value * (1 + 0.0005 * i) for i in range(n)]

                def apart() -> list[np.ndarray]:
                    one = lambda v: scene.replace({parameter: v}).render(seconds).audio  # noqa: E731
                    return list(pool.map(one, values))

                def together() -> np.ndarray:
                    return ca.batch(scene, {parameter: values}, seconds, threads=threads).audio

                assert np.array_equal(together(), np.stack(apart())), "the same bits"
                pooled, batch = in_turn([apart, together], 5)
                found.append((name, seconds, n, 1e3 * batch / n, pooled / batch))
    return found
