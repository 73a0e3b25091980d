"""Shared fixtures: Ctrl-C handling, a scene with every kind of port, and the command."""

from __future__ import annotations

import os
import signal
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

import cordis_anima as ca

# plots are checked by programs, without a display
os.environ["MPLBACKEND"] = "agg"

#: a hand with a device key and a live parameter on a string, a contact between them
KEY = """
[model]
title = "A key"
[param]
grip = { value = "2 kN/m", live = true, min = "100 N/m", max = "9 kN/m", doc = "how hard it holds" }
[TGR]
key = { device = "tgr12", dof = 0, x = "-6 mm" }
[ENX]
hand = {}
[ENF]
push = { to = "low[20]" }
[STRING]
low = { n = 40, f = "110 Hz", t60 = "4 s", m = "1 g" }
[BUT]
strike = { between = ["key", "low[8]"], k = "grip", z = "0.2 N s/m" }
[REF]
hold = { between = ["hand", "low[30]"], k = "50 N/m", z = "0.01 N s/m" }
[SOX]
left = { from = "low[3]", gain = 100 }
right = { from = "low@0.7", gain = 100 }
"""


@pytest.fixture(autouse=True)
def ctrl_c() -> None:
    """Restores the default handling of Ctrl-C, which a shell disables for background processes."""
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture
def key() -> ca.Scene:
    """A scene with a port of every role, a live parameter and a contact."""
    return ca.parse(KEY, file="key.ca.toml")


@pytest.fixture
def command(tmp_path: Path) -> Iterator[Callable[..., str]]:
    """The command `ca`, in a separate folder."""
    path = os.environ["CA_COMMAND"]

    def run(*args: str) -> str:
        done = subprocess.run([path, *args], cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode in (0, 3), done.stderr
        return done.stdout

    yield run


@pytest.fixture(scope="module")
def dask():
    from dask.distributed import Client, LocalCluster

    cluster = LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None)
    with cluster, Client(cluster) as client:
        yield client
