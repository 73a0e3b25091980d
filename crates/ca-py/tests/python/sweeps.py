"""Shared by tests of sweeps: a model, varied parameters, and a comparison of sweeps."""

import os
import pickle
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import cordis_anima as ca

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
