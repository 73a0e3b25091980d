"""Derivatives of energy accounts, against products, differences and the identity of the ledger."""

from __future__ import annotations

import numpy as np
import pytest

import cordis_anima as ca

BAR = """
[CEL]
bar = { m = "2 g", f = "440 Hz", t60 = "0.2 s", dx0 = "1 mm" }
[SOX]
left = { from = "bar", gain = 500 }
"""
STRUCK = BAR + '[MAS]\nbob = { m = "5 g", x = "-1 mm", v = "0.8 m/s" }\n[CUB]\ntie = { between = ["bob", "bar"], k = "2 kN/m", k3 = "1e8 N/m^3" }\n'
ACCOUNTS = ["start", "stored", "lost", "made", "work", "changed", "residual"]


def test_accounts_are_those_of_a_render_and_go_with_the_square_of_the_start() -> None:
    scene = ca.parse(BAR)
    t = scene.energy_tangents(["bar.dx0", "left.gain"], 0.02, instants=3)
    assert (t.wrt, t.units, list(t.energy), list(t.tangents)) == (("bar.dx0", "left.gain"), ("m", ""), ACCOUNTS, ACCOUNTS)
    assert t.seconds == pytest.approx([319 / 48000, 639 / 48000, 959 / 48000])
    kept = scene.render(0.02, energy=True).energy
    assert kept is not None and kept.seconds == pytest.approx(t.seconds[-1])
    for name in ACCOUNTS:
        assert t.energy[name].shape == (3,) and t.tangents[name].shape == (3, 2)
        assert t.energy[name][-1] == getattr(kept, name)
        # energy is quadratic in the displacement and independent of the outputs
        assert t["bar.dx0"][name] * 1e-3 == pytest.approx(2 * t.energy[name], rel=1e-9, abs=1e-9 * kept.peak)
        assert not t["left.gain"][name].any()
    assert repr(t) == "<EnergyTangents: 3 instants by bar.dx0, left.gain>"


def test_derivatives_are_those_of_differences_and_balance() -> None:
    scene, names = ca.parse(STRUCK), ["bob.v", "bob.m", "bar.f", "bar.t60", "tie.k3"]
    t = scene.energy_tangents(names, 0.01, instants=4)
    for k, (name, value) in enumerate(zip(names, t.values)):
        h = 1e-5 * value
        up, down = (scene.replace({name: v}).energy_tangents([name], 0.01, instants=4).energy for v in (value + h, value - h))
        by = {account: t.tangents[account][:, k] for account in ACCOUNTS}
        most = max(np.abs(v).max() for v in by.values())
        for account in ACCOUNTS:
            assert np.abs((up[account] - down[account]) / (2 * h) - by[account]).max() < 1e-6 * most, (name, account)
        balance = by["start"] + by["work"] - by["lost"] + by["made"] + by["changed"]
        assert np.abs(by["stored"] - balance).max() < 1e-9 * most and np.abs(by["residual"]).max() < 1e-9 * most


def test_work_at_a_port_has_derivatives() -> None:
    scene = ca.parse(BAR + '[ENF]\npush = { to = "bar" }\n')
    t = scene.energy_tangents(["bar.m"], 0.01, gesture={"push": [[0, 0], [0.01, 1.0]]})
    assert t.energy["work"][-1] != 0 and t["bar.m"]["work"].shape == (1,) and t["bar.m"]["work"][-1] != 0


def test_what_has_no_derivatives_of_energy_is_refused() -> None:
    scene = ca.parse(BAR)
    with pytest.raises(ca.UsageError, match="no such parameter"):
        scene.energy_tangents(["bar.n"], 0.01)
    with pytest.raises(ca.UsageError, match="`wrt` is empty"):
        scene.energy_tangents([], 0.01)
    with pytest.raises(ca.UsageError, match="no derivative by `bar.m` was computed"):
        scene.energy_tangents(["bar.f"], 0.01)["bar.m"]
    for instants in (0, 481, 1.5):
        with pytest.raises(ca.UsageError, match="instants"):
            scene.energy_tangents(["bar.f"], 0.01, instants=instants)  # type: ignore[arg-type]
    pefrl = ca.parse('[model]\nmethod = "pefrl"\n[SOL]\nwall = {}\n[MAS]\na = { m = "1 g", dx0 = "1 mm" }\n[RES]\ns = { between = ["wall", "a"], k = "8 kN/m" }\n[SOX]\nout = { from = "a" }\n')
    with pytest.raises(ca.UsageError, match="does not support the energy ledger"):
        pefrl.energy_tangents(["s.k"], 0.01)
    key = ca.parse('[key]\nrate = "gesture"\n[key.SOL]\nbed = {}\n[key.MAS]\nlever = { m = "50 g", dx0 = "1 mm" }\n[key.REF]\nspring = { between = ["key.bed", "key.lever"], k = "200 N/m", z = "0.5 N s/m" }\n[CEL]\nbar = { m = "2 g", f = "330 Hz", t60 = "1 s" }\n[RES]\nhit = { between = ["key.lever", "bar"], k = "4 kN/m" }\n[SOX]\nout = { from = "bar" }\n')
    with pytest.raises(ca.UsageError, match="groups at the gesture rate are not differentiated"):
        key.energy_tangents(["bar.m"], 0.01)
