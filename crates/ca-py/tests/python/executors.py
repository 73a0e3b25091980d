"""Compares a sweep with workers of Ray or MPI with one by threads; run by `tests/python/wheel`.

python executors.py ray
mpiexec -n 3 python -m mpi4py.futures executors.py mpi
"""

from __future__ import annotations

import concurrent.futures
import sys
import tempfile
from concurrent.futures import Executor
from pathlib import Path
from typing import Any

import numpy as np

import cordis_anima as ca

VARY = {"low.f": ca.Range("110 Hz", "440 Hz", log=True), "hammer.m": ["10 g", "20 g", "-1 g"]}


def by_ray() -> Executor:
    import ray

    ray.init(num_cpus=2, log_to_driver=False, include_dashboard=False)
    # as in the README
    page = (Path(__file__).parents[2] / "README.md").read_text()
    block = page.split("```py\n")[1].split("```")[0]
    space: dict[str, Any] = {"ray": ray, "concurrent": concurrent}
    exec(compile(block, "README.md", "exec"), space)
    made: Executor = space["Ray"]()
    return made


def by_mpi() -> Executor:
    from mpi4py.futures import MPIPoolExecutor

    made: Executor = MPIPoolExecutor()
    return made


def place() -> str:
    """Identifies this process."""
    import os

    return f"{os.uname().nodename} {os.getpid()}"


def main(name: str) -> None:
    scene = ca.examples.string()
    with {"ray": by_ray, "mpi": by_mpi}[name]() as executor:
        workers = {f.result() for f in [executor.submit(place) for _ in range(64)]}
        assert place() not in workers, "it is computed elsewhere"
        here = ca.sweep(scene, VARY, 200, seconds=0.1, audio=True)
        there = ca.sweep(scene, VARY, 200, seconds=0.1, audio=True, executor=executor, batch=7)
        assert set(here.counts) == {"ok", "invalid"} and here.audio and there.audio
        for column in here:
            if column not in ("run_time", "rtf"):
                assert np.array_equal(here[column].astype(str), there[column].astype(str)), column
        assert all(np.array_equal(a, b) for a, b in zip(here.audio, there.audio, strict=True))
        with tempfile.TemporaryDirectory() as folder:
            for to, by in [("here", None), ("there", executor)]:
                ca.sweep(scene, VARY, 200, seconds=0.1, to=Path(folder, to), chunk=9, executor=by)
            files = [p.relative_to(Path(folder, "here")) for p in Path(folder, "here").rglob("*.flac")]
            assert len(files) == here.counts["ok"]
            for file in [*files, Path("manifest.parquet")]:
                assert Path(folder, "here", file).read_bytes() == Path(folder, "there", file).read_bytes(), file
    print(f"{name}: {len(workers)} workers, {there.runs} runs and {len(files)} files as by threads")


if __name__ == "__main__":
    main(sys.argv[1])
