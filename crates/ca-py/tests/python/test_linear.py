"""The linear part as matrices, against the numbers of a tick and the tick itself."""

from __future__ import annotations

import numpy as np
import pytest

import cordis_anima as ca

#: cells, masses, springs, dampers, a port and a force on a line, and a non-linear link
LINE = """
[MAS]
a = { m = "2 g", dx0 = "1 mm" }
b = { m = "3 g", v = "0.1 m/s" }
[CEL]
c = { m = "1 g", f = "330 Hz", t60 = "0.3 s" }
[SOL]
wall = {}
[ENX]
hand = {}
[ENF]
push = { to = "b" }
[REF]
one = { between = ["wall", "a"], k = "3 kN/m", z = "0.05 N s/m" }
two = { between = ["a", "b"], k = "1.3 kN/m", z = "0.02 N s/m" }
hold = { between = ["hand", "c"], k = "700 N/m", z = "0.1 N s/m" }
[RES]
three = { between = ["b", "c"], k = "2.1 kN/m"METHOD }
[FRO]
rub = { between = ["c", "a"], z = "0.01 N s/m" }
[SOX]
out = { from = "a" }
sum = { from = ["a", "c"] }
"""


HANGING = """
[model]
gravity = "9.81 m/s^2"
[MAS]
a = { m = "1 g", v = "0.1 m/s" }
b = { m = "2 g", x = "10 mm" }
[SOL]
roof = {}
[RES]
one = { between = ["roof", "a"], k = "100 N/m", l0 = "4 mm" }
two = { between = ["a", "b"], k = "300 N/m", l0 = "7 mm" }
three = { between = ["roof", "b"], k = "50 N/m" }
[SOX]
out = { from = "a" }
sum = { from = "b" }
"""


def test_weight_and_lengths_of_springs_are_constant_forces() -> None:
    scene = ca.parse(HANGING)
    part = scene.linear()
    assert part.left_out == () and np.allclose(
        part.constant, [-1e-3 * 9.81 + 100 * 4e-3 + 300 * 3e-3, -2e-3 * 9.81 - 300 * 3e-3], rtol=1e-12
    ), part.constant
    moved = scene.rollout(["a", "b"], 0.02)
    x, d = part.x, part.d
    for row in moved.x[1:]:
        x, d = part.tick(x, d)
        assert np.abs(x - row).max() <= 1e-12 * np.abs(moved.x).max()
    both, _ = part.tick(np.stack([part.x, part.x], axis=1), np.stack([part.d, part.d], axis=1))
    assert np.array_equal(both[:, 0], both[:, 1]) and np.allclose(both[:, 0], moved.x[1], rtol=1e-12)


@pytest.mark.parametrize("method", ["", ', method = "implicit"'])
def test_a_tick_by_matrices_is_that_of_the_scene(method: str) -> None:
    scene = ca.parse(LINE.replace("METHOD", method))
    part = scene.linear()
    assert part.places == ("a", "b", "c") and part.driven == ("hand",) and part.left_out == ()
    assert part.links == ("one", "two", "hold", "three", "rub") and part.other_scheme is None
    assert (part.N.count_nonzero() > 0) == bool(method)
    n = 400
    hand, push = 1e-3 * np.sin(np.arange(n) / 9), 0.3 * np.cos(np.arange(n) / 7)
    moved = scene.rollout(["a", "b", "c"], n / scene.rate, gesture={"hand": hand, "push": push})
    assert moved.x.shape == (n, 3) and moved.places == ("a", "b", "c") and len(moved) == n
    x, d = part.x, part.d
    # at load the motion is the one of the tick before, under the force at load
    assert np.abs(d - part.v * part.T).max() < 1e-6
    assert np.allclose(moved.x[0], x, atol=0)
    force = part.pushes[1].toarray()[0]
    assert part.pushes[0] == ("push",) and list(force) == [0, 1, 0]
    largest = 0.0
    for i in range(n - 1):
        motion = hand[i] - hand[i - 1] if i else 0.0
        x, d = part.tick(x, d, force * push[i], ([hand[i]], [motion]))
        largest = max(largest, np.abs(x - moved.x[i + 1]).max())
    assert largest <= 1e-12 * np.abs(moved.x).max(), largest
    # several states side by side are independent
    two = part.tick(np.stack([x, 2 * x], 1), np.stack([d, 2 * d], 1))[0]
    assert np.allclose(two[:, 1], 2 * two[:, 0], rtol=1e-14)


def test_a_tick_of_another_shape_is_refused() -> None:
    part = ca.parse(LINE.replace("METHOD", "")).linear()
    n, ports = len(part), len(part.driven)
    for x, d, force, driven, says in [
        (np.zeros(n + 1), np.zeros(n + 1), 0.0, (0.0, 0.0), "`x` and `d`"),
        (part.x, part.d[:-1], 0.0, (0.0, 0.0), "`x` and `d`"),
        (0.0, 0.0, 0.0, (0.0, 0.0), "`x` and `d`"),
        (part.x, part.d, np.zeros(n - 1), (0.0, 0.0), "`force`"),
        (part.x, part.d, 0.0, (np.zeros(ports + 1), 0.0), r"`driven\[0\]`"),
    ]:
        with pytest.raises(ca.UsageError, match=says):
            part.tick(x, d, force, driven)
    # one force per place applies to all states
    both = part.tick(np.stack([part.x, part.x], 1), np.stack([part.d, part.d], 1), np.arange(float(n)))[0]
    assert np.array_equal(both[:, 1], part.tick(part.x, part.d, np.arange(float(n)))[0])


def test_coefficients_are_those_stored() -> None:
    part = ca.parse(LINE.replace("METHOD", "")).linear()
    T = 1 / 48000
    assert part.T == T and list(part.mobility[:2]) == [T * T / 0.002, T * T / 0.003]
    assert list(part.link_k) == [3000, 1300, 700, 2100, 0]
    # viscosity is stored per tick
    assert list(part.link_z) == [0.05 / T, 0.02 / T, 0.1 / T, 0, 0.01 / T]
    assert part.K.shape == (3, 3) and np.array_equal(part.K.toarray(), part.K.toarray().T)
    assert part.K.toarray()[0, 1] == -1300 and part.K.toarray()[1, 1] == 1300 + 2100
    assert part.K_driven.toarray().tolist() == [[0.0], [0.0], [-700.0]]
    assert np.allclose(part.M.diagonal(), [0.002, 0.003, 0.001], rtol=1e-15)
    assert part.hears[0] == ("out", "sum[0]", "sum[1]")
    assert part.hears[1].toarray().tolist() == [[1, 0, 0], [1, 0, 0], [0, 0, 1]]
    assert repr(part) == "<Linear: 3 places, 5 links, 1 driven, 0 left out>"


def test_the_matrices_have_the_modes() -> None:
    from scipy.linalg import eigh

    scene = ca.load("harmonic_chain")
    part, modes = scene.linear(), scene.modes()
    squares = eigh(part.K.toarray(), part.M.toarray(), eigvals_only=True)
    f = np.sqrt(np.maximum(squares, 0)) / (2 * np.pi)
    # `f` is without damping, which shifts it by 1e-6
    assert np.allclose(np.sort(f), np.sort(modes.f), rtol=1e-4)


def test_what_is_not_linear_is_named() -> None:
    part = ca.load("hammered_string").linear()
    assert "strike" in part.left_out and "strike" in part.acts[0]
    assert abs(part.acts[1][[part.acts[0].index("strike")]].toarray()).sum() > 0
    modal = ca.parse("[low]\nmethod = \"modal\"\n[low.STRING]\nbass = { n = 8, f = 110, t60 = 1, m = \"1 g\" }\n[SOX]\nout = { from = \"low.bass[2]\" }\n")
    assert modal.linear().other_scheme == 'method = "modal"'
    with pytest.raises(ca.UsageError, match="modal"):
        modal.linear().tick(np.zeros(8), np.zeros(8))


def test_a_rollout_is_where_masses_are(key: ca.Scene) -> None:
    r = key.render(0.02, probes=["low[*]"], gesture={"key": 0.001, "hand": 0.0})
    moved = key.rollout("low[*]", 0.02, gesture={"key": 0.001, "hand": 0.0})
    assert np.array_equal(moved.x, r.probes["low[*]"]) and moved.places == r.columns["low[*]"]
    assert moved.status == r.status and moved.rate == key.rate and "samples of 40 places" in repr(moved)
    with pytest.raises(ca.UsageError, match="force"):
        key.rollout("strike", 0.01)
