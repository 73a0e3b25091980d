"""Modes, certificates and accuracy as arrays, against closed forms."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import cordis_anima as ca


def chain(n: int = 20) -> ca.Scene:
    return (
        ca.Model("A chain")
        .add("STRING", "s", n=n, m="1 g", k="100 N/m", z=0)
        .add("SOX", "out", from_="s[3]")
        .compile()
    )


def test_modes_are_pickled_with_their_derivatives() -> None:
    modes = ca.examples.string().modes()
    there = pickle.loads(pickle.dumps(modes))
    assert np.array_equal(there.heard, modes.heard)
    assert np.array_equal(there.derivative(["low.f"]).heard, modes.derivative(["low.f"]).heard, equal_nan=True)


def test_modes_of_a_string_are_its_closed_form() -> None:
    scene = chain()
    m = scene.modes()
    per_mass = 1e-3
    j = np.arange(1, 21)
    free = 2 * np.sqrt(100 / per_mass) * np.sin(j * np.pi / 42) / (2 * np.pi)
    heard = np.arcsin(np.pi * free / scene.sr) * scene.sr / np.pi
    assert len(m) == 20 and not m.approximate and not m.grows.any() and np.isinf(m.t60).all()
    assert np.abs(m.f / free - 1).max() < 1e-9
    assert np.abs(m.heard / heard - 1).max() < 1e-9
    assert np.allclose(m.cents, 1200 * np.log2(heard / free), atol=1e-6)
    # unit modal masses
    assert np.allclose(per_mass * (m.shapes**2).sum(axis=1), 1)
    assert m.ports == ("out",) and np.allclose(np.abs(m.levels[:, 0]), np.abs(m.shapes[:, 3]))


def test_certificates_are_records() -> None:
    c = chain().certificate
    assert c.level == "proven" and c.margin == pytest.approx(4 / c.bound) and c.largest is None
    exact = ca.Model.of(chain()).compile(exact=True).certificate
    assert exact.largest is not None
    low, high = exact.largest
    assert low <= high < 4 and high / low < 1 + 1e-6
    # a power-law contact: p q depth^(p - 1) T²/m = 1
    ball = ca.Model("A ball").add("SOL", "wall").add("MAS", "ball", m="1 g").add("SOX", "out", from_="ball")
    ball.add("HRZ", "hit", between=["wall", "ball"], k=3e6, p=1.5)
    depth = ball.compile().certificate.depth
    assert c.depth is None and depth is not None
    assert depth[0] == "hit" and depth[1] == pytest.approx((1e-3 * 48000**2 / (1.5 * 3e6)) ** 2)


def test_error_against_run_time() -> None:
    a = ca.parse(
        "[CEL]\nb = { m = '1 g', f = '1 kHz', t60 = '1 s', dx0 = '1 mm' }\n[SOX]\no = { from = 'b' }\n"
    ).accuracy(0.05, times=[1, 2])
    assert "modes" in a.against and a.rate == 48000
    one = a.error[a.times == 1]
    assert one.min() < 1e-9 < one.max()
    best = a.cheapest(1e-3)
    assert best is not None
    k = [k for k in range(len(a)) if (a.method[k], a.times[k]) == best][0]
    assert a.error[k] <= 1e-3 and (a.ns > 0).all() and a.front.any()
    # an error below the error of the reference cannot be confirmed
    assert a.known < 1e-9 and a.cheapest(a.known / 2) is None and a.cheapest(1e-9) is not None
    assert a != ca.examples.string().modes() and len({a, a}) == 1
