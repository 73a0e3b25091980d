"""The same model, gesture and parameters give the same bits by every way of rendering."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import soundfile

import cordis_anima as ca
from conftest import KEY


@pytest.mark.parametrize("name", ["hammered_string", "rattle", "bowed_string", "wave_guitar", "harmonic_chain"])
def test_the_command_says_the_same(name: str, command: Callable[..., str], tmp_path: Path) -> None:
    command("render", name, "-o", "a.wav", "--seconds", "0.4", "--quiet", "--no-fade")
    wav, sr = soundfile.read(tmp_path / "a.wav", dtype="float32", always_2d=True)
    r = ca.load(name).render(0.4)
    assert sr == r.sr
    assert np.abs(wav).max() > 0
    assert np.array_equal(wav, r.audio)


def test_with_gestures_changes_rates_and_probes(command: Callable[..., str], tmp_path: Path) -> None:
    (tmp_path / "key.ca.toml").write_text(KEY)
    points = [(0.0, -0.006), (0.02, 0.002), (0.3, -0.006)]
    rows = "\n".join(f"{t},{x},{2000 + 9000 * t}" for t, x in points)
    (tmp_path / "hand.csv").write_text("time,key,grip\n" + rows + "\n")
    command(
        *("render key.ca.toml -o a.wav --seconds 0.5 --quiet --no-fade --gesture hand.csv --rate 96000".split()),
        *("--set", "low.t60=2 s", "--probe", "strike=strike.npy", "--probe", "low[*]=low.npy"),
    )
    wav, sr = soundfile.read(tmp_path / "a.wav", dtype="float32", always_2d=True)
    scene = ca.load(tmp_path / "key.ca.toml", {"low.t60": "2 s"}, rate=96000)
    gesture = {"key": points, "grip": [(t, 2000 + 9000 * t) for t, _ in points]}
    for given in [gesture, tmp_path / "hand.csv"]:
        r = scene.render(0.5, gesture=given, probes=["strike", "low[*]"])
        assert sr == r.sr == 96000
        assert np.abs(wav).max() > 0.01
        assert np.array_equal(wav, r.audio)
        assert np.array_equal(np.load(tmp_path / "strike.npy").ravel(), r.probes["strike"])
        low = np.load(tmp_path / "low.npy")
        assert r.probes["low[*]"].shape == (48000, 40)
        assert np.array_equal(low.view(np.float64).reshape(48000, -1), r.probes["low[*]"])


MIDI = Path(__file__).parents[4] / "tests/data/midi"
HELD = """
[model]
seconds = 0.1
[CEL]
bar = { m = "2 g", f = "440 Hz", t60 = "0.2 s" }
[ENF]
low = { to = "bar", midi = { note = "C3", to = "1 N", attack = "1 ms", release = "1 ms" } }
[SOX]
out = { from = "bar", gain = 1000 }
"""


def test_a_midi_file_is_played_to_its_end_with_its_pedal(command: Callable[..., str], tmp_path: Path) -> None:
    (tmp_path / "held.ca.toml").write_text(HELD)
    file = MIDI / "m16_pedal.mid"
    command("render", "held.ca.toml", "-o", "a.wav", "--quiet", "--no-fade", "--gesture", str(file))
    wav, _ = soundfile.read(tmp_path / "a.wav", dtype="float32", always_2d=True)
    scene = ca.load(tmp_path / "held.ca.toml")
    r = scene.render(gesture=file, probes=["bar"])
    assert np.array_equal(wav, r.audio)
    # the pedal is released at 1.25 s, and the sound decays after that
    assert 1.75 < r.seconds < 2
    assert r.probes["bar"][48000] > 1e-5 > abs(r.probes["bar"][72000])
    assert scene.render(0.2, gesture=file).seconds == 0.2
    swept = ca.sweep(scene, {"bar.t60": ["0.2 s"]}, gesture=file)
    assert int(swept["frames"].iloc[0] if hasattr(swept["frames"], "iloc") else swept["frames"][0]) == len(r.audio)


def test_a_remark_on_a_midi_file_is_a_warning(tmp_path: Path) -> None:
    (tmp_path / "held.ca.toml").write_text(HELD)
    with pytest.warns(UserWarning, match="running status"):
        ca.load(tmp_path / "held.ca.toml").render(0.1, gesture=MIDI / "m01_rs_after_meta.mid")


@pytest.mark.parametrize("block", [1, 7, 16, 512])
def test_blocks_are_the_whole(key: ca.Scene, block: int) -> None:
    n = 1600
    hand = 1e-3 * np.sin(np.arange(n) / 50)
    push = np.where(np.arange(n) % 200 == 0, 0.3, 0.0)
    whole = key.render(n / key.sr, gesture={"hand": hand, "push": push, "key": 0.001})
    with key.open(block=block) as sim:
        parts = []
        for i in range(0, n, block):
            m = min(block, n - i)
            parts.append(sim.step({"hand": hand[i : i + m], "push": push[i : i + m], "key": 0.001}, m).audio)
    assert np.abs(whole.audio).max() > 0
    assert np.array_equal(np.concatenate(parts), whole.audio)


def test_copies_sound_the_same() -> None:
    for name in ["chimes", "rattle", "hammer_piano", "wave_guitar"]:
        scene = ca.load(name)
        want = scene.render(0.1).audio
        for other in [pickle.loads(pickle.dumps(scene)), copy.copy(scene), copy.deepcopy(scene), scene.replace()]:
            assert other == scene and other.hash == scene.hash and hash(other) == hash(scene)
            assert np.array_equal(other.render(0.1).audio, want)


def test_what_was_asked_for_stays() -> None:
    scene = ca.Model.load("harmonic_chain").compile(rate=96000, exact=True)
    for other in [pickle.loads(pickle.dumps(scene)), scene.replace({"model.title": "x"})]:
        assert other.rate == 96000 and other.certificate.largest == scene.certificate.largest is not None
    with pytest.raises(AttributeError):
        scene.rate = 44100  # type: ignore[misc]
    r = ca.examples.string().render(0.01, probes="low[3]", energy=True)
    assert pickle.loads(pickle.dumps(r)).audio.tobytes() == copy.deepcopy(r).audio.tobytes() == r.audio.tobytes()


def test_the_hash_is_of_what_it_means() -> None:
    text = "[MAS]\na = { m = 1 }\n# why\n[SOL]\nw = {}\n[RES]\nr = { between = ['w', 'a'], k = 1 }\n[SOX]\no = { from = 'a' }\n"
    scene = ca.parse(text)
    assert scene.hash == ca.parse("# another comment\n\n" + text, file="b.ca.toml").hash
    assert scene.hash != scene.replace({"a.m": 2}).hash
    assert scene.hash != ca.parse(text, rate=96000).hash
    # the order of modules is the order of sums
    swapped = "[SOL]\nw = {}\n[MAS]\na = { m = 1 }\n" + text[text.index("[RES]") :]
    assert scene.hash != ca.parse(swapped).hash
    # however the rate is given
    for rate in [None, 48000, 48000.0, np.float64(48000), np.int64(48000)]:
        assert scene.hash == ca.parse(text, rate=rate).hash  # type: ignore[arg-type]
    # the same on every machine
    assert scene.hash == "b0aada94f9eebc2dc777e04b7d408744a4f985cb78d9b7eafebe678679ad7c2d"
