"""Scenes played in the page of `ca play`, and films of them: real programs, real pages."""

import gc
import os
import pickle
import signal
import subprocess
import sys
import time
import urllib.request

import cordis_anima as ca
import pytest

BAR = '[CEL]\nbar = { m = "1 g", f = "220 Hz", t60 = "2 s", dx0 = "1 mm" }\n[SOX]\nout = { from = "bar", gain = 500 }\n'


def ends(process):
    until = time.monotonic() + 20
    while process.poll() is None:
        assert time.monotonic() < until, "it plays on"
        time.sleep(0.01)


def test_a_scene_is_played_in_a_page_that_a_notebook_may_show():
    with ca.parse(BAR, rate="44.1 kHz").replace({"bar.f": "330 Hz"}).play("--audio", "page") as playing:
        with urllib.request.urlopen(playing.url) as page:
            policy = page.headers["Content-Security-Policy"]
            assert b"<title>" in page.read()
        # pages of this machine, and of no other
        assert policy.endswith("frame-ancestors http://127.0.0.1:* http://localhost:*"), policy
        shown = playing._repr_html_()
        assert playing.url in shown and 'allow="autoplay; midi"' in shown
        assert repr(playing) == f"<Playing at {playing.url}>"
        process = playing._process
        model = process.args[2]
        with open(model, encoding="utf-8") as text:
            assert "330 Hz" in text.read()
        assert "44100.0 Hz" in process.args
    assert process.poll() is not None and not playing.is_playing and "ended" in playing._repr_html_()
    assert not os.path.exists(model)


def test_it_ends_when_nothing_refers_to_it_and_with_the_interpreter():
    playing = ca.parse(BAR).play("--audio", "page")
    process = playing._process
    del playing
    gc.collect()
    ends(process)
    code = "import cordis_anima as ca, sys; p = ca.load('rattle').play('--audio', 'page'); print(p._process.pid)"
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    with pytest.raises(ProcessLookupError):
        os.kill(int(ran.stdout), signal.SIG_DFL)


def test_what_does_not_play_says_why():
    with pytest.raises(ca.FailedError, match="--organ"):
        ca.parse(BAR).play("--organ")
    with pytest.raises(ca.UsageError, match="`ca=`.*python -m cordis_anima"):
        ca.parse(BAR).play(ca="/nowhere/ca")
    with pytest.raises(ca.UsageError, match="Scene.play"):
        ca.Playing()


def test_the_program_is_found(monkeypatch):
    monkeypatch.setenv("CA", "/nowhere/ca")
    with pytest.raises(ca.UsageError, match="environment variable CA"):
        ca.parse(BAR).play()
    # without it, the command of the package plays
    monkeypatch.delenv("CA")
    with ca.parse(BAR).play("--audio", "page") as playing, urllib.request.urlopen(playing.url) as page:
        assert playing._process.args[:3] == [sys.executable, "-m", "cordis_anima"]
        assert b"<title>" in page.read()


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
    # nothing in it ends the attribute it stands in
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
