"""Scenes played in a page, and films of them, with real processes and pages."""

import gc
import os
import pickle
import subprocess
import sys
import time
import urllib.request
from pathlib import Path

import cordis_anima as ca
import pytest

BAR = '[CEL]\nbar = { m = "1 g", f = "220 Hz", t60 = "2 s", dx0 = "1 mm" }\n[SOX]\nout = { from = "bar", gain = 500 }\n'


LIVE = (
    '[param]\nk = { value = 900, unit = "N/m", min = 100, max = 2000, live = true, doc = "stiffness" }\n[MAS]\na = { m = "1 g" }\n'
    '[SOL]\ng = {}\n[REF]\nr = { between = ["g", "a"], k = "k", z = "0.1 N s/m" }\n[SOX]\nout = { from = "a" }\n'
)


def page(address):
    with urllib.request.urlopen(address) as answer:
        return answer.read()


def ends(is_over):
    until = time.monotonic() + 20
    while not is_over():
        assert time.monotonic() < until, "it plays on"
        time.sleep(0.01)


def refused(address):
    try:
        page(address)
    except OSError:
        return True
    return False


def test_a_scene_is_played_in_a_page_that_a_notebook_may_show():
    with ca.parse(BAR, rate="44.1 kHz").replace({"bar.f": "330 Hz"}).play("--audio", "page") as playing:
        with urllib.request.urlopen(playing.url) as answer:
            policy = answer.headers["Content-Security-Policy"]
            assert b"<title>" in answer.read()
        # only pages of this machine
        assert policy.endswith("frame-ancestors http://127.0.0.1:* http://localhost:*"), policy
        shown = playing._repr_html_()
        assert playing.url in shown and 'allow="autoplay; midi"' in shown
        assert repr(playing) == f"<Playing at {playing.url}>" and playing.is_playing
        assert "engine: " in playing.said
    assert not playing.is_playing and "ended" in playing._repr_html_() and refused(playing.url)


def test_it_plays_in_this_process_and_is_changed_while_it_plays(tmp_path):
    threads = len(list(Path(f"/proc/{os.getpid()}/task").iterdir()))
    take = tmp_path / "t.mcap"
    with ca.parse(LIVE).play("--audio", "page", "--log", str(take)) as playing:
        assert len(list(Path(f"/proc/{os.getpid()}/task").iterdir())) > threads
        assert playing.set({"k": "1.2 kN/m"}) == "k = 1200"
        assert playing.set({"k": 500}) == "k = 500"
        with pytest.raises(ca.UsageError, match="`k`"):
            playing.set({"k": "3 kg"})
        assert "compiling the model again" in playing.set({"a.m": "2 g"})
        time.sleep(0.5)
    with pytest.raises(ca.FailedError, match="does not answer"):
        playing.set({"k": 600})
    assert ca.Take(take).replay().identical


def test_several_play_at_once_and_each_ends_by_itself():
    with ca.parse(BAR).play("--audio", "page") as one, ca.load("rattle").play("--audio", "page", "--seconds", "0.5") as other:
        assert one.url != other.url
        ends(lambda: not other.is_playing)
        assert one.is_playing and b"<title>" in page(one.url)


def test_it_ends_when_nothing_refers_to_it_and_with_the_interpreter():
    playing = ca.parse(BAR).play("--audio", "page")
    url = playing.url
    del playing
    gc.collect()
    ends(lambda: refused(url))
    code = "import cordis_anima as ca; p = ca.load('rattle').play('--audio', 'page'); print(p.url)"
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60)
    assert refused(ran.stdout.strip())


def test_what_does_not_play_says_why():
    with pytest.raises(ca.FailedError, match="--organ"):
        ca.parse(BAR).play("--organ")
    with pytest.raises(ca.FailedError, match="--audio nowhere"):
        ca.parse(BAR).play("--audio", "nowhere")
    with pytest.raises(ca.UsageError, match="`ca=`.*python -m cordis_anima"):
        ca.parse(BAR).play(ca="/nowhere/ca")
    with pytest.raises(ca.UsageError, match="Scene.play"):
        ca.Playing()


def test_force_devices_are_played_by_a_process(monkeypatch):
    monkeypatch.setenv("CA", "/nowhere/ca")
    with pytest.raises(ca.UsageError, match="environment variable CA"):
        ca.parse(BAR).play()
    monkeypatch.delenv("CA")
    one = ca.parse(LIVE).play("--audio", "page", ca=os.environ["CA_COMMAND"])
    assert one.set({"k": 500}) == "k = 500" and one._plays.process.args[0] == os.environ["CA_COMMAND"]
    one.stop()
    with pytest.raises(ca.FailedError, match="has stopped"):
        one.set({"k": 600})
    with ca.load("piano_key").play("--audio", "page") as playing:
        process = playing._plays.process
        assert process.args[:4] == [sys.executable, "-m", "cordis_anima", "play"]
        model = process.args[4]
        assert os.path.exists(model) and b"<title>" in page(playing.url)
    assert process.poll() is not None and not playing.is_playing and not os.path.exists(model)


def test_a_film_is_of_what_was_played(tmp_path):
    scene = ca.load("hammered_string")
    rendered = scene.render(0.3, gesture={"key": [(0, -0.008), (0.02, 0), (0.2, -0.008)]})
    view = rendered.view()
    assert 10_000 < len(view.html) < 5e6 and "<audio" in view.html and "filmCanvas" in view.html
    still = scene.view(0.3, gesture={"key": -0.008})
    assert still.html != view.html
    assert pickle.loads(pickle.dumps(rendered)).view().html == view.html
    view.save(tmp_path / "view.html")
    assert (tmp_path / "view.html").read_text(encoding="utf-8") == view.html
    # nothing in the page ends the attribute it is in
    shown = view._repr_html_()
    assert shown.startswith('<iframe srcdoc="') and shown.count('"') == 4 and "<script" not in shown
    stopped = []
    with pytest.raises(KeyboardInterrupt):
        scene.view(60, progress=lambda done, all: stopped.append(done) or (_ for _ in ()).throw(KeyboardInterrupt()))
    assert stopped


def test_a_take_is_seen_again(tmp_path):
    path = tmp_path / "t.mcap"
    take = ca.record(ca.load("hammered_string"), path, 0.4)
    page = take.view().html
    assert "a take, 0.4" in page and "filmCanvas" in page
