"""Renders: results, failures, and other threads meanwhile."""

from __future__ import annotations

import gc
import os
import resource
import signal
import threading
import time
from pathlib import Path

import librosa
import numpy as np
import pytest
import scipy.signal
import soundfile

import cordis_anima as ca


def test_a_result_has_all_of_it(key: ca.Scene) -> None:
    r = key.render(0.5, gesture={"key": 0.001}, probes=["strike", "low[3]"], energy=True)
    assert (r.audio.shape, r.audio.dtype, r.sr, r.channels) == ((24000, 2), np.float32, 48000, ("left", "right"))
    assert r.status == "ok" and r.message == "" and r.failed is None and r.seconds == 0.5 and r.rtf > 0
    assert list(r.probes) == ["strike", "low[3]"] and r.columns["strike"] == ("strike",)
    assert dict(r.units) == {"strike": "N", "low[3]": "m"}
    assert r.energy is not None
    e = r.energy
    assert abs(e.start + e.work - e.lost + e.made + e.changed + e.residual - e.stored) <= 1e-9 * e.peak
    assert abs(e.residual) < 1e-9 * e.peak and e.lost_by["hold"] > 0
    assert "ok" in repr(r)
    # the output is the probe times the gain
    assert np.array_equal((100 * r.probes["low[3]"]).astype(np.float32), r.audio[:, 0])


def test_others_take_it_as_it_is(tmp_path: Path) -> None:
    r = ca.examples.string().render(2.0)
    soundfile.write(tmp_path / "a.wav", r.audio, r.sr, subtype="FLOAT")
    back, sr = soundfile.read(tmp_path / "a.wav", dtype="float32", always_2d=True)
    assert sr == r.sr and np.array_equal(back, r.audio)
    mel = librosa.feature.melspectrogram(y=r.audio.T[0], sr=r.sr)
    assert mel.shape[0] == 128 and mel.max() > 0
    # the pitch is the one of the model
    f = librosa.yin(r.audio.T[0][24000:72000], fmin=60, fmax=400, sr=r.sr)
    assert abs(1200 * np.log2(np.median(f) / 110)) < 10
    freqs, power = scipy.signal.periodogram(r.audio[:, 0], r.sr, window="hann", nfft=1 << 20)
    peaks = freqs[(freqs > 100) & (freqs < 120)][np.argmax(power[(freqs > 100) & (freqs < 120)])]
    assert abs(1200 * np.log2(peaks / 110)) < 5


def test_what_goes_wrong_is_a_status() -> None:
    loud = ca.examples.string().replace({"out.gain": 1e6}).render(0.2)
    assert loud.status == "clipped" and loud.clipped > 0 and np.abs(loud.audio).max() == 1
    assert loud.peak.max() > 1 and "multiply the gain" in loud.message
    # the suggested gain helps
    for gain in [1.5, 6.1, 123.4]:
        scene = ca.parse(f"[MAS]\nm = {{ m = 1, dx0 = 1 }}\n[SOX]\no = {{ from = 'm', gain = {gain} }}\n")
        by = float(scene.render(0.01).message.split("gain by ")[1].split(" ")[0])
        assert scene.replace({"o.gain": gain * by}).render(0.01).status == "ok" and gain * by > 0.99
    text = "[SOL]\nw = {}\n[MAS]\nb = { m = '1 g', dx0 = '1 mm' }\n[REF]\nr = { between = ['w', 'b'], k = '1e9 N/m' }\n[SOX]\no = { from = 'b' }\n"
    diverged = ca.parse(text)
    assert diverged.certificate.level == "unstable" and [d.code for d in diverged.diagnostics] == ["W103"]
    r = diverged.render(0.2, energy=True)
    assert r.status == "unstable" and r.failed is not None and r.failed[1] == "b" and "`b`" in r.message
    assert np.isfinite(r.audio).all() and np.abs(r.audio[-100:]).max() == 0
    with pytest.raises(ca.UnstableError) as e:
        diverged.render(0.2, on_unstable="raise")
    assert e.value.module == "b" and 0 < e.value.time < 0.2 and isinstance(e.value, ArithmeticError)


def test_gestures_of_every_form(key: ca.Scene, tmp_path: Path) -> None:
    t = np.arange(4800) / 48000
    x = (1e-3 * np.sin(40 * t)).astype(np.float32).astype(np.float64)
    points = ca.Points(t, x)
    pairs = list(zip(t.tolist(), x.tolist()))
    np.save(tmp_path / "hand.npy", np.array(list(zip(t, x)), dtype=[("time", "f8"), ("hand", "f8")]))
    soundfile.write(tmp_path / "hand.wav", x, 48000, subtype="FLOAT")
    want = key.render(0.1, gesture={"hand": x}).audio
    assert np.abs(want).max() > 0
    np.save(tmp_path / "plain.npy", x)
    files = [tmp_path / "hand.wav", (tmp_path / "plain.npy", 48000)]
    for form in [points, pairs, [list(p) for p in pairs], (x, 48000), (x.tolist(), 48000.0), np.repeat(x, 2)[::2], *files]:
        assert np.array_equal(key.render(0.1, gesture={"hand": form}).audio, want)
    assert np.array_equal(key.render(0.1, gesture=tmp_path / "hand.npy").audio, want)
    # an error in a gesture is a usage error unless a file is involved
    for wrong, what in [
        ({"hend": 1}, "`hend` is not a port or live parameter"),
        ({"hand": [(0, 0), (0.1, float("nan"))]}, "point 1"),
        ({"hand": [(0, 0), (-0.1, 1)]}, "point 1"),
        ({"hand": (x, -48000.0)}, "rate"),
        ({"hand": (x, "48 kg")}, "not in Hz"),
        ({"hand": []}, "hand"),
        ({"hand": np.zeros((0, 2))}, "hand"),
        # times and values, or two channels of a sound
        ({"hand": np.stack([t, x], axis=1)}, r"may be breakpoints or two channels: write `Points\(a\[:, 0\], a\[:, 1\]\)`"),
        ({"hand": x[:, None]}, r"samples must have the shape \(n,\), e.g. `a.ravel\(\)`"),
        ({"hand": np.zeros((2, 4800))}, r"has the shape \(2, 4800\)"),
        ({"hand": ca.Points(t, x[:-1])}, r"times \(4800,\) and values \(4799,\)"),
        ({"hand": x * 1j}, "`hand` contains complex numbers"),
        ({"hand": (x * 1j, 48000)}, "`hand` contains complex numbers"),
        ({"hand": 1j}, "`hand` contains complex numbers"),
        ({"hand": [(0, 0j), (1, 1)]}, "`hand` contains complex numbers"),
        ({"hand": None}, "`hand` contains objects that are not numbers"),
        ({"hand": ["0", "1"]}, "`hand` contains text"),
        ({"hand": [[0, 0], [1]]}, "different lengths"),
    ]:
        with pytest.raises(ca.UsageError, match=what) as e:
            key.render(0.1, gesture=wrong)  # type: ignore[arg-type]
        assert not isinstance(e.value, OSError), what
    with pytest.raises(ca.FileError) as e:
        key.render(0.1, gesture=tmp_path / "nothing.csv")
    assert isinstance(e.value, OSError) and e.value.file.endswith("nothing.csv")
    for wrong in [tmp_path / "nothing.csv", tmp_path / "plain.npy"]:
        with pytest.raises(ca.FileError):
            key.render(0.1, gesture={"hand": wrong})
    for constant in [0.001, np.float32(0.001), np.array(0.001)]:
        assert key.render(0.1, gesture={"hand": constant}).audio.any()


def test_a_model_that_nobody_can_hear_is_mute(key: ca.Scene) -> None:
    silent = ca.parse("[CEL]\nbar = { m = '2 g', f = '440 Hz', t60 = '1 s', dx0 = '1 mm' }\n")
    r = silent.render(0.1)
    assert r.audio.shape == (4800, 0) and r.status == "mute" and "has no output" in r.message and "mute" in repr(r)
    heard = silent.render(0.1, probes=["bar"])
    assert heard.status == "ok" and heard.probes["bar"].any() and silent.rollout("bar", 0.1).status == "ok"
    assert list(ca.batch(silent, {"bar.m": ["1 g", "2 g"]}, 0.1).status) == ["mute", "mute"]
    assert list(ca.batch(silent, {"bar.m": ["1 g"]}, 0.1, probes=["bar"]).status) == ["ok"]
    assert ca.sweep(silent, {"bar.m": ["1 g", "2 g"]}, seconds=0.1).counts == {"mute": 2}


def test_a_scheme_that_makes_energy_is_not_ok() -> None:
    ball = ca.parse(
        "[SOL]\nl = { x = -0.01 }\nr = { x = 0.0137 }\n[MAS]\nb = { m = 1e-3, v = 0.731 }\n"
        "[BUT]\nc = { between = ['l', 'b'], k = 1e3, z = 60 }\nd = { between = ['b', 'r'], k = 1e3, z = 60 }\n"
        "[SOX]\no = { from = 'b', gain = 10 }\n"
    )
    r = ball.render(2, energy=True)
    assert r.status == "gained" and "more than the" in r.message and r.energy is not None and r.energy.made > 1e-4
    assert ball.render(2).status == "ok"
    assert ca.sweep(ball, {"b.m": ["1 g", "1.01 g"]}, seconds=2, energy=True).counts.keys() == {"gained"}


def test_what_is_shown_of_results_is_short(key: ca.Scene) -> None:
    r = key.render(0.2, gesture={"key": 0.001}, probes=["low[*]"], energy=True)
    t = key.tangents(["low.f"], 0.2, gesture={"key": 0.001})
    g = key.gradient(["low.f"], cotangent=np.ones((9600, 2)), gesture={"key": 0.001})
    e = key.energy_tangents(["low.f"], 0.1, gesture={"key": 0.001}, instants=400)
    points = ca.Points(np.arange(9999.0), np.zeros(9999))
    for shown in [r, t, g, e, points, key.modes(), key.linear(), key.modes().derivative(["low.f"]), key.rollout("low[*]", 0.1)]:
        assert len(repr(shown)) < 400 and repr(shown).startswith("<"), type(shown)
    assert repr(t) == "<Tangents: 9600 frames x 2 at 48000 Hz by low.f>"


def test_other_threads_run_meanwhile(key: ca.Scene) -> None:
    counted = [0]
    done = threading.Event()

    def count() -> None:
        while not done.is_set():
            counted[0] += 1

    other = threading.Thread(target=count)
    reported: list[tuple[int, int]] = []
    at: list[tuple[float, int]] = []

    def progress(n: int, of: int) -> None:
        reported.append((n, of))
        at.append((time.perf_counter(), counted[0]))

    other.start()
    # long enough for several reports on any machine
    r = key.render(90.0, progress=progress)
    # how far it counts while this thread is idle for the same time
    begin = counted[0]
    time.sleep(at[-1][0] - at[0][0])
    free = counted[0] - begin
    done.set()
    other.join()
    assert reported[-1] == (len(r.audio), len(r.audio)) and [n for n, _ in reported] == sorted(n for n, _ in reported)
    # a render that held the lock would let it count only between callbacks; its share of a core depends on the machine
    assert len(reported) > 3 and at[-1][1] - at[0][1] > 0.02 * free


def test_control_c_and_a_callback_end_it(key: ca.Scene) -> None:
    timer = threading.Timer(0.2, lambda: os.kill(os.getpid(), signal.SIGINT))
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        key.render(100_000.0 / 48)
    timer.join()

    def enough(done: int, of: int) -> None:
        raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        key.render(60.0, progress=enough)
    with pytest.raises(LookupError, match="enough"):
        ca.examples.string().accuracy(0.02, times=[1], reference=4, progress=enough)


def test_nothing_is_lost_over_many_renders(key: ca.Scene) -> None:
    times = 100_000 if os.environ.get("CA_LONG") else 4000
    gesture = {"key": 0.001}

    def some(n: int) -> int:
        for _ in range(n):
            key.render(0.001, gesture=gesture)
        gc.collect()
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss

    first = some(times // 4)
    # a leak of one sample array (100 frames, 400 bytes) per render would be detected
    assert some(times) - first < max(1000, times * 100 // 1024)


def test_pages_of_notebooks(key: ca.Scene) -> None:
    for page in [key._repr_html_(), key.render(0.1, gesture={"key": 0.001})._repr_html_()]:
        assert page.startswith("<div>") and page.endswith("</div>")
        assert "http" not in page and "<script" not in page
    assert "data:audio/wav;base64," in page and "<svg" in page
    assert "how hard it holds" in key._repr_html_()
