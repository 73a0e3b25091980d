"""Limits of sweeps: memory, time, killed workers, invalid requests."""

import itertools
import os
import signal
import sys
import threading
import types
import warnings
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from sweeps import LONG, VARY, string

import cordis_anima as ca
from cordis_anima import plot


class Patient(ThreadPoolExecutor):
    """Counts submitted tasks, and those waiting or running."""

    def __init__(self, n):
        super().__init__(n)
        self.handed, self.most, self.there, self.lock = 0, 0, 0, threading.Lock()

    def submit(self, f, /, *args):
        with self.lock:
            self.handed, self.there = self.handed + 1, self.there + 1
            self.most = max(self.most, self.there)
        future = super().submit(f, *args)
        future.add_done_callback(self.ended)
        return future

    def ended(self, _):
        with self.lock:
            self.there -= 1


@pytest.mark.parametrize("to", [None, "folder", "store.zarr"])
def test_tasks_are_made_when_there_is_room(tmp_path, to):
    to = None if to is None else tmp_path / to
    how = {"batch": 1} if to is None else {"chunk": 1, "audio": False if to.suffix else "none"}
    one = Patient(1)
    s = ca.sweep(string(), {"low.m": ca.Range("1 g", "2 g")}, 100, seconds=1e-3, executor=one, to=to, **how)
    assert s.counts == {"ok": 100} and s["index"].tolist() == list(range(100))
    assert one.handed >= 99 and one.most <= 64, "however many runs there are"


def test_what_is_stopped_was_never_made():
    one = Patient(1)

    def enough(done, of):
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        ca.sweep(string(), {"low.m": ca.Range("1 g", "2 g")}, 1_000_000, seconds=1e-3, executor=one, batch=1, progress=enough)
    assert one.handed < 200


@pytest.mark.parametrize("to", [None, "folder", "store.zarr"])
def test_what_does_not_fit_is_refused_before_it_begins(tmp_path, to, monkeypatch):
    one = Patient(1)
    ask = {"seconds": 1e-3, "to": None if to is None else tmp_path / to, "executor": one}
    vary = {"low.m": ca.Range("1 g", "2 g")}
    with pytest.raises(ca.UsageError, match=r"^1000000000000 runs: their rows take \d+ TB, .* (days|years); use fewer runs"):
        ca.sweep(string(), vary, 10**12, chunk=1_000_000, **ask)
    with pytest.raises(ca.UsageError, match="TB"):
        ca.sweep(string(), {"low.m": ca.Range(1, 2, steps=10**6), "low.k": ca.Range(1, 2, steps=10**6)}, chunk=10**6, **ask)
    assert one.handed == 0 and not list(tmp_path.iterdir())
    # whether it fits depends on the machine, and on sounds if they are kept
    monkeypatch.setattr("cordis_anima._sweeps.work.memory", lambda: 10_000_000)
    assert ca.sweep(string(), vary, 100, seconds=0.1).runs == 100
    if to is None:
        with pytest.raises(ca.UsageError, match="rows and sounds take"):
            ca.sweep(string(), vary, 1000, seconds=0.1, audio=True)


def test_what_takes_long_says_so_first(monkeypatch, tmp_path):
    vary = {"low.m": ca.Range("1 g", "2 g")}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ca.sweep(string(), vary, 20, seconds=1e-3)
    monkeypatch.setattr("cordis_anima._sweeps.work._LONG", 0.0)
    monkeypatch.setattr("cordis_anima._sweeps.work._WATCHED", 0.0)
    # in memory before anything is submitted, otherwise once one or more chunks are done; in any case once
    for to, left in [(None, "19"), (tmp_path / "a", "(15|10|5)")]:
        with pytest.warns(UserWarning, match=rf"^{left} runs are left, which take about .* Ctrl-C") as reported:
            ca.sweep(string(), vary, 20, seconds=1e-3, to=to, chunk=5, executor=ThreadPoolExecutor(1))
        assert len(reported) == 1 and reported[0].filename == __file__


def test_pitch_and_decay_are_measured_where_they_are_asked_for():
    vary = {"low.m": ["1 g", "2 g"]}
    plain, measured = (ca.sweep(string(), vary, seconds=0.1, **ask) for ask in ({}, {"measure": True}))
    assert set(measured) - set(plain) == {"partial", "t60"} and np.isfinite(measured["partial"]).all()
    with pytest.raises(KeyError, match="measure=True"):
        plain["partial"]
    with pytest.raises(ca.UsageError, match="measure=True"):
        plot.sweep(plain, "low.m", "t60")


def test_a_store_has_chunks_that_are_worth_a_task(tmp_path):
    import zarr

    for runs, seconds, audio, chunk in [(450, 0.01, False, 57), (40, 0.01, True, 5), (5, 0.01, True, 1), (1000, 1e-3, False, 100)]:
        store = str(tmp_path / f"{runs}.zarr")
        ca.sweep(string(), {"low.m": ca.Range("1 g", "2 g")}, runs, seconds=seconds, to=store, audio=audio)
        assert zarr.open_group(store, mode="r")["peak"].chunks == (chunk,), runs
        # the same call continues it
        seen = []
        ca.sweep(string(), {"low.m": ca.Range("1 g", "2 g")}, runs, seconds=seconds, to=store, audio=audio, progress=seen.append)
        assert seen == []
    # sounds of a chunk take no more than 64 MB: a minute in one channel is 11.52 MB
    from cordis_anima._sweeps import zarr as _zarr

    sweep = types.SimpleNamespace(channels=1, runs=1000)
    assert _zarr.chunk(sweep, {"frames": np.array([2_880_000])}, True) == 5
    assert _zarr.chunk(sweep, {"frames": np.array([2_880_000])}, False) == 100


def test_a_killed_worker_is_not_missed(dask, tmp_path):
    runs = 10_000 if LONG else 600
    scene = string()
    ask = {"seed": 7, "seconds": 0.02, "audio": "none", "chunk": 20}
    killed = []

    def kill(done, of):
        if done >= of // 4 and not killed:
            address, pid = next(iter(dask.run(os.getpid).items()))
            os.kill(pid, signal.SIGKILL)
            killed.append(pid)

    s = ca.sweep(scene, VARY, runs, to=tmp_path / "dask", executor=dask.get_executor(), progress=kill, **ask)
    assert killed and s.runs == runs
    ca.sweep(scene, VARY, runs, to=tmp_path / "one", executor=ThreadPoolExecutor(1), **ask)
    manifest = [Path(tmp_path / d / "manifest.parquet").read_bytes() for d in ("dask", "one")]
    assert manifest[0] == manifest[1]
    left = [p.name for p in (tmp_path / "dask").iterdir() if p.name.endswith(".part")]
    assert not left


def test_what_is_not_installed_is_named(tmp_path, monkeypatch):
    s = ca.sweep(string(), {"low.k": [1e3]}, seconds=0.01)
    for name, ask in [
        ("pandas", s.to_pandas),
        ("xarray", s.to_xarray),
        ("zarr", lambda: ca.sweep(string(), {"low.k": [1e3]}, seconds=0.01, to=str(tmp_path / "a.zarr"))),
    ]:
        monkeypatch.setitem(sys.modules, name, None)
        with pytest.raises(ca.MissingError, match=name + r".*cordis-anima\[data\]"):
            ask()


def test_what_makes_no_sense_is_refused(tmp_path):
    scene = string()
    for vary, runs, what in [
        ({"lwo.k": [1]}, None, "did you mean `low.k`"),
        ({"low.k": []}, None, "0 values"),
        ({"low.k": "1 kN/m"}, None, "a `Range`, or a list"),
        ({"low.k": 3.0}, None, "a `Range`, or a list"),
        ({"low.k": ca.Range(1, 2)}, None, "`runs`"),
        ({"low.k": ca.Range("a", 2)}, 3, "a number or a quantity"),
        ({"low.k": ca.Range(1, float("inf"))}, 3, "must be finite"),
        ({"low.k": ca.Range(-1, 2, log=True)}, 3, "above 0"),
        ({"low.k": ca.Range(1, 2, steps=1)}, None, "steps"),
        ({"low.k": [1.0]}, 0, "1 to"),
        ({"low.k": [1.0]}, 2.0, "whole number"),
        ({"low.k": ca.Range(1, 2, steps=3.0)}, None, "whole number"),
        ({"low.k": {"from": 1, "to": 2}}, None, "a `Range`, or a list"),
        ({"low.k": {1.0, 2.0}}, None, "a `Range`, or a list"),
        ({"low.k": np.array(3.0)}, None, "a `Range`, or a list"),
        ({"low.k": [None]}, None, "a number, a quantity"),
        ({"low.k": itertools.count()}, None, "more than 1000000 values"),
        ({"low.k": [1 + 2j]}, None, "a number, a quantity"),
        ({"low.k": [b"1"]}, None, "a number, a quantity"),
        ({"low.k": [10**400]}, None, "cannot be"),
        ({"rate.sound": [44100]}, None, "one rate"),
    ]:
        with pytest.raises(ca.UsageError, match=what):
            ca.sweep(scene, vary, runs)
    with pytest.raises(ca.ModelError, match="N/m"):
        ca.sweep(scene, {"low.k": ca.Range("1 s", "2 kN/m")}, 3)
    one = {"low.k": [1e3]}
    for more, what in [
        ({"seconds": -1}, "above 0"),
        ({"batch": 0}, "1 to"),
        ({"seed": -1}, "0 to"),
        ({"executor": 3}, "concurrent.futures"),
        ({"chunk": 2.0}, "whole number"),
        ({"audio": "flac"}, "needs a folder"),
        ({"to": tmp_path / "x", "audio": "mp3"}, "flac"),
        ({"to": tmp_path / "x", "chunk": 0}, "1 to"),
        ({"to": str(tmp_path / "x.zarr"), "chunk": 0}, "1 to"),
        ({"gesture": {"nobody": 1.0}}, "nobody"),
    ]:
        with pytest.raises(ca.CaError, match=what):
            ca.sweep(scene, one, **more)
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "a.txt").write_text("")
    with pytest.raises(ca.UsageError, match="not empty"):
        ca.sweep(scene, one, to=tmp_path / "mine")
