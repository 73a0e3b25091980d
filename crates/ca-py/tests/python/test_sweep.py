"""Sweeps: the same whoever computes them, bad runs as rows, and files that others read."""

import itertools
import os
import pickle
import signal
import struct
import subprocess
import sys
import threading
import types
import warnings
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pytest

import cordis_anima as ca
from cordis_anima import plot

LONG = "CA_LONG" in os.environ
TIMES = ("run_time", "rtf")
VARY = {
    "low.k": ca.Range("1 kN/m", "9 kN/m", log=True),
    "low.m": ["1 g", "2 g"],
    "low.z": ca.Range(0.0, 1e-3),
}
STRUCK = """
[STRING]
low = { n = 20, k = "4 kN/m", m = "1 g", z = "1 mN s/m", t60 = "1 s" }
[MAS]
hammer = { m = "20 g", x = "-5 mm", v = "1 m/s" }
[BUT]
strike = { between = ["hammer", "low[8]"], k = "8 kN/m", z = "0.2 N s/m" }
[SOX]
out = { from = "low[3]", gain = 50 }
"""


def string():
    return ca.parse(STRUCK)


def same(a, b):
    assert list(a) == list(b)
    for name in a:
        if name not in TIMES:
            assert a[name].dtype == b[name].dtype, name
            assert pickle.dumps(a[name].tolist()) == pickle.dumps(b[name].tolist()), name


def spawned(n=2):
    return ProcessPoolExecutor(n, mp_context=get_context("spawn"))


@pytest.fixture(scope="module")
def dask():
    from dask.distributed import Client, LocalCluster

    cluster = LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None)
    with cluster, Client(cluster) as client:
        yield client


def test_any_executor_any_order_finds_the_same(dask):
    from joblib.externals.loky import get_reusable_executor

    one = ca.sweep(string(), VARY, 40, seed=3, seconds=0.05, audio=True, executor=ThreadPoolExecutor(1))
    assert one.runs == 40 and one.counts == {"ok": 40}
    assert len(one.audio) == 40 and one.audio[0].shape == (2400, 1)

    class Backwards(ThreadPoolExecutor):
        """Begins with what was handed over last."""

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
    # another axis moves no run along those that were there
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
    assert s["failed"][2] < 0.1 and "low" in s["module"][2] and "blew up" in s["message"][2]
    assert s["message"][1].startswith("E") and np.isnan(s["failed"][0]) and s["module"][0] is None
    # what is no number makes a column of texts
    assert s["low.k"].tolist() == ["1000", "-1", "1000000000", "a lot"]


def test_gestures_go_along_to_other_processes(tmp_path):
    key = ca.load("hammered_string")
    (tmp_path / "blow.csv").write_text("time,key\n0,0\n0.02,-0.008\n0.1,0\n")
    samples = -0.008 * np.hanning(4800)
    for gesture in [{"key": [(0, 0), (0.02, -0.008), (0.1, 0)]}, {"key": samples}, str(tmp_path / "blow.csv")]:
        here = ca.sweep(key, {"hammer.m": ["10 g", "20 g"]}, seconds=0.2, gesture=gesture)
        with spawned(1) as processes:
            same(here, ca.sweep(key, {"hammer.m": ["10 g", "20 g"]}, seconds=0.2, gesture=gesture, executor=processes, batch=1))
        assert np.all(here["peak"] > 0)
        # without it the built-in gesture plays
        assert not np.array_equal(here["peak"], ca.sweep(key, {"hammer.m": ["10 g", "20 g"]}, seconds=0.2)["peak"])


def test_a_folder_is_that_of_the_command(tmp_path, command):
    (tmp_path / "struck.ca.toml").write_text(STRUCK)
    (tmp_path / "p.sweep.toml").write_text(
        'model = "struck.ca.toml"\nseconds = 0.05\nruns = 23\nseed = 5\nchunk = 5\n[vary]\n'
        '"low.k" = { from = "1 kN/m", to = "9 kN/m", log = true }\n"low.n" = [10, 20, 40]\n'
    )
    command("sweep", "p.sweep.toml")
    vary = {"low.k": ca.Range("1 kN/m", "9 kN/m", log=True), "low.n": [10, 20, 40]}
    seen = []
    s = ca.sweep(
        string(), vary, 23, seed=5, seconds=0.05, to=tmp_path / "py", chunk=5, measure=True,
        progress=lambda done, of: seen.append((done, of)),
    )
    assert seen[-1] == (23, 23) and sorted(seen) == seen and s.path == str(tmp_path / "py")
    mine, theirs = (sorted(p.relative_to(tmp_path / d) for p in (tmp_path / d).rglob("*")) for d in ("py", "p"))
    assert mine == theirs
    for name in mine:
        if name.suffix in (".flac", ".toml") or name.name == "manifest.parquet":
            assert (tmp_path / "py" / name).read_bytes() == (tmp_path / "p" / name).read_bytes(), name
    # the one goes on with what the other began
    again = ca.sweep(string(), vary, 23, seed=5, seconds=0.05, to=tmp_path / "p", chunk=5, measure=True)
    same(s, again)


def test_others_read_the_files(tmp_path):
    import pandas
    import pyarrow.parquet
    import soundfile

    s = ca.sweep(string(), VARY, 12, seconds=0.1, to=tmp_path / "d", chunk=5)
    frame = pandas.read_parquet(tmp_path / "d" / "manifest.parquet")
    assert list(frame.columns) == [c for c in s if c not in TIMES]
    assert np.array_equal(frame["low.k"], s["low.k"]) and frame["status"].tolist() == ["ok"] * 12
    about = pyarrow.parquet.read_schema(tmp_path / "d" / "manifest.parquet").metadata
    assert about[b"version"].decode() == ca.__version__ and about[b"scene"].decode() == string().hash
    times = pandas.read_parquet(tmp_path / "d" / "times.parquet")
    assert np.all(times["run_time"] > 0) and np.array_equal(times["run_time"], s["run_time"])
    memory = ca.sweep(string(), VARY, 12, seconds=0.1, audio=True)
    for file, sound in zip(frame["file"], memory.audio):
        read, rate = soundfile.read(tmp_path / "d" / file, dtype="float64", always_2d=True)
        assert rate == 48000 and read.shape == sound.shape
        assert np.abs(read - sound).max() <= 2.0**-24
    wav = ca.sweep(string(), VARY, 3, seconds=0.1, to=tmp_path / "w", audio="wav")
    assert np.array_equal(soundfile.read(tmp_path / "w" / wav["file"][2], dtype="float32", always_2d=True)[0], memory.audio[2])


def test_data_frames_and_data_sets():
    s = ca.sweep(string(), VARY, 6, seconds=0.05, audio=True)
    frame = s.to_pandas()
    assert frame.index.name == "index" and frame.loc[3, "peak"] == s["peak"][3]
    data = s.to_xarray()
    assert data["audio"].dims == ("run", "frame", "channel") and set(VARY) <= set(data.coords)
    assert np.array_equal(data["audio"][4], s.audio[4]) and data.attrs["scene"] == s.scene


def test_pages_of_notebooks():
    vary = {"low.k": ["1 kN/m", "<b>", "1 GN/m"], "low.m": [0.001, 0.002, 0.003, 0.004]}
    s = ca.sweep(string(), vary, seconds=0.05, measure=True)
    page = s._repr_html_()
    assert page.startswith("<div><p>Sweep: 12 runs over low.k, low.m: 4 invalid, 4 ok, 4 unstable</p>")
    assert page.endswith("<p>and 2 more</p></div>") and "http" not in page and "<script" not in page
    rows = [row.split("<td>")[1:] for row in page.split("<tr>")[2:]]
    rows = [[cell.split("</td>")[0] for cell in row] for row in rows]
    assert len(rows) == 10 and page.count("<th>") == len(rows[0]) == 10
    assert rows[0][:5] == ["0", "1 kN/m", "0.001", "ok", ""] and float(rows[0][5]) == pytest.approx(s["peak"][0], rel=1e-5)
    # what it holds is no page
    assert rows[4][:4] == ["4", "&lt;b&gt;", "0.001", "invalid"] and rows[4][-1].startswith("E") and "<b>" not in page
    assert rows[8][3] == "unstable" and float(rows[8][4]) == pytest.approx(s["failed"][8], rel=1e-5)
    # a message of several lines is reported as far as a cell goes
    begin = rows[8][-1].removesuffix(" …")
    assert s["message"][8].startswith(begin) and 30 < len(begin) < 60 < len(s["message"][8])
    # few rows are all of them
    few = ca.sweep(string(), {"low.m": [0.001, 0.002]}, seconds=0.05)._repr_html_()
    assert few.count("<tr>") == 3 and few.endswith("</table></div>")


def test_zarr_is_the_same_and_goes_on(tmp_path):
    import xarray

    store = str(tmp_path / "s.zarr")
    s = ca.sweep(string(), VARY, 23, seconds=0.05, to=store, chunk=5)
    memory = ca.sweep(string(), VARY, 23, seconds=0.05, audio=True)
    for name in memory:
        if name not in TIMES:
            want = ["" if v is None else v for v in memory[name].tolist()]
            assert pickle.dumps(s[name].tolist()) == pickle.dumps(want), name
            assert s[name].dtype == memory[name].dtype, name
    assert repr(s) == repr(memory) == "<Sweep: 23 runs over low.k, low.m, low.z: 23 ok>"
    assert s._repr_html_() == memory._repr_html_()
    with xarray.open_zarr(store, consolidated=False) as data:
        assert data["audio"].shape == (23, 2400, 1)
        assert np.array_equal(data["audio"], np.stack(memory.audio))
    seen = []
    ca.sweep(string(), VARY, 23, seconds=0.05, to=store, chunk=5, progress=lambda *p: seen.append(p))
    assert seen == [], "all of it is there"
    with pytest.raises(ca.UsageError, match="another sweep"):
        ca.sweep(string(), VARY, 24, seconds=0.05, to=store, chunk=5)
    with spawned() as processes:
        t = ca.sweep(string(), VARY, 23, seconds=0.05, to=str(tmp_path / "t.zarr"), chunk=5, executor=processes)
    assert np.array_equal(t["peak"], s["peak"])


def test_what_is_stopped_goes_on(tmp_path):
    def half(done, of):
        if done >= 10:
            raise RuntimeError("enough")

    go = lambda folder, **more: ca.sweep(string(), VARY, 40, seconds=0.05, to=tmp_path / folder, chunk=5, **more)
    with pytest.raises(RuntimeError, match="enough"):
        go("a", progress=half)
    assert not (tmp_path / "a" / "manifest.parquet").exists()
    seen = []
    go("a", progress=lambda *p: seen.append(p))
    assert seen[0][0] >= 15, "what was there was not done again"
    go("b")
    assert (tmp_path / "a" / "manifest.parquet").read_bytes() == (tmp_path / "b" / "manifest.parquet").read_bytes()


@pytest.mark.parametrize("how", ["", ", batch=1"])
def test_ctrl_c_ends_long_runs(how):
    code = (
        "import signal, threading, os, time, cordis_anima as ca\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "threading.Timer(1.0, lambda: os.kill(os.getpid(), signal.SIGINT)).start()\n"
        "try:\n"
        f"    ca.sweep(ca.examples.string(), {{'hammer.m': [1e-2, 2e-2]}}, seconds=1e5{how})\n"
        "except KeyboardInterrupt:\n"
        "    print('ended')\n"
    )
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)
    assert ran.stdout == "ended\n", ran.stderr


def test_the_end_of_one_is_not_the_end_of_another(tmp_path):
    def wrong(done, of):
        raise RuntimeError("mine")

    def run(name, progress):
        return ca.sweep(string(), VARY, 60, seconds=0.2, to=tmp_path / name, audio="none", progress=progress)

    with ThreadPoolExecutor(2) as pool:
        other = pool.submit(run, "a", None)
        mine = pool.submit(run, "b", wrong)
        with pytest.raises(RuntimeError, match="mine"):
            mine.result()
        assert other.result().counts == {"ok": 60}


def test_a_relative_folder_is_that_of_the_caller(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "elsewhere").mkdir()
    for to in ["rel", "rel.zarr"]:
        with ProcessPoolExecutor(1, mp_context=get_context("spawn"), initializer=os.chdir, initargs=("elsewhere",)) as pool:
            s = ca.sweep(string(), {"low.k": [1e3, 2e3]}, seconds=0.02, to=to, executor=pool)
        assert s.runs == 2 and (tmp_path / to).is_dir() and not list((tmp_path / "elsewhere").iterdir())


def test_a_store_that_was_begun_is_begun_anew(tmp_path, monkeypatch):
    from cordis_anima import _zarr

    store = str(tmp_path / "a.zarr")
    make = _zarr._make

    def killed(*args):
        make(*args)
        raise KeyboardInterrupt

    monkeypatch.setattr(_zarr, "_make", killed)
    with pytest.raises(KeyboardInterrupt):
        ca.sweep(string(), {"low.k": [1e3, 2e3]}, seconds=0.02, to=store)
    monkeypatch.setattr(_zarr, "_make", make)
    # equal values are an equal sweep, whatever they are made of
    for values, seconds in [([1e3, 2e3], 0.02), (np.array([1000, 2000]), np.float64(0.02)), (list(np.array([1e3, 2e3])), 0.02)]:
        assert ca.sweep(string(), {"low.k": values}, seconds=seconds, to=store + "/").counts == {"ok": 2}


def test_names_that_data_sets_have_are_reported_apart(tmp_path):
    params = "".join(f'{n} = {{ value = "4 kN/m" }}\n' for n in ("audio", "run", "done", "peak"))
    scene = ca.parse("[param]\n" + params + STRUCK.replace('"4 kN/m"', '"audio"'))
    vary = {"audio": [1e3, 2e3], "run": [1.0], "done": [1.0], "peak": [1.0]}
    s = ca.sweep(scene, vary, seconds=0.02, audio=True)
    assert s.axes == ("param.audio", "param.run", "param.done", "param.peak")
    assert s.to_xarray()["audio"].shape == (2, 960, 1) and s["param.audio"].tolist() == [1e3, 2e3]
    z = ca.sweep(scene, vary, seconds=0.02, to=str(tmp_path / "a.zarr"))
    assert np.array_equal(z["peak"], s["peak"])


class Patient(ThreadPoolExecutor):
    """Counts what it was handed, and what of that waits or runs."""

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
    with pytest.raises(ca.UsageError, match=r"^1000000000000 runs: their rows take \d+ TB, .* (days|years); ask for fewer"):
        ca.sweep(string(), vary, 10**12, chunk=1_000_000, **ask)
    with pytest.raises(ca.UsageError, match="TB"):
        ca.sweep(string(), {"low.m": ca.Range(1, 2, steps=10**6), "low.k": ca.Range(1, 2, steps=10**6)}, chunk=10**6, **ask)
    assert one.handed == 0 and not list(tmp_path.iterdir())
    # whether it fits is a matter of the machine, and of sounds where they are kept
    monkeypatch.setattr("cordis_anima._work.memory", lambda: 10_000_000)
    assert ca.sweep(string(), vary, 100, seconds=0.1).runs == 100
    if to is None:
        with pytest.raises(ca.UsageError, match="rows and sounds take"):
            ca.sweep(string(), vary, 1000, seconds=0.1, audio=True)


def test_what_takes_long_says_so_first(monkeypatch, tmp_path):
    vary = {"low.m": ca.Range("1 g", "2 g")}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ca.sweep(string(), vary, 20, seconds=1e-3)
    monkeypatch.setattr("cordis_anima._work._LONG", 0.0)
    monkeypatch.setattr("cordis_anima._work._WATCHED", 0.0)
    # in memory before anything is handed over, elsewhere once something is done; once in any case
    for to, left in [(None, 19), (tmp_path / "a", 15)]:
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
        # the same call goes on with it
        seen = []
        ca.sweep(string(), {"low.m": ca.Range("1 g", "2 g")}, runs, seconds=seconds, to=store, audio=audio, progress=seen.append)
        assert seen == []
    # sounds of a chunk take no more than 64 MB: a minute in one channel is 11.52 MB
    from cordis_anima import _zarr

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
        ({"low.k": ca.Range("a", 2)}, 3, "number or quantity"),
        ({"low.k": ca.Range(1, float("inf"))}, 3, "numbers are wanted"),
        ({"low.k": ca.Range(-1, 2, log=True)}, 3, "above 0"),
        ({"low.k": ca.Range(1, 2, steps=1)}, None, "steps"),
        ({"low.k": [1.0]}, 0, "1 to"),
        ({"low.k": [1.0]}, 2.0, "whole number"),
        ({"low.k": ca.Range(1, 2, steps=3.0)}, None, "whole number"),
        ({"low.k": {"from": 1, "to": 2}}, None, "a `Range`, or a list"),
        ({"low.k": {1.0, 2.0}}, None, "a `Range`, or a list"),
        ({"low.k": np.array(3.0)}, None, "a `Range`, or a list"),
        ({"low.k": [None]}, None, "numbers, quantities"),
        ({"low.k": itertools.count()}, None, "more than 1000000 values"),
        ({"low.k": [1 + 2j]}, None, "numbers, quantities"),
        ({"low.k": [b"1"]}, None, "numbers, quantities"),
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
        ({"chunk": 2.0}, "whole number"),
        ({"audio": "flac"}, "for a folder"),
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
