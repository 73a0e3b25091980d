"""Loops over arrays, compiled by numba, with requests in lines as for the peers in C (`player.h`, `table.h`)."""

from __future__ import annotations

import math
import sys
import time

import numba
import numpy as np

WARM, BLOCK = 1024, 64


@numba.njit(fastmath=True)
def line(x, y, f, now, before, c, at, a, b, p, q, d, outputs, out):
    """Plays a block of ticks of a network on a line."""
    for t in range(out.size):
        for i in range(at[0], at[1]):
            force = p[i] * (x[b[i]] - x[a[i]]) + q[i] * ((x[b[i]] - y[b[i]]) - (x[a[i]] - y[a[i]]))
            f[a[i]] += force
            f[b[i]] -= force
        for i in range(at[1], at[2]):
            g = x[b[i]] - x[a[i]] - d[i]
            if g < 0:
                force = p[i] * g + q[i] * ((x[b[i]] - y[b[i]]) - (x[a[i]] - y[a[i]]))
                f[a[i]] += force
                f[b[i]] -= force
        for i in range(at[2], at[3]):
            g = d[i] - (x[b[i]] - x[a[i]])
            if g > 0:
                force = -p[i] * g * math.sqrt(g)
                f[a[i]] += force
                f[b[i]] -= force
        for i in range(at[3], at[4]):
            u = ((x[b[i]] - y[b[i]]) - (x[a[i]] - y[a[i]])) / q[i]
            force = p[i] * u * math.exp(0.5 - 0.5 * u * u)
            f[a[i]] += force
            f[b[i]] -= force
        heard = 0.0
        for i in outputs:
            heard += x[i]
        out[t] = heard
        for i in range(x.size):
            ahead = now[i] * x[i] + before[i] * y[i] + c[i] * f[i]
            y[i] = x[i]
            x[i] = ahead
            f[i] = 0.0


def main() -> None:
    rows = [row.split() for row in open(sys.argv[1])]
    axes, mats, lias, _ = map(int, rows[0])
    if axes != 1:
        sys.exit("on a line only")
    kind, m, k, z, start, step = np.array(rows[1 : mats + 1], float).T
    links = np.array(rows[mats + 1 : mats + lias + 1], float).reshape(lias, 6)
    links = links[np.argsort(links[:, 0], kind="stable")]
    at = np.searchsorted(links[:, 0], np.arange(5))
    a, b = links[:, 1].astype(np.int64), links[:, 2].astype(np.int64)
    p, q, d = (np.ascontiguousarray(links[:, i]) for i in (3, 4, 5))
    outputs = np.array(rows[mats + lias + 1 :], np.int64).ravel()
    fixed = kind == 2
    c = np.where(fixed, 0, 1 / m)
    now = np.where(fixed, 2, 2 - (k + z) / m)
    before = np.where(fixed, -1, z / m - 1)
    out = np.zeros(BLOCK)
    for asked in sys.stdin:
        word, ticks = asked.split()
        state = [start.copy(), start - step, np.zeros(mats)]
        coefficients = (now, before, c, at, a, b, p, q, d, outputs)

        def blocks(n: int) -> list[float]:
            heard: list[float] = []
            for _ in range(n // BLOCK):
                line(*state, *coefficients, out)
                if word == "hear":
                    heard.extend(out)
            return heard

        if word == "hear":
            print("\n".join(repr(float(v)) for v in blocks(int(ticks))))
        else:
            blocks(WARM)
            begin = time.thread_time_ns()
            blocks(int(ticks))
            print(time.thread_time_ns() - begin)
        sys.stdout.flush()


main()
