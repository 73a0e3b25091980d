"""Sweeps in folders, stores and data frames: files read by other libraries, and sweeps that continue."""

import os
import pickle
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context

import numpy as np
import pytest
from sweeps import STRUCK, TIMES, VARY, same, spawned, string

import cordis_anima as ca


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
    # Python continues the folder that the command began
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
    assert s == s and s != ca.sweep(string(), VARY, 6, seconds=0.05) and len({s, s}) == 1
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
    # cell contents are escaped
    assert rows[4][:4] == ["4", "&lt;b&gt;", "0.001", "invalid"] and rows[4][-1].startswith("E") and "<b>" not in page
    assert rows[8][3] == "unstable" and float(rows[8][4]) == pytest.approx(s["failed"][8], rel=1e-5)
    # a message of several lines is shortened to fit its cell
    begin = rows[8][-1].removesuffix(" …")
    assert s["message"][8].startswith(begin) and 30 < len(begin) < 60 < len(s["message"][8])
    # a small sweep shows all rows
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
    from cordis_anima._sweeps import zarr as _zarr

    store = str(tmp_path / "a.zarr")
    make = _zarr._make

    def killed(*args):
        make(*args)
        raise KeyboardInterrupt

    monkeypatch.setattr(_zarr, "_make", killed)
    with pytest.raises(KeyboardInterrupt):
        ca.sweep(string(), {"low.k": [1e3, 2e3]}, seconds=0.02, to=store)
    monkeypatch.setattr(_zarr, "_make", make)
    # equal values make equal sweeps, whatever their types
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
