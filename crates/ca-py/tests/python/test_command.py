"""The command ``ca`` of the package, as a separate process."""

import json
import os
import signal
import subprocess
import sys
import time

COMMAND = [sys.executable, "-m", "cordis_anima"]


def run(*args):
    return subprocess.run([*COMMAND, *args], capture_output=True, text=True, check=False)


def test_it_is_the_command(tmp_path):
    own, other = (
        subprocess.run([*program, "check", "rattle", "--json"], capture_output=True, text=True, check=True).stdout
        for program in (COMMAND, [os.environ["CA_COMMAND"]])
    )
    assert own == other and json.loads(own)["summary"]
    sound = tmp_path / "a.wav"
    assert run("render", "rattle", "--seconds", "0.1", "-q", "-o", str(sound)).returncode == 0
    assert sound.stat().st_size > 1000
    wrong = run("render", "nothing.ca.toml")
    assert wrong.returncode in (1, 2) and "nothing.ca.toml" in wrong.stderr
    assert "Usage: ca render" in run("render", "--help").stdout


def test_ctrl_c_ends_it(tmp_path):
    args = [*COMMAND, "render", "rattle", "--seconds", "3600", "-o", str(tmp_path / "a.wav")]
    process = subprocess.Popen(args, stderr=subprocess.PIPE, text=True)
    until = time.monotonic() + 20
    while not list(tmp_path.iterdir()):
        assert time.monotonic() < until and process.poll() is None
        time.sleep(0.01)
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=20)
    assert process.returncode == 130 and "panic" not in said, said
