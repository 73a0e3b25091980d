"""`ca.fit` recovers the numbers that made a sound."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import cordis_anima as ca

STRING = """
[STRING]
low = { n = 24, f = "110 Hz", t60 = "2 s", m = "1 g" }
[MAS]
hammer = { m = "12 g", x = "-1 mm", v = "1 m/s" }
[BUT]
strike = { between = ["hammer", "low[5]"], k = "8 kN/m", z = "0.2 N s/m" }
[SOX]
out = { from = "low[3]", gain = 400 }
"""


def test_numbers_are_found_with_their_uncertainty(tmp_path: Path) -> None:
    start = ca.parse(STRING)
    heard = start.replace({"low.f": "113 Hz", "hammer.m": "20 g"}).render(0.5).audio[:, 0]
    seen: list[int] = []
    page = tmp_path / "fit.html"
    found = ca.fit(
        start, heard, ["low.f", "hammer.m"], seconds=0.3, report=page, progress=lambda done, _: seen.append(done)
    )
    f, m = found.numbers["low.f"], found.numbers["hammer.m"]
    assert abs(1200 * math.log2(f.value / 113)) < 0.1 and abs(m.value / 0.02 - 1) < 0.02
    assert f.unit == "Hz" and f.start == 110 and not f.at_end and f.deviation is not None and f.deviation < 0.01
    assert found.renders < 60 and seen and found.stage == "samples"
    assert found.after.levels < found.before.levels
    assert found.beyond is not None and found.beyond.model.samples < found.beyond.sinusoids.samples
    left = found.scene.render(0.5).audio[:, 0] * found.gain - heard
    assert float(np.sum(left**2)) < 1e-4 * float(np.sum(heard**2))
    assert "Residual over time" in page.read_text()


def test_a_sound_that_a_sweep_wrote_is_read(tmp_path: Path) -> None:
    start = ca.parse(STRING)
    ca.sweep(start, {"low.f": ["113 Hz"]}, seconds=0.4, to=tmp_path / "s")
    (sound,) = (tmp_path / "s").rglob("*.flac")
    found = ca.fit(start, sound, ["low.f"])
    assert abs(1200 * math.log2(found.numbers["low.f"].value / 113)) < 0.1 and found.stage == "samples"
    cut = tmp_path / "cut.flac"
    cut.write_bytes(sound.read_bytes()[:5000])
    with pytest.raises(ca.FileError, match="cut short"):
        ca.fit(start, cut, ["low.f"])


def test_a_start_at_another_pitch_is_reported() -> None:
    start = ca.parse(STRING)
    heard = start.replace({"low.f": "330 Hz", "hammer.m": "20 g"}).render(0.5).audio
    found = ca.fit(start, heard, ["low.f"])
    p = found.pitch
    assert p.recording is not None and abs(1200 * math.log2(p.recording / 330)) < 20 and p.far
    assert p.start is not None and abs(1200 * math.log2(p.start / 110)) < 20
    assert found.numbers["low.f"].deviation is None or found.stage == "samples"
    said = " ".join(found.warnings)
    assert "semitones below the recording" in said and "`Scene.replace`" in said and "--" not in said


def test_hints_are_those_of_python() -> None:
    start = ca.parse(STRING)
    heard = start.replace({"low.f": "115 Hz", "hammer.m": "20 g"}).render(0.3).audio
    short = ca.fit(start, heard, ["low.f", "hammer.m"], renders=8)
    ended = ca.fit(start, heard, ["low.f"], ranges={"low.f": (100, "112 Hz")})
    noise = ca.fit(start, np.random.default_rng(1).normal(0, 0.1, 9600), ["low.f"])
    for found, hint in [(short, "`renders`"), (ended, "`ranges`"), (noise, "`Scene.replace`")]:
        said = " ".join(found.warnings)
        assert hint in said and "--" not in said, said
    for vary, ranges in [("low.k", {}), ("low.f", {"low.f": (50, "60 Hz")})]:
        with pytest.raises(ca.UsageError, match="`Scene.replace`"):
            ca.fit(start, heard, [vary], ranges=ranges)


def test_a_bare_number_has_the_unit_of_its_parameter() -> None:
    built = ca.Model().add("CEL", "bar", m=0.002, f=440, t60=1.0, dx0=0.001).add("SOX", "out", from_="bar", gain=500)
    scene = built.compile()
    heard = scene.replace({"bar.f": 445}).render(0.3).audio
    assert ca.fit(scene, heard, ["bar.f"]).numbers["bar.f"].unit == "Hz"


def test_a_sound_on_its_side_is_refused() -> None:
    start = ca.parse(STRING)
    heard = start.render(0.1).audio
    with pytest.raises(ca.UsageError, match=r"transpose it with `.T` to \(frames, channels\)"):
        ca.fit(start, heard.T, ["low.f"])
    with pytest.raises(ca.UsageError, match=r"transpose it with `.T`"):
        start.gradient(["low.f"], cotangent=np.ones((1, 4800)))
    with pytest.raises(ca.UsageError, match=r"transpose it with `.T`"):
        start.gradient(["low.f"], loss=lambda y: (0.0, np.ones((1, 480))), seconds=0.01)


def test_what_cannot_be_fitted_says_why(tmp_path: Path) -> None:
    start = ca.parse(STRING)
    heard = start.render(0.1).audio
    with pytest.raises(ca.UsageError, match="did you mean `low.f`"):
        ca.fit(start, heard, ["lwo.f"])
    with pytest.raises(ca.UsageError, match="starts at 110 Hz"):
        ca.fit(start, heard, ["low.f"], ranges={"low.f": (50, "60 Hz")})
    with pytest.raises(ca.UsageError, match="the range of `low.f` must be two numbers"):
        ca.fit(start, heard, ["low.f"], ranges={"low.f": 120})  # type: ignore[dict-item]
    for renders, what in [(-1, "1 to"), (0, "1 to"), (2.5, "whole number"), (2**40, "1 to")]:
        with pytest.raises(ca.UsageError, match=what):
            ca.fit(start, heard, ["low.f"], renders=renders)  # type: ignore[arg-type]
    for gain, what in [("loud", "write a number$"), ("2 m", "it must not have a unit"), ([1, 2], "write a number$")]:
        with pytest.raises(ca.UsageError, match=what):
            ca.fit(start, heard, ["low.f"], gain=gain)  # type: ignore[arg-type]
    with pytest.raises(ca.UsageError, match="finite"):
        ca.fit(start, np.full(4800, np.nan), ["low.f"])
    with pytest.raises(ca.FailedError, match="silent"):
        ca.fit(start, np.zeros(4800), ["low.f"])
    with pytest.raises(ca.FileError):
        ca.fit(start, tmp_path / "no.wav", ["low.f"])
