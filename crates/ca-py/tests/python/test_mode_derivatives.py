"""Derivatives of modes, against closed forms and differences."""

from __future__ import annotations

import numpy as np
import pytest

import cordis_anima as ca

THREE = """
[MAS]
a = { m = "1 g" }
b = { m = "2 g" }
c = { m = "1.5 g" }
[SOL]
o = {}
[REF]
r = { between = ["a", "b"], k = "1 kN/m", z = "0.1 N s/m" }
q = { between = ["b", "c"], k = "2 kN/m", z = "0.02 N s/m" }
p = { between = ["o", "a"], k = "3 kN/m", z = 0 }
[SOX]
out = { from = "a" }
"""


def test_one_mass_has_the_derivatives_of_the_roots_of_its_tick() -> None:
    m, k, z, T = 2e-3, 15e3, 0.05, 1 / 48000
    one = f"[MAS]\na = {{ m = {m} }}\n[SOL]\no = {{}}\n[REF]\nr = {{ between = ['o', 'a'], k = {k}, z = {z} }}\n[SOX]\nx = {{ from = 'a' }}\n"
    d = ca.parse(one).modes().derivative(["r.k", "r.z"])
    # w² − (2 − a − b) w + (1 − b) = 0, where a = k T² / m and b = z T / m (docs/numerics.md §1.2)
    a, b = k * T**2 / m, z * T / m
    w = np.roots([1, -(2 - a - b), 1 - b])[0]
    w = w if w.imag > 0 else w.conj()
    slope = 2 * w - (2 - a - b)
    of_k, of_z = -w / slope * T**2 / m, -(w - 1) / slope * T / m
    fall = 3 * np.log(10) * T / np.log(abs(w)) ** 2
    for i, of in enumerate((of_k, of_z)):
        assert d.heard[0, i] == pytest.approx((of / w).imag / (2 * np.pi * T), rel=1e-9)
        assert d.t60[0, i] == pytest.approx(fall * (of / w).real, rel=1e-8)


@pytest.mark.parametrize("name", ["r.k", "q.k", "a.m", "r.z", "q.z"])
def test_coupled_damping_has_the_derivatives_of_differences(name: str) -> None:
    scene = ca.parse(THREE)
    d = scene.modes().derivative(name)
    value, unit = float(d.values[0]), d.units[0]
    h = 3e-3 * value
    at = {i: scene.replace({name: f"{value + i * h!r} {unit}"}).modes() for i in (-3, -2, -1, 1, 2, 3)}
    for which in ("heard", "t60"):
        up = sum(weight * (getattr(at[i], which) - getattr(at[-i], which)) for i, weight in ((1, 3 / 4), (2, -3 / 20), (3, 1 / 60)))
        found, difference = getattr(d, which)[:, 0], np.asarray(up) / h
        assert np.abs(found - difference).max() < 1e-6 * np.abs(difference).max(), (which, found, difference)


def test_what_is_written_as_a_pitch_moves_it() -> None:
    d = ca.examples.string().modes().derivative(["low.f", "low.t60", "hammer.m"])
    # the first mode is the free hammer, which touches nothing at rest
    assert np.isnan(d.heard[0]).all() and not d.heard[1:, 2].any()
    assert d.heard[1, 0] == pytest.approx(1, abs=1e-3) and d.t60[1, 1] == pytest.approx(1, abs=1e-6)
    assert d.units == ("Hz", "s", "kg") and "41 modes" in repr(d)


def test_two_poles_that_are_one_have_none() -> None:
    twins = "[CEL]\na = { m = '1 g', f = '440 Hz' }\nb = { m = '2 g', f = '440 Hz' }\n[SOX]\nx = { from = 'a' }\ny = { from = 'b' }\n"
    assert np.isnan(ca.parse(twins).modes().derivative(["a.f"]).heard).all()
    apart = ca.parse(twins.replace("'2 g', f = '440 Hz'", "'2 g', f = '441 Hz'")).modes().derivative(["a.f"])
    assert apart.heard[:, 0] == pytest.approx([1, 0], abs=1e-9)


@pytest.mark.parametrize(
    ("wrt", "says"), [([], "`wrt` is empty"), (["low.n"], "whole number"), (["low.ff"], "did you mean|no such"), (["nobody.f"], "no `nobody.f`")]
)
def test_what_has_no_derivative_is_refused(wrt: list[str], says: str) -> None:
    with pytest.raises(ca.UsageError, match=says):
        ca.examples.string().modes().derivative(wrt)
