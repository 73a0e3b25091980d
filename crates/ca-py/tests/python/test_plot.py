"""Plots show what is in the record, in its units, and cost nothing where nobody plots."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.axes import Axes

import cordis_anima as ca
from cordis_anima import plot


@pytest.fixture(autouse=True)
def closed() -> Iterator[None]:
    """Figures do not stay."""
    yield
    plt.close("all")


def drawn(ax: Axes) -> None:
    """It can be drawn, with a name at each axis."""
    ax.figure.canvas.draw()


def sine(f: float, amplitude: float, seconds: float, rate: int = 48000) -> ca.Render:
    """A render that holds a sine in its second channel, half as loud in its first."""
    text = "[CEL]\nb = { m = '1 g', f = '1 kHz', dx0 = '1 mm' }\n[SOX]\nleft = { from = 'b' }\nright = { from = 'b' }\n"
    r = ca.parse(text, rate=rate).render(seconds)
    x = amplitude * np.sin(2 * np.pi * f * np.arange(len(r.audio)) / rate)
    return replace(r, audio=np.stack([x / 2, x], axis=1).astype(np.float32))


def test_nobody_loads_what_only_plots_need() -> None:
    said = "import sys, cordis_anima; print([m for m in sys.modules if 'matplotlib' in m or m.endswith('.plot')])"
    done = subprocess.run([sys.executable, "-c", said], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


def test_what_is_missing_is_told() -> None:
    said = """
import sys
sys.modules["matplotlib"] = None
import cordis_anima as ca
try:
    from cordis_anima import plot
except ca.CaError as e:
    assert isinstance(e, ca.MissingError) and isinstance(e, ImportError) and e.name == "matplotlib"
    print(e)
"""
    done = subprocess.run([sys.executable, "-c", said], capture_output=True, text=True, check=True)
    assert done.stdout == 'plots need matplotlib: pip install "cordis-anima[plot]"\n'


def test_a_waveform_is_the_samples(key: ca.Scene) -> None:
    r = key.render(0.2, gesture={"key": 0.001})
    ax = plot.sound(r)
    drawn(ax)
    assert [line.get_label() for line in ax.lines] == ["left", "right"]
    for k, line in enumerate(ax.lines):
        assert np.array_equal(line.get_ydata(), r.audio[:, k]) and r.audio[:, k].any()
        assert np.array_equal(line.get_xdata(), np.arange(9600) / 48000)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("time [s]", "sound [full scale = 1]")
    # lanes lie one below the other, and the middle number of each stands where it is silent
    lanes = [line.get_transform().transform((0, 0))[1] for line in ax.lines]
    assert lanes[0] > lanes[1] + 50
    zeros = [y for y, text in zip(ax.get_yticks(), ax.get_yticklabels()) if text.get_text() == "0"]
    assert np.allclose([ax.transData.transform((0, y))[1] for y in zeros], lanes)
    # nothing of it is cut off
    for k, line in enumerate(ax.lines):
        shown = line.get_transform().transform(np.column_stack([np.zeros(9600), r.audio[:, k]]))[:, 1]
        assert shown.min() >= ax.bbox.y0 and shown.max() <= ax.bbox.y1


def test_it_is_drawn_where_it_is_asked_for() -> None:
    r = ca.examples.string().render(0.1, probes=["hammer"], energy=True)
    m = ca.examples.string().modes()
    _, axes = plt.subplots(6)
    for ax, do in zip(
        axes, [plot.sound, plot.spectrum, plot.spectrogram, plot.energy, plot.probes, lambda _, ax: plot.modes(m, ax=ax)]
    ):
        assert do(r, ax=ax) is ax and ax.has_data()
    assert len(plt.get_fignums()) == 1


@pytest.mark.parametrize(("f", "amplitude", "seconds"), [(440.0, 1.0, 1.0), (1234.5, 0.1, 6.0), (3001.7, 0.01, 0.2)])
def test_a_sine_reads_its_level_at_its_pitch(f: float, amplitude: float, seconds: float) -> None:
    r = sine(f, amplitude, seconds)
    ax = plot.spectrum(r)
    drawn(ax)
    for line, less in zip(ax.lines, (20 * np.log10(2), 0)):
        x, y = line.get_data()
        loudest = int(np.argmax(y))
        assert y[loudest] == pytest.approx(20 * np.log10(amplitude) - less, abs=0.4)
        assert abs(x[loudest] - f) < 1 / min(seconds, 2.7)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("frequency [Hz]", "level of a sine [dBFS]")
    # the same in time, of both channels together
    ax = plot.spectrogram(r)
    drawn(ax)
    mesh = ax.collections[0]
    level = np.asarray(mesh.get_array()).reshape(220, -1)
    times, edges = mesh.get_coordinates()[0, :, 0], mesh.get_coordinates()[:, 0, 1]
    assert times[0] == 0 and times[-1] == pytest.approx(seconds) and (np.diff(times) > 0).all()
    rows = level.argmax(axis=0)
    # a window of 0.1 s knows no pitch nearer than 10 Hz
    assert (edges[rows] < f + 12).all() and (edges[rows + 1] > f - 12).all()
    assert np.allclose(level.max(axis=0), 20 * np.log10(amplitude * np.sqrt(1.25)), atol=0.5)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("time [s]", "frequency [Hz]")


def test_no_moment_is_lost() -> None:
    r = sine(440, 0, 100.0, rate=8000)
    clicks = [0.05, *np.arange(3.3, 97, 7.77), 99.95]
    for at in clicks:
        r.audio[int(at * 8000), 0] = 1
    mesh = plot.spectrogram(r).collections[0]
    level = np.asarray(mesh.get_array()).reshape(220, -1)
    times = mesh.get_coordinates()[0, :, 0]
    assert level.shape[1] <= 640
    loud = level.max(axis=0) > -100
    assert all(loud[np.searchsorted(times, at) - 1] for at in clicks)
    assert loud.sum() < 4 * len(clicks)
    # nor in a spectrum
    for at in clicks[4::5]:
        r.audio[:] = 0
        r.audio[int(at * 8000), 0] = 1
        assert plot.spectrum(r).lines[0].get_ydata().max() > -200
        plt.close("all")


def test_modes_stand_in_a_spectrum() -> None:
    scene = ca.load("hammered_string")
    m = scene.modes()
    ax = plot.spectrum(scene.render(1.0), m)
    drawn(ax)
    lines = [segment[0, 0] for segment in ax.collections[0].get_segments()]
    assert np.array_equal(lines, m.heard[m.heard >= 20])
    # numbers stand at their lines, and on no other number
    texts = {t.get_text(): t for t in ax.texts}
    assert len(texts) > 10 and all(float(name) == pytest.approx(t.xy[0], abs=0.051) for name, t in texts.items())
    boxes = [t.get_window_extent() for t in texts.values()]
    assert all(a.x1 < b.x0 for a, b in zip(boxes, boxes[1:]))
    # nor beside the axes where somebody looks closer
    ax.set_xlim(50, 2000)
    drawn(ax)
    assert [bool(np.isfinite(t.get_tightbbox().x0)) for t in ax.texts] == [50 <= t.xy[0] <= 2000 for t in ax.texts]


def test_silence_is_shown_as_such() -> None:
    r = sine(440, 0, 0.1)
    for draw in (plot.sound, plot.spectrum, plot.spectrogram):
        drawn(draw(r))
    assert plot.spectrum(r).get_ylim() == (-120, 6)


def test_an_energy_book_is_an_account(key: ca.Scene) -> None:
    gesture = {"key": [(0, -0.006), (0.02, 0.002), (0.1, -0.006)], "grip": [(0, 2000), (0.03, 9000)]}
    r = key.render(0.2, gesture=gesture, energy=True)
    e = r.energy
    assert e is not None and e.work != 0 and e.lost > 0 and e.changed != 0
    for book in (r, e):
        ax = plot.energy(book)
        drawn(ax)
        bars = ax.patches
        entries = [e.start, e.work, -e.lost, e.made, e.changed, e.residual, e.stored]
        assert np.allclose([bar.get_width() for bar in bars], entries, rtol=0, atol=1e-12 * e.peak)
        # what is too small for a bar is a number
        assert [text.get_text() for text in ax.texts] == [plot._joule(x) for x in entries]
        # each begins where the one before ends; the last is what they come to
        ends = [bar.get_x() + bar.get_width() for bar in bars]
        assert np.allclose([bar.get_x() for bar in bars[1:-1]], ends[:-2], rtol=0, atol=1e-9 * e.peak)
        assert ends[-2] == pytest.approx(e.stored, abs=1e-12 * e.peak) and bars[-1].get_x() == 0
        low, high = ax.get_xlim()
        assert low <= min(ends) and max(ends) < high
        assert any(text.get_text().endswith("J") and text.get_text() != "0 J" for text in ax.get_xticklabels())
    with pytest.raises(ca.UsageError, match="energy=True"):
        plot.energy(key.render(0.01))


def test_energies_have_a_unit_people_know() -> None:
    said = [plot._joule(x) for x in (-0.0, 0.0123, -5e-6, 2.5e-9, 3.0, -1.7e-15, 4.2e5)]
    assert said == ["0 J", "12.3 mJ", "−5 µJ", "2.5 nJ", "3 J", "−1.7e−15 J", "4.2e+05 J"]


def test_modes_are_dots_over_what_is_heard() -> None:
    m = ca.load("hammered_string").modes()
    ax = plot.modes(m)
    drawn(ax)
    x, y = ax.lines[0].get_data()
    assert np.array_equal(x, m.heard) and np.array_equal(y, m.t60) and len(ax.lines) == 1
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("frequency as heard [Hz]", "T60 [s]")
    low, high = ax.get_ylim()
    assert low < m.t60.min() and m.t60.max() < high
    ax = plot.modes(m, "right")
    drawn(ax)
    level = np.abs(m.levels[:, m.ports.index("right")])
    shown = dict(zip(*ax.lines[0].get_data()))
    # what does not move there is not shown
    assert set(shown) == set(m.heard[level > 1e-6 * level.max()]) and len(shown) < len(m)
    for f, l in zip(m.heard, level):
        assert f not in shown or shown[f] == pytest.approx(20 * np.log10(l / level.max()), abs=1e-9)
    assert ax.get_ylabel() == "level at `right` [dB, the loudest = 0]"
    with pytest.raises(ca.UsageError, match="left, right, strike"):
        plot.modes(m, "middle")


def test_modes_that_do_not_fall_stand_at_the_edge() -> None:
    m = ca.examples.string().modes()
    free = replace(m, t60=np.where(np.arange(len(m)) % 2 == 0, np.inf, m.t60), grows=np.arange(len(m)) == 3)
    ax = plot.modes(free)
    drawn(ax)
    falls, free_ones, growing = ax.lines
    # the hammer flies, and does not swing
    assert "1 that does not swing left out" == ax.get_title("right")
    assert np.array_equal(free_ones.get_xdata(), m.heard[2::2]) and free_ones.get_label() == "without damping"
    assert np.array_equal(growing.get_xdata(), m.heard[3:4]) and growing.get_label() == "grows"
    assert len(falls.get_xdata()) == len(m) - 1 - len(m.heard[2::2]) - 1
    # nothing swings
    with pytest.raises(ca.UsageError, match="swings"):
        plot.modes(ca.parse("[MAS]\nm = { m = 1, v = 1 }\n[SOX]\no = { from = 'm' }\n").modes())


def test_accuracy_is_error_over_time() -> None:
    text = "[SOL]\nw = {}\n[MAS]\nb = { m = '1 g', dx0 = '1 mm' }\n[REF]\nr = { between = ['w', 'b'], k = '12 MN/m', z = '1 mN s/m' }\n[SOX]\no = { from = 'b' }\n"
    a = ca.parse(text).accuracy(0.01, times=[1, 2])
    assert np.isinf(a.error).any() and (a.error < a.known).any()
    ax = plot.accuracy(a)
    drawn(ax)
    methods = list(dict.fromkeys(a.method))
    for method, line in zip(methods, ax.lines):
        x, y = line.get_data()
        at = [k for k in range(len(a)) if a.method[k] == method and np.isfinite(a.error[k])]
        assert np.array_equal(x, a.ns[at]) and np.array_equal(y, np.maximum(a.error[at], a.known))
        blows_up = len(at) < 2
        assert line.get_label() == (f"{method} (×1 blows up)" if blows_up else method)
    full = ax.lines[len(methods) :]
    assert {line.get_xdata()[0] for line in full} == set(a.ns[a.front]) and len(full) == a.front.sum() > 0
    names = {f"{a.method[k]} ×{a.times[k]}" for k in np.flatnonzero(a.front)}
    assert {t.get_text() for t in ax.texts} <= names and ax.texts
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("time of one sample [ns]", "error, relative")
    assert ax.get_xscale() == ax.get_yscale() == "log" and a.against in ax.get_title("left")


def test_probes_are_shown_in_their_units(key: ca.Scene) -> None:
    asked = ["strike", "low[3]", "low[0..3]", "low.link[2]", "hold", "left", "key", "low@0.3"]
    r = key.render(0.1, gesture={"key": 0.001}, probes=asked)
    assert dict(r.units) == dict(zip(asked, ["N", "m", "m", "N", "N", "m", "m", "m"]))
    ax = plot.probes(r, "low[0..3]")
    drawn(ax)
    assert [line.get_label() for line in ax.lines] == ["low[0]", "low[1]", "low[2]"]
    for k, line in enumerate(ax.lines):
        assert np.array_equal(line.get_ydata(), r.probes["low[0..3]"][:, k]) and line.get_ydata().any()
        assert np.array_equal(line.get_xdata(), np.arange(4800) / 48000)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("time [s]", "displacement")
    assert all(text.get_text().endswith("m") for text in ax.get_yticklabels())
    # forces have an axis of their own
    ax = plot.probes(r, ["low[3]", "strike"])
    drawn(ax)
    (other,) = [a for a in ax.figure.axes if a is not ax]
    assert ax.get_ylabel() == "displacement" and other.get_ylabel() == "force"
    assert np.array_equal(other.lines[0].get_ydata(), r.probes["strike"]) and r.probes["strike"].any()
    assert all(text.get_text().endswith("N") for text in other.get_yticklabels())
    legend = ax.get_legend()
    assert legend is not None and [t.get_text() for t in legend.get_texts()] == ["low[3]", "strike (right)"]
    assert len({line.get_color() for a in (ax, other) for line in a.lines}) == 2
    # all of them, and many of one
    ax = plot.probes(r)
    assert sum(len(a.lines) for a in ax.figure.axes) == 10
    many = plot.probes(key.render(0.01, probes="low[*]"))
    legend = many.get_legend()
    assert len(many.lines) == 40 and legend is not None
    assert [t.get_text() for t in legend.get_texts()] == ["low[0]", "low[39]"]
    with pytest.raises(ca.UsageError, match="no probe `low`; the render has strike"):
        plot.probes(r, "low")
    with pytest.raises(ca.UsageError, match="probes="):
        plot.probes(key.render(0.01))


def swept() -> ca.Sweep:
    """Runs of every sort: ok, clipped, unstable, invalid; one that is silent; texts along one axis."""
    text = (
        "[CEL]\nb = { m = '1 g', k = '1 kN/m', dx0 = 1 }\nc = { m = '1 g', f = '1 kHz', dx0 = 0.3 }\n"
        "[SOX]\no = { from = 'b', gain = 1 }\n"
    )
    vary = {"b.k": [1e3, 4e3, -1.0, 1e9], "b.m": [0.001, 0.004], "b.dx0": [0.0, 0.5, 1.25], "o.from": ["b", "c"]}
    return ca.sweep(ca.parse(text), vary, seconds=0.05)


def offsets(ax: Axes) -> dict[str, set[tuple[float, float]]]:
    """Where dots of each label are."""
    found: dict[str, set[tuple[float, float]]] = {}
    for mark in ax.collections:
        at = {(float(px), float(py)) for px, py in np.asarray(mark.get_offsets())}
        found.setdefault(str(mark.get_label()), set()).update(at)
    return found


def rows(s: ca.Sweep, x: str, y: str, which: np.ndarray) -> set[tuple[float, float]]:
    """The same of the columns."""
    return set(zip(s[x][which].tolist(), s[y][which].tolist()))


def test_a_sweep_is_dots_and_what_went_wrong_is_crosses() -> None:
    s = swept()
    assert set(s.counts) == {"ok", "clipped", "invalid", "unstable"}, s.counts
    status, placed = s["status"], np.isfinite(s["partial"])
    ax = plot.sweep(s, "b.k", "partial")
    drawn(ax)
    dots = offsets(ax)
    assert dots == {name: rows(s, "b.k", "partial", (status == name) & placed) for name in ("ok", "clipped")}
    assert all(dots.values()) and (ax.get_xlabel(), ax.get_ylabel()) == ("b.k", "partial [Hz]")
    # what blew up was never heard, however loud a number it has; it stands at the edge, over its parameter
    crosses = {str(line.get_label()): line for line in ax.lines}
    assert set(crosses) == {"invalid", "unstable"}
    for name, line in crosses.items():
        assert line.get_xdata().tolist() == s["b.k"][status == name].tolist()
        height = ax.transAxes.inverted().transform(line.get_transform().transform(line.get_xydata()))[:, 1]
        assert ((height > 0.95) & (height < 1)).all()
    low, high = ax.get_ylim()
    heard = s["partial"][placed & ((status == "ok") | (status == "clipped"))]
    assert low < heard.min() and heard.max() < high < 2 * heard.max()
    # they are within what is seen
    assert ax.get_xlim()[0] < s["b.k"].min() and s["b.k"].max() < ax.get_xlim()[1]
    silent = ~placed & ((status == "ok") | (status == "clipped"))
    assert ax.get_title("right") == f"{silent.sum()} without a place left out" and silent.sum() > 0
    legend = ax.get_legend()
    assert legend is not None and [t.get_text() for t in legend.get_texts()] == ["ok", "clipped", "invalid", "unstable"]
    # at the right edge where it is the other one, and at their place where both are known
    ax = plot.sweep(s, "peak", "b.k")
    drawn(ax)
    bad = ["invalid", "unstable"]
    assert [line.get_ydata().tolist() for line in ax.lines] == [s["b.k"][status == name].tolist() for name in bad]
    assert ax.get_xlim()[1] < 3 and ax.get_xlabel() == "peak [full scale = 1]"
    ax = plot.sweep(s, "b.k", "b.m")
    assert [set(zip(*line.get_data())) for line in ax.lines] == [rows(s, "b.k", "b.m", status == name) for name in bad]
    ax = plot.sweep(s, "peak", "t60")
    left = np.isnan(s["t60"]) | (status == "invalid") | (status == "unstable")
    assert not ax.lines and 0 < left.sum() < s.runs and ax.get_title("right").startswith(f"{left.sum()} without")
    # where all is as it should be nothing needs a legend
    good = ca.sweep(ca.examples.string(), {"low.m": ["1 g", "2 g"]}, seconds=0.05)
    assert plot.sweep(good, "low.m", "run_time").get_legend() is None


def test_a_sweep_has_categories_and_colours() -> None:
    s = swept()
    status = s["status"]
    ok = s.ok & np.isfinite(s["partial"])
    # texts are along an axis
    ax = plot.sweep(s, "b.k", "status")
    drawn(ax)
    names = [t.get_text() for t in ax.get_yticklabels()]
    assert names == ["clipped", "invalid", "ok", "unstable"]
    assert offsets(ax)["ok"] == {(k, 2.0) for k in s["b.k"][s.ok]}
    assert {float(line.get_ydata()[0]): line.get_label() for line in ax.lines} == {1.0: "invalid", 3.0: "unstable"}
    # what has no text is a category too
    ax = plot.sweep(s, "module", "b.m")
    drawn(ax)
    assert [t.get_text() for t in ax.get_xticklabels()] == ["b", "none"]
    assert {px for px, _ in offsets(ax)["ok"]} == {1.0}
    # numbers colour by a bar
    ax = plot.sweep(s, "b.k", "partial", color="t60")
    drawn(ax)
    assert ax.figure.axes[-1].get_ylabel() == "t60 [s]"
    # what has no number there is drawn all the same
    shown = sum(len(mark.get_offsets()) - np.ma.getmaskarray(mark.get_offsets()).any(axis=1).sum() for mark in ax.collections)
    has = (s.ok | (status == "clipped")) & np.isfinite(s["partial"])
    assert shown == has.sum() and np.isnan(s["t60"][has]).any()
    ax = plot.sweep(s, "b.k", "partial", color="b.m")
    drawn(ax)
    mark = ax.collections[0]
    shades = dict(zip(map(tuple, np.asarray(mark.get_offsets())), np.asarray(mark.get_array())))
    assert shades == {(k, f): m for k, f, m in zip(s["b.k"][ok], s["partial"][ok], s["b.m"][ok])}
    # one scale for dots and triangles
    ax = plot.sweep(s, "b.k", "partial", color="b.dx0")
    assert [mark.get_clim() for mark in ax.collections] == [(0.0, 1.25)] * 2 and set(s["b.dx0"][status == "clipped"]) == {1.25}
    # texts by a legend
    ax = plot.sweep(s, "b.k", "partial", color="o.from")
    drawn(ax)
    of = {name: (status == "ok") & np.isfinite(s["partial"]) & (s["o.from"] == name) for name in "bc"}
    loud = (status == "clipped") & np.isfinite(s["partial"])
    assert set(s["o.from"][loud]) == {"b"}
    assert offsets(ax) == {
        "o.from = b": rows(s, "b.k", "partial", of["b"]),
        "o.from = b, clipped": rows(s, "b.k", "partial", loud),
        "o.from = c": rows(s, "b.k", "partial", of["c"]),
    }
    assert all(offsets(ax).values())
    for x, y, color, wrong in [("b.q", "peak", None, "b.q"), ("b.k", "loud", None, "loud"), ("b.k", "peak", "hue", "hue")]:
        with pytest.raises(ca.UsageError, match=f"no column `{wrong}`; the sweep has index, b.k"):
            plot.sweep(s, x, y, color=color)


#: two keys, one in a contact; a third moves by a hundredth of a millimetre, as a sensor's noise does
KEYS = """
[TGR]
low = { device = "tgr12", dof = 1, x = "-6 mm" }
high = { device = "tgr12", dof = 4, x = "-6 mm" }
still = { device = "tgr12", dof = 7, x = "-6 mm" }
[SOL]
bed = {}
[BUT]
pad = { between = [["low", "high", "still"], "bed"], k = "2 kN/m", z = "1 N s/m" }
[SOF]
out = { from = "bed" }
"""


def keys(path: Path, last: float) -> ca.Take:
    """A press of both keys once forces are on, then one of the first within `last` [s]."""
    press = [(0, -6e-3), (1.2, -6e-3), (1.25, 1e-3), (1.3, -6e-3)]
    gesture = {"low": [*press, (1.4, -6e-3), (1.4 + last, 1e-3)], "high": press, "still": [(0, -6e-3), (1, -6.01e-3)]}
    return ca.record(ca.parse(KEYS), path, 1.8, gesture=gesture)


def test_a_take_is_where_hands_were_and_what_they_got(tmp_path: Path) -> None:
    t = keys(tmp_path / "t.mcap", 0.1)
    hand = t.hands["tgr12"]
    above, below = plot.take(t)
    drawn(above)
    assert [line.get_label() for line in above.lines] == [line.get_label() for line in below.lines] == ["tgr12 1", "tgr12 4"]
    for dof, position, force in zip((1, 4), above.lines, below.lines):
        assert np.array_equal(position.get_xdata(), hand.time) and np.array_equal(force.get_xdata(), hand.force_time)
        assert np.array_equal(position.get_ydata(), 1e3 * hand.position[:, dof]) and np.ptp(position.get_ydata()) > 6.9
        assert np.array_equal(force.get_ydata(), hand.force[:, dof]) and np.ptp(force.get_ydata()) > 1.9
        assert force.get_drawstyle() == "steps-post"
    assert above.lines[0].get_color() != above.lines[1].get_color()
    assert (above.get_ylabel(), below.get_ylabel(), below.get_xlabel()) == ("position [mm]", "force [N]", "time [s]")
    # how forces were meant, each as long as it lasted
    for ax in (above, below):
        begins = {p.get_label(): (p.get_x(), p.get_x() + p.get_width()) for p in ax.patches}
        assert list(begins) == ["off", "ramp", "on"]
        assert begins["off"][0] == 0 and begins["off"][1] == begins["ramp"][0] == hand.force_time[hand.mode == "ramp"][0]
        assert begins["ramp"][1] == begins["on"][0] and begins["on"][1] == ax.get_xlim()[1] == hand.force_time[-1]
    legend = above.get_legend()
    assert legend is not None and [x.get_text() for x in legend.get_texts()] == ["tgr12 1", "tgr12 4", "off", "ramp", "on"]
    # what is asked for, where it is asked for
    _, axes = plt.subplots(2)
    assert plot.take(t, "tgr12", [7, 4], axes=(axes[0], axes[1])) == (axes[0], axes[1])
    assert [line.get_label() for line in axes[0].lines] == ["tgr12 7", "tgr12 4"]
    assert [line.get_label() for line in plot.take(t, dof=0)[1].lines] == ["tgr12 0"]
    for wrong in (12, -1):
        with pytest.raises(ca.UsageError, match=f"no degree of freedom {wrong}; `tgr12` has 0 to 11"):
            plot.take(t, dof=wrong)
    with pytest.raises(ca.UsageError, match="no device `falcon`; the take has tgr12"):
        plot.take(t, "falcon")


def test_where_forces_ended_stands_in_a_take(tmp_path: Path) -> None:
    t = keys(tmp_path / "t.mcap", 0.01)
    (fault,) = t.faults
    above, below = plot.take(t)
    drawn(above)
    assert [text.get_text() for text in below.texts] == ["VELOCITY"] and below.texts[0].xy[0] == fault.time
    assert [p.get_label() for p in below.patches] == ["off", "ramp", "on", "damp", "fault"]
    assert len({p.get_facecolor() for p in below.patches}) == 5
    for ax in (above, below):
        assert list(ax.lines[-1].get_xdata()) == [fault.time] * 2 and fault.time == ax.patches[-1].get_x()
    # a line is no degree of freedom
    legend = above.get_legend()
    assert legend is not None and len(legend.get_texts()) == 2 + 5


def test_a_take_without_hands_has_no_plot(tmp_path: Path) -> None:
    t = ca.record(ca.examples.string(), tmp_path / "string.mcap", 0.05)
    with pytest.raises(ca.UsageError, match="nothing to show: the take has no device"):
        plot.take(t)
    whole = keys(tmp_path / "t.mcap", 0.1)
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(Path(whole.path).read_bytes()[:12000])
    with pytest.raises(ca.UsageError, match="no frames of `tgr12`"):
        plot.take(ca.Take(cut))
    # nothing moves: the first
    held = ca.record(ca.parse(KEYS), tmp_path / "held.mcap", 0.05)
    assert [line.get_label() for line in plot.take(held)[0].lines] == ["tgr12 0"]


def test_what_makes_no_sound_has_no_plot_of_it() -> None:
    deaf = ca.parse("[CEL]\nb = { m = '1 g', f = '1 kHz', dx0 = '1 mm' }\n[SOX]\no = { from = 'b' }\n").render(0.01)
    deaf = replace(deaf, audio=deaf.audio[:, :0], channels=())
    for draw in (plot.sound, plot.spectrum, plot.spectrogram):
        with pytest.raises(ca.UsageError, match="no sound"):
            draw(deaf)
