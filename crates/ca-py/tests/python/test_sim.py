"""Running scenes: forces, buffers of the caller, live parameters."""

from __future__ import annotations

import os
import pickle
import signal
import threading
import tracemalloc

import numpy as np
import pytest

import cordis_anima as ca


def test_nothing_is_copied(key: ca.Scene) -> None:
    audio, force = np.zeros((64, 2), np.float32), np.zeros((64, 2))
    with key.open() as sim:
        assert sim.ports == ("key", "hand")
        for _ in range(10):
            got = sim.step({"hand": 0.001, "key": 0.001}, out=audio, force=force)
            assert got.audio is audio and got.force is force
    assert np.abs(audio).max() > 0 and np.abs(force).max() > 0
    # the samples are written in the caller's array
    at = audio.__array_interface__["data"][0]
    audio[:] = 7
    assert key.open().step(out=audio).audio.__array_interface__["data"][0] == at and not (audio == 7).any()
    # a render is moved, not copied: NumPy, which reports its own allocations, has allocated nothing of that size
    tracemalloc.start()
    r = key.render(1.0, probes=["low[*]"])
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert r.audio.nbytes == 384_000 and r.probes["low[*]"].nbytes == 15_360_000
    assert most < 16_000_000
    tracemalloc.start()
    key.render(1.0)
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert most < 100_000
    # blocks of a larger array are written in place
    whole = np.zeros((1000, 2), np.float32)
    with key.open() as sim:
        for i in range(0, 1000, 100):
            sim.step({"hand": 0.001}, out=whole[i : i + 100])
    with key.open(block=1000) as sim:
        assert np.array_equal(whole, sim.step({"hand": 0.001}).audio)


def test_forces_are_those_on_the_ports(key: ca.Scene) -> None:
    n = 3200
    hand = 1e-3 * np.sin(np.arange(n) / 80)
    r = key.render(n / key.sr, gesture={"hand": hand, "key": 0.001}, probes=["hold", "strike"])
    with key.open() as sim:
        force = sim.step({"hand": hand, "key": 0.001}).force
    # a link's force pulls its first end up
    assert np.abs(r.probes["hold"]).max() > 0.01
    assert np.allclose(force[:, 1], r.probes["hold"], rtol=0, atol=1e-12)
    # a device gets the mean over a frame
    frames = r.probes["strike"].reshape(-1, 16)
    reported = force[15::16, 0]
    assert np.abs(reported).max() > 0.01
    assert np.abs(reported[20:] - frames.mean(axis=1)[20:]).max() < 0.2 * np.abs(reported).max()


def test_live_parameters_are_a_mapping(key: ca.Scene) -> None:
    grip = key.params["grip"]
    assert grip == ca.Param("grip", 2000.0, 100.0, 9000.0, "N/m", "how hard it holds")
    assert list(key.params) == ["grip"] and "how hard" in repr(key.params)
    sim = key.open()
    assert dict(sim.params) == {"grip": 2000.0}
    sim.params["grip"] = 5000
    assert sim.params["grip"] == 5000
    sim.set("grip", "6 kN/m", over="1 ms")
    assert sim.params["grip"] == 6000
    for wrong in [10, 1e9, float("nan")]:
        with pytest.raises(ca.UsageError):
            sim.params["grip"] = wrong
    with pytest.raises(ca.UsageError):
        sim.params["grap"] = 1
    with pytest.raises(KeyError):
        sim.params["grap"]
    with pytest.raises(ca.UsageError):
        del sim.params["grip"]
    # the change is audible
    a, b = key.open(), key.open()
    b.params["grip"] = 9000
    loud = [s.step({"key": 0.002}, 4000).audio for s in (a, b)]
    assert not np.array_equal(*loud)


def test_what_a_block_cannot_be(key: ca.Scene) -> None:
    sim = key.open()
    before = sim.time
    for inputs, kwargs in [
        ({"nothing": 1.0}, {}),
        ({"hand": np.zeros((3, 3))}, {}),
        ({"hand": np.zeros(3), "push": np.zeros(4)}, {}),
        (np.zeros(3), {}),
        (np.zeros((4, 2)), {}),
        (np.zeros((4, 3), complex), {}),
        ({"hand": 1j}, {}),
        ({"hand": None}, {}),
        ({"hand": "1 mm"}, {}),
        (None, {"out": np.zeros((8, 3), np.float32)}),
        (None, {"force": np.zeros((8, 9))}),
        (None, {"n": -1}),
        (None, {"out": np.zeros((8, 2), np.float16)}),
        (None, {"out": np.zeros(16, np.float32)}),
        (None, {"out": np.zeros((2, 8), np.float32).T[::-1]}),
        (None, {"out": np.lib.stride_tricks.as_strided(np.zeros(8, np.float32), (8, 2), (0, 4))}),
        (None, {"out": np.zeros(8, dtype=[("a", "i1"), ("x", np.float32, (2,))])["x"]}),
        (None, {"out": np.frombuffer(bytes(64), np.float32).reshape(8, 2)}),
        (None, {"out": np.zeros((8, 2), ">f4")}),
    ]:
        with pytest.raises(ca.UsageError):
            sim.step(inputs, **kwargs)  # type: ignore[arg-type]
    for over in [-1, float("nan"), float("inf"), 1e9, "1 m", "soon"]:
        with pytest.raises(ca.UsageError):
            sim.set("grip", 3000, over=over)
    for value in ["3 kg", "stiff", None, 1j]:
        with pytest.raises(ca.UsageError, match="`grip`"):
            sim.set("grip", value)  # type: ignore[arg-type]
    with pytest.raises(ca.UsageError):
        key.open(block=0)
    with pytest.raises(TypeError, match="pickle the scene"):
        pickle.dumps(sim)
    assert sim.time == before
    # bad inputs never raise: non-finite values are held, counted and reported
    sim.step({"hand": np.array([0.001, np.nan, np.inf, np.nan])})
    assert sim.status == "refused" and sim._core.counts[2] == 3
    # only once: the last finite value stays; empty arrays do nothing
    sim.step({"hand": np.zeros(0)})
    sim.step(np.zeros((0, 3)))
    sim.step(n=100)
    assert sim._core.counts[2] == 3
    # columns of a larger array, and a part of each row, are written in place
    rows = np.zeros((8, 5), np.float32)
    sim.step({"hand": 0.001}, out=rows[:, 1:3])
    assert rows[:, 1:3].any() and not rows[:, 0].any() and not rows[:, 3:].any()
    sim.reset()
    assert sim.time == 0 and sim.status == "ok"


def test_blocks_without_end_and_ledgers(key: ca.Scene) -> None:
    sim = key.open(block=160, energy=True)
    sim.step({"hand": 0.001})
    for k, block in enumerate(sim):
        assert block.audio.shape == (160, 2)
        if k == 9:
            break
    assert sim.time == pytest.approx(11 * 160 / key.sr)
    ledger = sim.energy
    assert ledger is not None and abs(ledger.residual) < 1e-9 * ledger.peak
    assert set(ledger.work_by) == {"key", "hand", "push"}
    assert key.open().energy is None


def test_time_is_that_of_the_scene() -> None:
    text = "[rate]\noversample = 4\n[CEL]\nb = { m = '1 g', f = '1 kHz', dx0 = '1 mm' }\n[SOX]\no = { from = 'b' }\n"
    scene = ca.parse(text)
    sim = scene.open(block=480)
    audio = sim.step().audio
    assert sim.time == 0.01
    assert np.array_equal(audio, scene.render(0.01).audio) and audio.any()
    odd = ca.parse(text, rate=3000.5)
    assert odd.sr == odd.render(0.1).sr == 3000 and odd.rate == 3000.5 and odd.render(0.1).seconds == 300 / 3000.5
    # the run time is above 0
    deaf = ca.parse("[CEL]\nb = { m = '1 g', f = '1 kHz', dx0 = '1 mm' }\n[SOX]\no = { from = 'b' }\n").render(0.1)
    assert deaf.rtf > 0


def test_control_c_ends_a_long_block(key: ca.Scene) -> None:
    sim = key.open()
    timer = threading.Timer(0.2, lambda: os.kill(os.getpid(), signal.SIGINT))
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        sim.step(n=20_000_000)
    timer.join()
    assert 0 < sim.time < 20_000_000 / 48000


def test_threads_wait_for_each_other(key: ca.Scene) -> None:
    sim, seen = key.open(), []
    other = threading.Thread(target=lambda: sim.step(n=100_000))
    other.start()
    while other.is_alive():
        seen.append((sim.time, sim.status))
    other.join()
    assert sim.time == 100_000 / 48000 and all(t in (0, sim.time) for t, _ in seen)


def test_a_snapshot_goes_on_anywhere(key: ca.Scene) -> None:
    with key.open(block=400, energy=True, probes=["strike", "low[*]"]) as sim:
        sim.set("grip", 5000, over="20 ms")
        sim.step({"hand": 0.001, "key": 0.0005})
        there = sim.state()
        last = sim.step(n=800)
        energy = sim.energy
    assert there == pickle.loads(pickle.dumps(there)) and hash(there) == hash(pickle.loads(pickle.dumps(there)))
    assert there.time == pytest.approx(400 / key.sr) and len(repr(there)) < 60
    again = pickle.loads(pickle.dumps(key)).open(energy=True, probes=["strike", "low[*]"])
    again.step({"hand": 0.1}, n=77)
    again.restore(pickle.loads(pickle.dumps(there)))
    assert again.time == there.time and again.params["grip"] == 5000 and again.state() == there
    # inputs that are not given keep their values from the snapshot
    block = again.step(n=800)
    assert np.array_equal(block.audio, last.audio) and np.array_equal(block.force, last.force)
    for probe in ["strike", "low[*]"]:
        assert np.array_equal(block.probes[probe], last.probes[probe]) and np.abs(block.probes[probe]).max() > 0
    assert again.energy is not None and energy is not None
    assert again.energy.work == energy.work and again.energy.stored == energy.stored
    # other scenes refuse it and do not change
    for other in [key.open(), key.replace({"low.m": "2 g"}).open(energy=True, probes=["strike", "low[*]"])]:
        before = other.state()
        with pytest.raises(ca.UsageError, match="another scene"):
            other.restore(there)
        assert other.state() == before
    n = len(there.data)
    places = [*range(n - 80, n), *range(0, n, 997)]
    flipped = [there.data[:i] + bytes([there.data[i] ^ 1]) + there.data[i + 1 :] for i in places]
    for data in [b"", b"nothing", there.data[:-1], there.data[:100], there.data + b"0", *flipped]:
        with pytest.raises(ca.UsageError):
            again.restore(ca.Snapshot(0.0, data))
    with pytest.raises(ca.UsageError, match="Sim.state"):
        again.restore(there.data)  # type: ignore[arg-type]


def test_probes_of_a_stream_are_those_of_a_render(key: ca.Scene) -> None:
    asked = ["strike", "low[3]", "low[*]"]
    r = key.render(0.05, gesture={"key": 0.001, "hand": 0.0}, probes=asked)
    n = len(r.audio)
    with key.open(block=n // 3, probes=asked) as sim:
        blocks = [sim.step({"key": 0.001, "hand": 0.0}, n=m) for m in (n // 3, n // 3, n - 2 * (n // 3))]
    for probe in asked:
        whole = np.concatenate([b.probes[probe] for b in blocks])
        assert whole.shape == r.probes[probe].shape
        # a device port takes its input at the first sample of a frame; a render reads a gesture at the end of the frame
        assert np.array_equal(whole, r.probes[probe]), probe
    audio, force = key.open().step()
    assert key.open().step().probes == {} and audio.shape[1] == force.shape[1] == 2
    with pytest.raises(ca.ModelError):
        key.open(probes=["nothing"])
    assert list(key.open(probes="strike").step(n=4).probes) == ["strike"]
