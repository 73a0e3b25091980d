"""Running scenes: forces, buffers of the caller, live parameters."""

from __future__ import annotations

import pickle

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
    # a render is moved, not copied: it owns its memory or looks at what does, and is written by nobody else
    r = key.render(0.1)
    base = r.audio if r.audio.base is None else r.audio.base
    assert base.__array_interface__["data"][0] == r.audio.__array_interface__["data"][0]
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
    told = force[15::16, 0]
    assert np.abs(told).max() > 0.01
    assert np.abs(told[20:] - frames.mean(axis=1)[20:]).max() < 0.2 * np.abs(told).max()


def test_live_parameters_are_a_mapping(key: ca.Scene) -> None:
    grip = key.params["grip"]
    assert grip == ca.Param("grip", 2000.0, 100.0, 9000.0, "N/m", "how hard it holds")
    assert list(key.params) == ["grip"] and "how hard" in repr(key.params)
    sim = key.open()
    assert dict(sim.params) == {"grip": 2000.0}
    sim.params["grip"] = 5000
    assert sim.params["grip"] == 5000
    for wrong in [10, 1e9, float("nan")]:
        with pytest.raises(ca.UsageError):
            sim.params["grip"] = wrong
    with pytest.raises(ca.UsageError):
        sim.params["grap"] = 1
    with pytest.raises(KeyError):
        sim.params["grap"]
    with pytest.raises(ca.UsageError):
        del sim.params["grip"]
    # it is heard
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
        (None, {"out": np.zeros((8, 3), np.float32)}),
        (None, {"force": np.zeros((8, 9))}),
    ]:
        with pytest.raises(ca.UsageError):
            sim.step(inputs, **kwargs)  # type: ignore[arg-type]
    with pytest.raises(TypeError):
        sim.step(out=np.zeros((8, 2), np.float64))  # type: ignore[arg-type]
    with pytest.raises(ca.UsageError):
        key.open(block=0)
    with pytest.raises(TypeError, match="pickle the scene"):
        pickle.dumps(sim)
    assert sim.time == before
    # a signal is never an error: what has no value is held, counted and told
    sim.step({"hand": np.array([0.001, np.nan, np.inf, 0.001])})
    assert sim.status == "refused"
    sim.reset()
    assert sim.time == 0 and sim.status == "ok"


def test_blocks_without_end_and_books(key: ca.Scene) -> None:
    sim = key.open(block=160, energy=True)
    sim.step({"hand": 0.001})
    for k, block in enumerate(sim):
        assert block.audio.shape == (160, 2)
        if k == 9:
            break
    assert sim.time == pytest.approx(11 * 160 / key.sr)
    book = sim.energy
    assert book is not None and abs(book.residual) < 1e-9 * book.peak
    assert set(book.work_by) == {"key", "hand", "push"}
    assert sim.positions.dtype == np.float64 and np.abs(sim.positions).max() > 0
    assert key.open().energy is None
