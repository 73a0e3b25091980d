"""Sweeps give the same results with any executor, and failed runs are rows."""

import struct
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from sweeps import VARY, same, spawned, string

import cordis_anima as ca


def test_any_executor_any_order_finds_the_same(dask):
    from joblib.externals.loky import get_reusable_executor

    one = ca.sweep(string(), VARY, 40, seed=3, seconds=0.05, audio=True, executor=ThreadPoolExecutor(1))
    assert one.runs == 40 and one.counts == {"ok": 40}
    assert len(one.audio) == 40 and one.audio[0].shape == (2400, 1)

    class Backwards(ThreadPoolExecutor):
        """Runs the latest submitted task first."""

        held = []

        def submit(self, *work):
            from concurrent.futures import Future

            self.held.append((Future(), work))
            if len(self.held) == 6:
                for future, (f, *args) in reversed(self.held):
                    future.set_result(f(*args))
            return self.held[-1][0]

    with spawned() as processes:
        for executor, batch in [
            (None, None),
            (None, 1),
            (processes, 7),
            (get_reusable_executor(2), 9),
            (dask.get_executor(), 11),
            (Backwards(1), 7),
        ]:
            other = ca.sweep(string(), VARY, 40, seed=3, seconds=0.05, audio=True, executor=executor, batch=batch)
            same(one, other)
            assert all(np.array_equal(a, b) for a, b in zip(one.audio, other.audio))
    other = ca.sweep(string(), VARY, 40, seed=4, seconds=0.05)
    assert not np.array_equal(one["low.k"], other["low.k"])


def test_draws_are_those_of_the_document():
    from blake3 import blake3

    scene = string()
    s = ca.sweep(scene, VARY, 12, seed=9, seconds=0.01)
    first = lambda parts: struct.unpack("<Q", blake3(b"".join(parts)).digest()[:8])[0]
    assert s.scene == scene.hash
    for i in range(12):
        seed = first([bytes.fromhex(scene.hash), struct.pack("<Q", 9), struct.pack("<Q", i)]) >> 1
        assert s["seed"][i] == seed
        u = {name: (first([struct.pack("<Q", seed), name.encode()]) >> 11) * 2.0**-53 for name in VARY}
        assert s["low.k"][i] == pytest.approx(1e3 * 9 ** u["low.k"], rel=1e-14)
        assert s["low.m"][i] == (0.001 if u["low.m"] < 0.5 else 0.002)
        assert s["low.z"][i] == u["low.z"] * 1e-3
    # another axis leaves the values of the others unchanged
    more = ca.sweep(scene, {**VARY, "low.n": [20, 40]}, 12, seed=9, seconds=0.01)
    assert all(np.array_equal(more[name], s[name]) for name in VARY)


def test_a_row_is_what_a_render_says():
    scene = string()
    s = ca.sweep(scene, {"low.k": [1e3, 5e3]}, seconds=0.3, energy=True, audio=True, measure=True)
    for i, k in enumerate(s["low.k"]):
        r = scene.replace({"low.k": k}).render(0.3, energy=True)
        assert np.array_equal(s.audio[i], r.audio) and s["scene"][i] == scene.replace({"low.k": k}).hash
        assert s["peak"][i] == r.peak.max() and s["frames"][i] == len(r.audio)
        assert s["rms"][i] == pytest.approx(np.sqrt(np.mean(r.audio.astype(float) ** 2)), rel=1e-12)
        assert s["residual"][i] == pytest.approx(abs(r.energy.residual) / r.energy.peak)
        spectrum = np.abs(np.fft.rfft(r.audio[:, 0] * np.hanning(len(r.audio)), 1 << 17))
        assert s["partial"][i] == pytest.approx(np.argmax(spectrum) * s.rate / (1 << 17), abs=1.5)


def test_a_bad_run_is_a_row():
    s = ca.sweep(string(), {"low.k": [1e3, -1.0, 1e9, "a lot"]}, seconds=0.1)
    assert s["status"].tolist() == ["ok", "invalid", "unstable", "invalid"]
    assert s.counts == {"invalid": 2, "ok": 1, "unstable": 1} and s.ok.tolist() == [True, False, False, False]
    assert s["failed"][2] < 0.1 and "low" in s["module"][2] and "diverged" in s["message"][2]
    assert s["message"][1].startswith("E") and np.isnan(s["failed"][0]) and s["module"][0] is None
    # values that are not all numbers make a column of texts
    assert s["low.k"].tolist() == ["1000", "-1", "1000000000", "a lot"]


def test_gestures_go_along_to_other_processes(tmp_path):
    key = ca.load("hammered_string")
    (tmp_path / "blow.csv").write_text("time,key\n0,-0.008\n0.01,0\n0.1,-0.008\n")
    samples = 0.008 * (np.hanning(1200) - 1)
    for gesture in [{"key": [(0, -0.008), (0.01, 0), (0.1, -0.008)]}, {"key": samples}, str(tmp_path / "blow.csv")]:
        here = ca.sweep(key, {"hammer.m": ["4 g", "8 g"]}, seconds=0.2, gesture=gesture)
        with spawned(1) as processes:
            same(here, ca.sweep(key, {"hammer.m": ["4 g", "8 g"]}, seconds=0.2, gesture=gesture, executor=processes, batch=1))
        assert np.all(here["peak"] > 0)
        # without it the built-in gesture plays
        assert not np.array_equal(here["peak"], ca.sweep(key, {"hammer.m": ["4 g", "8 g"]}, seconds=0.2)["peak"])
