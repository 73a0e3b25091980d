"""Ctrl-C ends every long call at once with `KeyboardInterrupt`: a process in the middle of one gets the signal."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

#: setup of each process before it reports that it is ready
SETUP = """
import signal, sys, time
import numpy as np
import cordis_anima as ca
signal.signal(signal.SIGINT, signal.default_int_handler)
string = ca.load("hammered_string")
keyed = ca.parse('[TGR]\\nkey = { device = "pad" }\\n[MAS]\\nm = { m = "1 g" }\\n[REF]\\nr = { between = ["key", "m"], k = "1 N/m" }\\n'
                 '[SOX]\\no = { from = "m" }\\n')
def strings(n):
    return ca.parse(f'[STRING]\\nlow = {{ n = {n}, f = "{10_000 / n} Hz", t60 = "4 s", m = "1 g" }}\\n'
                    '[MAS]\\nhammer = { m = "20 g", x = "-5 mm", v = "1 m/s" }\\n'
                    '[BUT]\\nstrike = { between = ["hammer", "low[8]"], k = "8 kN/m" }\\n[SOX]\\nout = { from = "low[3]", gain = 9 }\\n')
"""

#: calls that take minutes: preceding statements, and the call
CALLS = {
    "modes": ("s = strings(3900)", "s.modes()"),
    # an interrupt during the import of scipy may end Python by the signal even if caught
    "linear": ("import scipy.sparse; s = strings(40_000)", "for _ in range(999): s.linear()"),
    "accuracy": ("", "string.accuracy(60.0, reference=128)"),
    "fit": ("s = strings(3000); y = strings(181).render(3.0).audio", "ca.fit(s, y, ['low.f'], sr=48000)"),
    "fit of modes": ("s = strings(290); y = strings(181).render(3.0).audio", "ca.fit(s, y, ['low.f', 'low.t60', 'hammer.m'], sr=48000, renders=9999)"),
    "render": ("", "string.render(3000.0)"),
    "render of a large scene": ("s = strings(40_000)", "s.render(100.0)"),
    "rollout": ("", "string.rollout('low[3]', 2000.0)"),
    "view": ("", "string.view(1e5)"),
    "batch": ("", "ca.batch(string, {'low.f': np.linspace(100, 200, 199)}, 60.0)"),
    "sweep": ("", "ca.sweep(string, {'low.f': ca.Range(100, 200)}, 9999, seconds=200.0)"),
    "sweep in a folder": ("import tempfile; d = tempfile.mkdtemp()", "ca.sweep(string, {'low.f': ca.Range(100, 200)}, 9999, seconds=200.0, to=d)"),
    "tangents": ("", "string.tangents(['low.f'], 1e3)"),
    "energy tangents": ("", "string.energy_tangents(['low.f'], 1e3)"),
    "gradient": ("", "string.gradient(['low.f', 'hammer.m'], cotangent=np.ones((48000 * 20, 2)))"),
    "gradient in forward mode": ("", "string.gradient(['low.f'], cotangent=np.ones((48000 * 20, 2)), mode='forward')"),
    "record": ("import tempfile; d = tempfile.mkdtemp()", "ca.record(keyed, d + '/t.mcap', 1e5, gesture={'key': 0.001})"),
    "load": ("text = strings(40_000)._model.toml()", "for _ in range(999): ca.parse(text)"),
    "step": ("sim = string.open()", "sim.step(n=48000 * 3000)"),
    "step of a large scene": ("sim = strings(40_000).open()", "sim.step(n=48000 * 300)"),
}  # fmt: skip

#: viewing and replaying a take last as long as the take
TAKEN = """
import tempfile
path = tempfile.mkdtemp() + '/t.mcap'
t = ca.record(keyed, path, 20.0, gesture={'key': 0.001})
"""
CALLS |= {
    "take, read": (TAKEN, "for _ in range(99_999): ca.Take(path).devices"),
    "take, view": (TAKEN, "for _ in range(999): t.view()"),
    "take, replay": (TAKEN, "for _ in range(999): t.replay()"),
}


@pytest.mark.parametrize("call", CALLS)
def test_ctrl_c_ends_a_long_call(call: str, tmp_path: Path) -> None:
    before, long = CALLS[call]
    script = f"""{SETUP}{before}
print("ready", flush=True)
try:
    {long}
except KeyboardInterrupt:
    print(time.monotonic(), flush=True)
else:
    print("it was not long", flush=True)
"""
    env = {**os.environ, "TMPDIR": str(tmp_path)}
    child = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=env)
    assert child.stdout is not None
    ready = child.stdout.readline()
    assert ready == "ready\n", child.communicate()[1]
    # in the middle of the call
    time.sleep(0.4)
    sent = time.monotonic()
    child.send_signal(signal.SIGINT)
    try:
        out, err = child.communicate(timeout=60)
    except subprocess.TimeoutExpired:
        child.kill()
        raise AssertionError(f"{call} goes on") from None
    assert child.returncode == 0 and not err, err
    print(f"{call}: {1e3 * (float(out) - sent):.0f} ms")


def test_work_that_is_not_wanted_ends_by_itself() -> None:
    """The thread of an interrupted call ends soon, and later calls work as before."""
    script = f"""{SETUP}
import os, threading
threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
try:
    string.render(3000.0)
except KeyboardInterrupt:
    pass
for _ in range(1000):
    if len(os.listdir('/proc/self/task')) == 1:
        break
    time.sleep(0.01)
else:
    raise SystemExit('a thread goes on')
assert (string.render(0.1).audio == ca.load('hammered_string').render(0.1).audio).all()
"""
    if not Path("/proc/self/task").is_dir():
        pytest.skip("threads are not counted here")
    # threads of linear algebra libraries would count too
    env = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=120, env=env)
    assert done.returncode == 0, done.stderr
