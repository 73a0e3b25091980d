"""Derivatives of the sound of a scene, against differences and products."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import numpy.typing as npt
import pytest

import cordis_anima as ca

Floats = npt.NDArray[np.float64]
BAR = """
[CEL]
bar = { m = "2 g", f = "440 Hz", t60 = "0.2 s", dx0 = "1 mm" }
[SOX]
left = { from = "bar", gain = 500 }
right = { from = "bar", gain = 300 }
"""


def test_tangents_are_those_of_differences() -> None:
    scene = ca.parse(BAR)
    t = scene.tangents(["bar.f", "bar.dx0", "left.gain"], 0.02)
    assert t.audio.shape == (960, 2) and t.tangents.shape == (960, 2, 3)
    assert (t.wrt, t.units, t.sr) == (("bar.f", "bar.dx0", "left.gain"), ("Hz", "m", ""), 48000)
    assert np.array_equal(t.audio.astype(np.float32), scene.render(0.02).audio)
    # the sound is linear in these two
    assert np.allclose(t["bar.dx0"] * 1e-3, t.audio, rtol=1e-10, atol=1e-12)
    assert np.allclose(t["left.gain"][:, 0] * 500, t.audio[:, 0], rtol=1e-12) and not t["left.gain"][:, 1].any()
    up, down = (scene.replace({"bar.f": f}).tangents(["bar.f"], 0.02).audio for f in (440.001, 439.999))
    difference = (up - down) / 0.002
    assert np.abs(difference - t["bar.f"]).max() < 1e-7 * np.abs(difference).max()


def test_what_does_not_fit_into_memory_is_refused() -> None:
    scene = ca.parse(BAR)
    with pytest.raises(ca.UsageError, match="do not fit into memory"):
        scene.tangents(["bar.f"] * 200, 1e8)
    with pytest.raises(ca.UsageError, match="do not fit into memory"):
        scene.gradient(["bar.f"], loss=lambda y: (0.0, y), seconds=9e8)


def test_a_signal_ends_it() -> None:
    script = """
import os, signal, threading
import cordis_anima as ca
string = ca.examples.string()
for call in (lambda: string.tangents(["low.f"], 300), lambda: string.gradient(["low.f"], loss=lambda y: (0.0, y), seconds=1000)):
    threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
    try:
        call()
    except KeyboardInterrupt:
        print("ended")
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.stdout == "ended\nended\n", done.stdout + done.stderr


@pytest.mark.parametrize("loss", [lambda y: 1.0, lambda y: (1.0, y, y), lambda y: None, 3])
def test_a_loss_gives_two_things(loss: object) -> None:
    with pytest.raises(ca.UsageError, match="`loss` must"):
        ca.parse(BAR).gradient(["bar.f"], loss=loss, seconds=0.01)  # type: ignore[arg-type]


@pytest.mark.parametrize("wrt", [None, 3, [], [1], ["bar.f", None]])
def test_names_are_names(wrt: object) -> None:
    with pytest.raises(ca.UsageError, match="names"):
        ca.parse(BAR).tangents(wrt)  # type: ignore[arg-type]


def test_complex_cotangents_are_refused() -> None:
    with pytest.raises(ca.UsageError, match="real numbers"):
        ca.parse(BAR).gradient(["bar.f"], cotangent=np.ones((10, 2)) * 1j)


def test_a_gradient_is_that_of_its_loss() -> None:
    scene = ca.parse(BAR)
    names = ["bar.f", "bar.t60", "bar.dx0"]

    def loss(y: Floats) -> tuple[float, Floats]:
        return float((y**2).sum()), 2 * y

    g = scene.gradient(names, loss=loss, seconds=0.02)
    t = scene.tangents(names, 0.02)
    assert g.loss == pytest.approx((t.audio**2).sum())
    assert g.gradient == pytest.approx(t.gradient(2 * t.audio), rel=1e-12)
    assert g["bar.dx0"] == pytest.approx(2 * g.loss / 1e-3)
    again = scene.gradient(names, cotangent=2 * t.audio)
    assert again.loss is None and np.array_equal(again.gradient, g.gradient)


def test_a_descent_finds_the_stroke() -> None:
    """A few Newton steps on the speed of a mass held by a spring, so that no contact moves to another tick."""
    text = BAR + '[MAS]\nbob = { m = "5 g", v = "0.4 m/s" }\n[CUB]\ntie = { between = ["bob", "bar"], k = "2 kN/m", k3 = "1e8 N/m^3" }\n'
    target = ca.parse(text).tangents(["bob.v"], 0.01).audio
    v = 0.3
    for _ in range(8):
        t = ca.parse(text).replace({"bob.v": f"{v!r} m/s"}).tangents(["bob.v"], 0.01)
        slope = t["bob.v"]
        v -= float((slope * (t.audio - target)).sum() / (slope**2).sum())
    assert v == pytest.approx(0.4, abs=1e-9)


@pytest.mark.parametrize(
    ("wrt", "said"),
    [(["bar.n"], "no such parameter"), (["bop.m"], "has no `bop.m`"), ([], "`wrt` is empty"), (["left.hear"], "one of several words")],
)
def test_what_has_no_derivative_is_refused(wrt: list[str], said: str) -> None:
    with pytest.raises(ca.UsageError, match=said):
        ca.parse(BAR).tangents(wrt, 0.01)


def test_shapes_are_checked() -> None:
    scene = ca.parse(BAR)
    with pytest.raises(ca.UsageError, match="shape"):
        scene.gradient(["bar.f"], cotangent=np.zeros((10, 3)))
    with pytest.raises(ca.UsageError, match="shape"):
        scene.gradient(["bar.f"], loss=lambda y: (0.0, y[1:]), seconds=0.01)
    with pytest.raises(ca.UsageError, match="cotangent"):
        scene.gradient(["bar.f"])
    with pytest.raises(ca.UsageError, match="no derivative by"):
        scene.tangents(["bar.f"], 0.01)["bar.m"]


STRING = BAR + '[MAS]\nbob = { m = "5 g", x = "-1 mm", v = "0.8 m/s" }\n[BUT]\nhit = { between = ["bob", "bar"], k = "9 kN/m" }\n'


@pytest.mark.parametrize("text", [BAR, STRING])
def test_both_modes_find_the_same(text: str) -> None:
    scene = ca.parse(text)
    names = ["bar.f", "bar.m", "bar.t60", "bar.dx0", "left.gain"] + (["hit.k", "bob.v"] if "hit" in text else [])
    y = scene.tangents(names, 0.02).audio
    found = {mode: scene.gradient(names, cotangent=y, mode=mode) for mode in ("auto", "reverse", "forward")}  # type: ignore[arg-type]
    assert [found[mode].mode for mode in found] == ["reverse", "reverse", "forward"]
    # compared as gradient times value, relative to the largest
    scale = np.abs(found["forward"].gradient * found["forward"].values).max()
    for mode in ("auto", "reverse"):
        off = np.abs((found[mode].gradient - found["forward"].gradient) * found["forward"].values)
        assert off.max() < 1e-10 * scale


def test_what_reverse_mode_does_not_know_goes_forward() -> None:
    scene = ca.parse('[model]\nmethod = "pefrl"\n[SOL]\nwall = {}\n[MAS]\na = { m = "1 g", dx0 = "1 mm" }\n[RES]\ns = { between = ["wall", "a"], k = "8 kN/m" }\n[SOX]\nout = { from = "a" }\n')
    assert scene.gradient(["s.k"], cotangent=np.ones(99)).mode == "forward"
    with pytest.raises(ca.UsageError, match="no reverse mode for this scene: it has the pass .* use forward mode"):
        scene.gradient(["s.k"], cotangent=np.ones(99), mode="reverse")
    # only derivatives by ports were requested
    with pytest.raises(ca.UsageError, match="no reverse mode"):
        scene.gradient(cotangent=np.ones(99))
    with pytest.raises(ca.UsageError, match="`auto`, `reverse` or `forward`"):
        scene.gradient(["s.k"], cotangent=np.ones(99), mode="back")  # type: ignore[arg-type]


def test_a_port_under_way_at_load_goes_forward() -> None:
    text = '[MAS]\na = { m = "1 g", v = "0.1 m/s" }\n[ENX]\ne = {}\n[BUT]\nl = { between = ["e", "a"], k = "1 kN/m", method = "stable" }\n[SOX]\no = { from = "a" }\n'
    scene, hand = ca.parse(text), {"e": np.linspace(0, 1e-3, 100)}
    g = scene.gradient(["a.m"], cotangent=np.ones(100), gesture=hand)
    assert g.mode == "forward" and g["a.m"] != 0
    # such a port runs a tick late, which reverse mode does not support
    with pytest.raises(ca.UsageError, match="no reverse mode for this scene: it has the pass `ports ahead`"):
        scene.gradient(["a.m"], cotangent=np.ones(100), gesture=hand, mode="reverse")
    assert scene.gradient(["a.m"], cotangent=np.ones(100)).mode == "forward"


def test_cotangents_and_losses_are_finite_numbers() -> None:
    scene, bad = ca.parse(BAR), np.ones((9, 2))
    bad[4, 1] = np.nan
    with pytest.raises(ca.UsageError, match="the cotangent of sample 4 is NaN"):
        scene.gradient(["bar.f"], cotangent=bad)
    for value in ("much", None, np.ones(3)):
        with pytest.raises(ca.UsageError, match="the value of a loss must be a number"):
            scene.gradient(["bar.f"], loss=lambda y: (value, y), seconds=0.01)  # type: ignore[arg-type, return-value]


def test_a_gesture_has_a_gradient() -> None:
    """Derivatives by port inputs are sums over the sound of the effect of each sample; exact for a linear scene."""
    text = BAR + '[ENF]\npush = { to = "bar" }\n[ENX]\nkey = {}\n[REF]\ntie = { between = ["key", "bar"], k = "300 N/m", z = "0.1 N s/m" }\n'
    scene, n = ca.parse(text), 400
    rng = np.random.default_rng(1)
    given = {"push": rng.normal(size=n), "key": 1e-3 * rng.normal(size=n)}
    weights = rng.normal(size=(n, 2))

    def heard(moved: dict[str, Floats]) -> float:
        return float((scene.tangents(["bar.f"], n / scene.rate, gesture=moved).audio * weights).sum())

    g = scene.gradient(cotangent=weights, gesture=given)
    assert g.wrt == () and set(g.inputs) == {"push", "key"} and g.inputs["key"].shape == (n,)
    base = heard(given)
    for name, step in (("push", 1.0), ("key", 1e-3)):
        for k in (0, 1, 7, 300, n - 2):
            moved = {**given, name: given[name] + step * (np.arange(n) == k)}
            assert heard(moved) - base == pytest.approx(step * g.inputs[name][k], rel=1e-7, abs=1e-9 * abs(base))


def test_without_names_and_ports_there_is_nothing_to_find() -> None:
    with pytest.raises(ca.UsageError, match="`wrt` is empty"):
        ca.parse(BAR).gradient(cotangent=np.ones((9, 2)))
