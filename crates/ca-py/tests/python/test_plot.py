"""Plots show the data of a record in its units, and cost nothing unless used."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
import pytest

import cordis_anima as ca
from cordis_anima import plot
from cordis_anima._plots.measured import _joule
from plots import closed, drawn


def sine(f: float, amplitude: float, seconds: float, rate: int = 48000) -> ca.Render:
    """A render with a sine in its second channel, and half of it in the first."""
    text = "[CEL]\nb = { m = '1 g', f = '1 kHz', dx0 = '1 mm' }\n[SOX]\nleft = { from = 'b' }\nright = { from = 'b' }\n"
    r = ca.parse(text, rate=rate).render(seconds)
    x = amplitude * np.sin(2 * np.pi * f * np.arange(len(r.audio)) / rate)
    return replace(r, audio=np.stack([x / 2, x], axis=1).astype(np.float32))


def test_nobody_loads_what_only_plots_need() -> None:
    said = "import sys, cordis_anima; print([m for m in sys.modules if 'plot' in m])"
    done = subprocess.run([sys.executable, "-c", said], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


def test_what_is_missing_is_reported() -> None:
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
    # lanes are below each other, and the zero label of each is at its silence
    lanes = [line.get_transform().transform((0, 0))[1] for line in ax.lines]
    assert lanes[0] > lanes[1] + 50
    zeros = [y for y, text in zip(ax.get_yticks(), ax.get_yticklabels()) if text.get_text() == "0"]
    assert np.allclose([ax.transData.transform((0, y))[1] for y in zeros], lanes)
    # nothing is clipped
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
    # the same over time, for both channels together
    ax = plot.spectrogram(r)
    drawn(ax)
    mesh = ax.collections[0]
    level = np.asarray(mesh.get_array()).reshape(220, -1)
    times, edges = mesh.get_coordinates()[0, :, 0], mesh.get_coordinates()[:, 0, 1]
    assert times[0] == 0 and times[-1] == pytest.approx(seconds) and (np.diff(times) > 0).all()
    rows = level.argmax(axis=0)
    # a window of 0.1 s resolves pitch to 10 Hz
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
    # labels are at their lines and do not overlap
    texts = {t.get_text(): t for t in ax.texts}
    assert len(texts) > 10 and all(float(name) == pytest.approx(t.xy[0], abs=0.051) for name, t in texts.items())
    boxes = [t.get_window_extent() for t in texts.values()]
    assert all(a.x1 < b.x0 for a, b in zip(boxes, boxes[1:]))
    # nor beside the axes after zooming
    ax.set_xlim(50, 2000)
    drawn(ax)
    assert [bool(np.isfinite(t.get_tightbbox().x0)) for t in ax.texts] == [50 <= t.xy[0] <= 2000 for t in ax.texts]


def test_silence_is_shown_as_such() -> None:
    r = sine(440, 0, 0.1)
    for draw in (plot.sound, plot.spectrum, plot.spectrogram):
        drawn(draw(r))
    assert plot.spectrum(r).get_ylim() == (-120, 6)


def test_an_energy_ledger_is_an_account(key: ca.Scene) -> None:
    gesture = {"key": [(0, -0.006), (0.02, 0.002), (0.1, -0.006)], "grip": [(0, 2000), (0.03, 9000)]}
    r = key.render(0.2, gesture=gesture, energy=True)
    e = r.energy
    assert e is not None and e.work != 0 and e.lost > 0 and e.changed != 0
    for ledger in (r, e):
        ax = plot.energy(ledger)
        drawn(ax)
        bars = ax.patches
        entries = [e.start, e.work, -e.lost, e.made, e.changed, e.residual, e.stored]
        assert np.allclose([bar.get_width() for bar in bars], entries, rtol=0, atol=1e-12 * e.peak)
        # values too small for a bar are shown as numbers
        assert [text.get_text() for text in ax.texts] == [_joule(x) for x in entries]
        # each bar begins where the one before ends; the last is their sum
        ends = [bar.get_x() + bar.get_width() for bar in bars]
        assert np.allclose([bar.get_x() for bar in bars[1:-1]], ends[:-2], rtol=0, atol=1e-9 * e.peak)
        assert ends[-2] == pytest.approx(e.stored, abs=1e-12 * e.peak) and bars[-1].get_x() == 0
        low, high = ax.get_xlim()
        assert low <= min(ends) and max(ends) < high
        assert any(text.get_text().endswith("J") and text.get_text() != "0 J" for text in ax.get_xticklabels())
    with pytest.raises(ca.UsageError, match="energy=True"):
        plot.energy(key.render(0.01))


def test_energies_have_a_unit_people_know() -> None:
    said = [_joule(x) for x in (-0.0, 0.0123, -5e-6, 2.5e-9, 3.0, -1.7e-15, 4.2e5)]
    assert said == ["0 J", "12.3 mJ", "−5 µJ", "2.5 nJ", "3 J", "−1.7e−15 J", "4.2e+05 J"]


def test_modes_are_dots_over_what_is_heard() -> None:
    m = ca.load("hammered_string").modes()
    ax = plot.modes(m)
    drawn(ax)
    x, y = ax.lines[0].get_data()
    # the free hammer on an undamped spring is at the edge
    rings = (m.heard > 0) & (m.t60 < 86400)
    assert np.array_equal(x, m.heard[rings]) and np.array_equal(y, m.t60[rings]) and len(ax.lines) == 2
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("frequency as heard [Hz]", "T60 [s]")
    low, high = ax.get_ylim()
    assert low < m.t60[rings].min() and m.t60[rings].max() < high
    # three glasses, each with its own output
    m = ca.load("glass").modes()
    ax = plot.modes(m, "rim1")
    drawn(ax)
    level = np.abs(m.levels[:, m.ports.index("rim1")])
    shown = dict(zip(*ax.lines[0].get_data()))
    # modes that do not move there are not shown
    assert set(shown) == set(m.heard[level > 1e-6 * level.max()]) and len(shown) < len(m)
    for f, l in zip(m.heard, level):
        assert f not in shown or shown[f] == pytest.approx(20 * np.log10(l / level.max()), abs=1e-9)
    assert ax.get_ylabel() == "level at `rim1` [dB, the loudest = 0]"
    with pytest.raises(ca.UsageError, match="rim1, rim2"):
        plot.modes(m, "middle")


def test_modes_that_do_not_fall_stand_at_the_edge() -> None:
    m = ca.examples.string().modes()
    free = replace(m, t60=np.where(np.arange(len(m)) % 2 == 0, np.inf, m.t60), grows=np.arange(len(m)) == 3)
    ax = plot.modes(free)
    drawn(ax)
    falls, free_ones, growing = ax.lines
    # the hammer flies and does not oscillate
    assert "modes not shown (no oscillation): 1" == ax.get_title("right")
    assert np.array_equal(free_ones.get_xdata(), m.heard[2::2]) and free_ones.get_label() == "without damping"
    assert np.array_equal(growing.get_xdata(), m.heard[3:4]) and growing.get_label() == "grows"
    assert len(falls.get_xdata()) == len(m) - 1 - len(m.heard[2::2]) - 1
    # no mode oscillates
    with pytest.raises(ca.UsageError, match="oscillates"):
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
        assert line.get_label() == (f"{method} (×1 diverges)" if blows_up else method)
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
    # forces have a second axis
    ax = plot.probes(r, ["low[3]", "strike"])
    drawn(ax)
    (other,) = [a for a in ax.figure.axes if a is not ax]
    assert ax.get_ylabel() == "displacement" and other.get_ylabel() == "force"
    assert np.array_equal(other.lines[0].get_ydata(), r.probes["strike"]) and r.probes["strike"].any()
    assert all(text.get_text().endswith("N") for text in other.get_yticklabels())
    legend = ax.get_legend()
    assert legend is not None and [t.get_text() for t in legend.get_texts()] == ["low[3]", "strike (right)"]
    assert len({line.get_color() for a in (ax, other) for line in a.lines}) == 2
    # all probes, and many columns of one
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


def test_what_makes_no_sound_has_no_plot_of_it() -> None:
    deaf = ca.parse("[CEL]\nb = { m = '1 g', f = '1 kHz', dx0 = '1 mm' }\n[SOX]\no = { from = 'b' }\n").render(0.01)
    deaf = replace(deaf, audio=deaf.audio[:, :0], channels=())
    for draw in (plot.sound, plot.spectrum, plot.spectrogram):
        with pytest.raises(ca.UsageError, match="no sound"):
            draw(deaf)
