"""Takes: written and read here, replayed by the command, read by independent libraries."""

from __future__ import annotations

import base64
import pickle
from collections.abc import Callable
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

import cordis_anima as ca

#: pressed twice, because forces come on within a second
PRESS = {"key": [(0, -0.006), (0.2, -0.006), (0.24, 0.001), (0.4, -0.006), (1.2, -0.006), (1.24, 0.001), (1.4, -0.006)]}


def keyed(title: str = "A key") -> ca.Scene:
    """A device key, a contact, a live parameter."""
    return ca.parse(
        f"[model]\ntitle = '{title}'\n"
        """
[param]
grip = { value = "2 kN/m", live = true, min = "100 N/m", max = "9 kN/m" }
[TGR]
key = { device = "tgr12", dof = 1, x = "-6 mm" }
[STRING]
low = { n = 40, f = "110 Hz", t60 = "4 s", m = "1 g" }
[BUT]
strike = { between = ["key", "low[8]"], k = "grip", z = "0.2 N s/m" }
[SOX]
left = { from = "low[3]", gain = 200 }
right = { from = "low@0.7", gain = 200 }
"""
    )


def test_a_take_is_what_a_render_is(tmp_path: Path) -> None:
    scene = keyed()
    t = ca.record(scene, tmp_path / "t.mcap", 1.6, gesture=PRESS, energy=True)
    r = scene.render(1.6, gesture=PRESS)
    n = len(r.audio)
    assert np.abs(r.audio).max() > 1e-3 and t.rate == r.sr and t.channels == r.channels
    assert np.array_equal(t.audio[:n].astype(np.float32), r.audio), "the same bits"
    hand = t.hands["tgr12"]
    assert hand.dof == 12 and hand.position.shape == (len(hand.time), 12)
    # a frame has the position at its end
    assert np.all(np.diff(hand.time[1:]) == pytest.approx(1 / t.gesture_rate))
    at = np.interp(hand.time[1:] + (16 - 1) / t.rate, *np.array(PRESS["key"]).T)
    assert np.allclose(hand.position[1:, 1], at, atol=1e-12)
    # forces act while the key is in the string, once armed
    pressed = (hand.force_time > 1.24) & (hand.force_time < 1.28)
    assert hand.mode[-1] == "on" and np.abs(hand.force[pressed, 1]).max() > 0.05
    assert np.all(hand.force[:, 0] == 0) and np.all(hand.force[hand.mode == "off"] == 0)
    assert t.faults == () and t.lost == (0, 0, 0) and t.cut is None
    assert t.energy["time"].size >= 1 and np.all(np.abs(t.energy["residual"]) <= 1e-9 * t.energy["peak"])
    assert "tgr12" in repr(t) and "12 dof" in repr(hand)


def test_it_replays_here_and_by_the_command(tmp_path: Path, command: Callable[..., str]) -> None:
    gesture = {**PRESS, "grip": [(0, 2e3), (0.5, 4e3)]}
    t = ca.record(keyed(), tmp_path / "t.mcap", 0.8, gesture=gesture)
    found = t.replay()
    assert found.identical and found.difference is None and found.tolerance == 0 and found.samples == 2 * len(t.audio) > 0
    assert found.forces == len(t.hands["tgr12"].force_time) and found.hashes >= 1
    assert "identical" in command("replay", "t.mcap", "--verify")
    assert "0.8" in command("log", "info", "t.mcap")
    assert t.scene().n_mat == keyed().n_mat and t.scene().rate == t.rate


def test_a_take_of_an_older_arithmetic_is_compared_to_a_tolerance() -> None:
    found = ca.Take(Path(__file__).parents[4] / "tests/data/takes/arithmetic-0.mcap").replay()
    assert found.identical and found.tolerance == 1e-9


def test_a_take_is_a_gesture(tmp_path: Path) -> None:
    gesture = {**PRESS, "grip": [(0, 2e3), (0.5, 4e3)]}
    t = ca.record(keyed(), tmp_path / "t.mcap", 0.5, gesture=gesture)
    r = keyed().render(0.5, gesture=t.gesture)
    assert np.array_equal(t.audio[: len(r.audio)].astype(np.float32), r.audio)
    again = ca.record(keyed(), tmp_path / "again.mcap", 0.5, gesture=t.gesture)
    assert np.array_equal(again.audio, t.audio)


def test_a_take_has_its_sensitivities(tmp_path: Path) -> None:
    """Derivatives by a parameter, and by the hand position at the end of each frame, against differences of renders."""
    t = ca.record(keyed(), tmp_path / "t.mcap", 0.3, gesture=PRESS)
    scene, rng = t.scene(), np.random.default_rng(2)
    weights = rng.normal(size=(round(0.3 * t.rate), 2))
    g = scene.gradient(["low.m"], cotangent=weights, gesture=t.gesture)
    assert g.mode == "reverse" and g.inputs["key"].shape == (len(weights),)

    def heard(m: float) -> float:
        return float((scene.replace({"low.m": m}).render(0.3, gesture=t.gesture, dtype="float64").audio * weights).sum())

    m = float(g.values[0])
    assert (heard(m * 1.0001) - heard(m * 0.9999)) / (2e-4 * m) == pytest.approx(g["low.m"], rel=1e-4)
    moved = np.flatnonzero(g.inputs["key"])
    ratio = round(t.rate / t.gesture_rate)
    assert len(moved) > 50 and np.all(moved % ratio == 0)


def test_a_take_of_a_changed_scene_is_of_that_scene(tmp_path: Path) -> None:
    built = ca.Model().add("TGR", "key", device="tgr12", dof=0, x="-6 mm").add("SOL", "bed").add("MAS", "bob", m="1 g", dx0="1 mm")
    built.add("RES", "spring", between=["bob", "bed"], k=400).add("BUT", "hit", between=["key", "bed"], k=2000, z=1)
    built.add("SOX", "out", from_="bob", gain=100)
    scenes = [
        keyed().replace({"strike.z": 0.3, "model.title": "other"}),
        keyed().replace({"grip": "3 kN/m", "low.m": "2 g"}, rate=44100),
        ca.load("hammered_string", {"hammer.m": "30 g"}),
        pickle.loads(pickle.dumps(keyed().replace({"strike.z": 0.3}))),
        built.compile(),
    ]
    for k, scene in enumerate(scenes):
        t = ca.record(scene, tmp_path / f"{k}.mcap", 0.5)
        assert t.replay().identical and t.scene().hash == scene.hash and t.scene().rate == scene.rate, k
        # the sound of a server fades in within 50 ms
        heard = slice(round(0.05 * scene.rate), round(0.5 * scene.rate))
        assert np.array_equal(t.audio[heard].astype(np.float32), scene.render(0.5).audio[heard]), k
        assert pickle.loads(pickle.dumps(t)).title == t.title == scene.title


def test_others_read_it(tmp_path: Path) -> None:
    from mcap.reader import make_reader
    from mcap_ros2.decoder import DecoderFactory

    t = ca.record(keyed(), tmp_path / "t.mcap", 1.5, gesture=PRESS)
    hand = t.hands["tgr12"]
    with open(t.path, "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        frames = [m.decoded_message for m in reader.iter_decoded_messages(topics=["/device/tgr12/in"])]
        forces = [m.decoded_message for m in reader.iter_decoded_messages(topics=["/device/tgr12/out"])]
    assert np.array_equal([f.pos[:12] for f in frames], hand.position)
    assert np.array_equal([f.seq for f in frames], hand.number) and np.array_equal([f.ack for f in forces], hand.answers)
    assert np.array_equal([f.flags for f in forces], hand.flags)
    assert np.array_equal(np.array([f.inject for f in forces], np.float32), hand.injected)
    assert np.array_equal([f.tick / t.rate for f in frames], hand.time)
    assert np.array_equal(np.array([f.force[:12] for f in forces], np.float32), hand.force)


def test_the_viscosity_that_the_guard_adds_is_in_the_take(tmp_path: Path) -> None:
    wall = """
[TGR]
key = { device = "tgr12", dof = 1, x = "-6 mm" }
[SOL]
wall = {}
[BUT]
stop = { between = ["key", "wall"], k = "%d kN/m" }
[SOX]
out = { from = "key" }
"""
    # at 1 kN/m, K T is below half of the device's 2 N s/m; at 6 kN/m it is not
    soft, stiff = (ca.record(ca.parse(wall % k), tmp_path / f"{k}.mcap", 1.5, gesture=PRESS) for k in (1, 6))
    assert soft.hands["tgr12"].injected.max() == 0
    assert 0.1 < stiff.hands["tgr12"].injected.max() <= 1.0


def test_bundled_models_with_devices_can_be_taken(tmp_path: Path) -> None:
    for name in ["hammered_string", "rattle", "chimes", "plate"]:
        t = ca.record(ca.load(name), tmp_path / f"{name}.mcap", 0.2)
        assert t.replay().identical and t.title == ca.load(name).title


def test_without_forces_there_are_none(tmp_path: Path) -> None:
    t = ca.record(keyed(), tmp_path / "t.mcap", 0.5, gesture=PRESS, forces=False)
    hand = t.hands["tgr12"]
    assert np.all(hand.force == 0) and set(hand.mode) == {"off"} and t.replay().identical


def test_one_hand_is_not_in_two_places(tmp_path: Path) -> None:
    text = '[TGR]\na = { device = "tgr12", dof = 0 }\nb = { device = "tgr12", dof = 0 }\n[SOL]\nbed = {}\n[RES]\n'
    scene = ca.parse(text + 's = { between = ["a", "bed"], k = 100 }\nt = { between = ["b", "bed"], k = 100 }\n')
    ca.record(scene, tmp_path / "same.mcap", 0.1, gesture={"a": [(0, 0), (0.1, 1e-3)], "b": [(0, 0), (0.1, 1e-3)]})
    with pytest.raises(ca.UsageError, match="to two positions"):
        ca.record(scene, tmp_path / "two.mcap", 0.1, gesture={"a": [(0, 0), (0.1, 1e-3)], "b": [(0, 0), (0.1, 2e-3)]})


def test_what_cannot_be_is_said(tmp_path: Path, key: ca.Scene) -> None:
    with pytest.raises(ca.UsageError, match="`hand` is not a device port"):
        ca.record(key, tmp_path / "a.mcap", 0.1, gesture={"hand": 0.0})
    with pytest.raises(ca.UsageError, match="above 0"):
        ca.record(key, tmp_path / "a.mcap", 0.0)

    def enough(done: int, of: int) -> None:
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        ca.record(keyed(), tmp_path / "a.mcap", 5.0, progress=enough)
    assert not (tmp_path / "a.mcap").exists(), "nothing is left of it"
    (tmp_path / "mine.mcap").write_text("mine")
    with pytest.raises(ca.CaError, match="never overwritten"):
        ca.record(keyed(), tmp_path / "mine.mcap", 0.1)
    assert (tmp_path / "mine.mcap").read_text() == "mine"
    with pytest.raises(ca.FileError):
        ca.Take(tmp_path / "mine.mcap")
    with pytest.raises(ca.FileError):
        ca.Take(tmp_path / "none.mcap")


def test_a_take_that_was_cut_off_is_read_as_far_as_it_goes(tmp_path: Path) -> None:
    whole = ca.record(keyed(), tmp_path / "t.mcap", 3.0, gesture=PRESS)
    data = Path(whole.path).read_bytes()
    (tmp_path / "cut.mcap").write_bytes(data[: len(data) * 2 // 3])
    cut = ca.Take(tmp_path / "cut.mcap")
    assert cut.cut is not None and 0 < len(cut.audio) < len(whole.audio)
    n = len(cut.audio)
    assert np.array_equal(cut.audio, whole.audio[:n])
    assert cut.replay().difference is None


def test_a_page_of_a_take(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    throw = {"key": [(0, -6e-3), (1.3, -6e-3), (1.305, 1e-3)]}
    t = ca.record(keyed("A <key> & a string"), tmp_path / "t.mcap", 1.6, gesture=throw)
    page = t._repr_html_()
    assert page.startswith("<div>") and page.endswith("</div>") and "http" not in page and "<script" not in page
    assert "A &lt;key&gt; &amp; a string" in page and "<key>" not in page
    assert "tgr12: 12 dof, 4801 frames in, 4801 out" in page and "1.600 s" in page
    assert f"VELOCITY at {t.faults[0].time:.3f} s (tgr12)" in page and "nothing" in page
    assert page.count("<svg") == 2 and "left" in page and "right" in page

    def played(page: str) -> npt.NDArray[np.int16]:
        """Samples of the player in a page."""
        wav = base64.b64decode(page.split("data:audio/wav;base64,")[1].split('"')[0])
        return np.frombuffer(wav[44:], "<i2").reshape(-1, 2)

    heard = np.rint(t.audio.astype(np.float32).astype(np.float64) * 32768)
    assert np.array_equal(played(page), heard) and heard.any() and "played here" not in page
    # a long take is only partly in the page
    monkeypatch.setattr("cordis_anima._take._PLAYED", 1.5)
    long = t._repr_html_()
    assert np.array_equal(played(long), heard[:72000]) and "the first 1.5 s" in long
    # a take cut off before any sound
    (tmp_path / "cut.mcap").write_bytes(Path(t.path).read_bytes()[:12000])
    cut = ca.Take(tmp_path / "cut.mcap")
    assert cut.audio.size == 0 and "<audio" not in cut._repr_html_() and "it ends in the middle" in cut._repr_html_()
    silent = ca.record(ca.examples.string(), tmp_path / "string.mcap", 0.05)
    assert "<th>devices</th><td>none</td>" in silent._repr_html_() and "<th>faults</th><td>none</td>" in silent._repr_html_()
