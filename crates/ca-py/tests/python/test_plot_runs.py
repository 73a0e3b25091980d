"""Plots of sweeps and takes show every run, failed ones too, and the motion and forces of each hand."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.axes import Axes

import cordis_anima as ca
from cordis_anima import plot
from plots import closed, drawn


def swept() -> ca.Sweep:
    """Runs of every kind: ok, clipped, unstable, invalid, silent; with texts along one axis."""
    text = (
        "[CEL]\nb = { m = '1 g', k = '1 kN/m', dx0 = 1 }\nc = { m = '1 g', f = '1 kHz', dx0 = 0.3 }\n"
        "[SOX]\no = { from = 'b', gain = 1 }\n"
    )
    vary = {"b.k": [1e3, 4e3, -1.0, 1e9], "b.m": [0.001, 0.004], "b.dx0": [0.0, 0.5, 1.25], "o.from": ["b", "c"]}
    return ca.sweep(ca.parse(text), vary, seconds=0.05, measure=True)


def offsets(ax: Axes) -> dict[str, set[tuple[float, float]]]:
    """Positions of the dots of each label."""
    found: dict[str, set[tuple[float, float]]] = {}
    for mark in ax.collections:
        at = {(float(px), float(py)) for px, py in np.asarray(mark.get_offsets())}
        found.setdefault(str(mark.get_label()), set()).update(at)
    return found


def rows(s: ca.Sweep, x: str, y: str, which: np.ndarray) -> set[tuple[float, float]]:
    """The same from the columns."""
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
    # a diverged run has no meaningful level; it is at the edge, above its parameter
    crosses = {str(line.get_label()): line for line in ax.lines}
    assert set(crosses) == {"invalid", "unstable"}
    for name, line in crosses.items():
        assert line.get_xdata().tolist() == s["b.k"][status == name].tolist()
        height = ax.transAxes.inverted().transform(line.get_transform().transform(line.get_xydata()))[:, 1]
        assert ((height > 0.95) & (height < 1)).all()
    low, high = ax.get_ylim()
    heard = s["partial"][placed & ((status == "ok") | (status == "clipped"))]
    assert low < heard.min() and heard.max() < high < 2 * heard.max()
    # they are within the visible range
    assert ax.get_xlim()[0] < s["b.k"].min() and s["b.k"].max() < ax.get_xlim()[1]
    silent = ~placed & ((status == "ok") | (status == "clipped"))
    assert ax.get_title("right") == f"runs not shown: {silent.sum()}" and silent.sum() > 0
    legend = ax.get_legend()
    assert legend is not None and [t.get_text() for t in legend.get_texts()] == ["ok", "clipped", "invalid", "unstable"]
    # at the right edge on the other axis, and at their place if both values are known
    ax = plot.sweep(s, "peak", "b.k")
    drawn(ax)
    bad = ["invalid", "unstable"]
    assert [line.get_ydata().tolist() for line in ax.lines] == [s["b.k"][status == name].tolist() for name in bad]
    assert ax.get_xlim()[1] < 3 and ax.get_xlabel() == "peak [full scale = 1]"
    ax = plot.sweep(s, "b.k", "b.m")
    assert [set(zip(*line.get_data())) for line in ax.lines] == [rows(s, "b.k", "b.m", status == name) for name in bad]
    ax = plot.sweep(s, "peak", "t60")
    left = np.isnan(s["t60"]) | (status == "invalid") | (status == "unstable")
    assert not ax.lines and 0 < left.sum() < s.runs and ax.get_title("right") == f"runs not shown: {left.sum()}"
    # without failed runs there is no legend
    good = ca.sweep(ca.examples.string(), {"low.m": ["1 g", "2 g"]}, seconds=0.05)
    assert plot.sweep(good, "low.m", "run_time").get_legend() is None


def test_a_sweep_has_categories_and_colours() -> None:
    s = swept()
    status = s["status"]
    ok = s.ok & np.isfinite(s["partial"])
    # texts along an axis
    ax = plot.sweep(s, "b.k", "status")
    drawn(ax)
    names = [t.get_text() for t in ax.get_yticklabels()]
    assert names == ["clipped", "invalid", "ok", "unstable"]
    assert offsets(ax)["ok"] == {(k, 2.0) for k in s["b.k"][s.ok]}
    assert {float(line.get_ydata()[0]): line.get_label() for line in ax.lines} == {1.0: "invalid", 3.0: "unstable"}
    # a missing text is a category too
    ax = plot.sweep(s, "module", "b.m")
    drawn(ax)
    assert [t.get_text() for t in ax.get_xticklabels()] == ["b", "none"]
    assert {px for px, _ in offsets(ax)["ok"]} == {1.0}
    # numbers as a colour bar
    ax = plot.sweep(s, "b.k", "partial", color="t60")
    drawn(ax)
    assert ax.figure.axes[-1].get_ylabel() == "t60 [s]"
    # runs without that number are drawn too
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
    # texts as a legend
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


#: two keys, one in a contact; a third moves by 0.01 mm, like sensor noise
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
    # modes of forces, each with its duration
    for ax in (above, below):
        begins = {p.get_label(): (p.get_x(), p.get_x() + p.get_width()) for p in ax.patches}
        assert list(begins) == ["off", "ramp", "on"]
        assert begins["off"][0] == 0 and begins["off"][1] == begins["ramp"][0] == hand.force_time[hand.mode == "ramp"][0]
        assert begins["ramp"][1] == begins["on"][0] and begins["on"][1] == ax.get_xlim()[1] == hand.force_time[-1]
    legend = above.get_legend()
    assert legend is not None and [x.get_text() for x in legend.get_texts()] == ["tgr12 1", "tgr12 4", "off", "ramp", "on"]
    # the requested degrees of freedom, on the given axes
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
    t = keys(tmp_path / "t.mcap", 0.005)
    (fault,) = t.faults
    above, below = plot.take(t)
    drawn(above)
    assert [text.get_text() for text in below.texts] == ["VELOCITY"] and below.texts[0].xy[0] == fault.time
    assert [p.get_label() for p in below.patches] == ["off", "ramp", "on", "damp", "fault"]
    assert len({p.get_facecolor() for p in below.patches}) == 5
    for ax in (above, below):
        assert list(ax.lines[-1].get_xdata()) == [fault.time] * 2 and fault.time == ax.patches[-1].get_x()
    # a fault line is not in the legend
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
    # if nothing moves, the first
    held = ca.record(ca.parse(KEYS), tmp_path / "held.mcap", 0.05)
    assert [line.get_label() for line in plot.take(held)[0].lines] == ["tgr12 0"]
