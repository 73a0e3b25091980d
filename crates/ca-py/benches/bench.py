"""Threads, overheads and peers: ratios of alternating time measurements within one run.

Every figure is the fastest of several rounds, in which the compared calls alternate. The peers play exactly the string
of `tests/peers/string.dsp`: 24 masses between two walls, pushed once.
"""

from __future__ import annotations

import os
import platform
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import batches
import by_numba
import by_numpy
import numpy as np

import cordis_anima as ca
from joblib.externals.loky import get_reusable_executor as get_executor

ROOT = Path(__file__).resolve().parents[3]
HERE = Path(__file__).resolve().parent
RATE = 48000
ROUNDS = 7


def timed(work: Callable[[], object]) -> float:
    begin = time.perf_counter()
    work()
    return time.perf_counter() - begin


def in_turn(works: Sequence[Callable[[], object]], rounds: int = ROUNDS) -> list[float]:
    """Returns the fastest time of each [s], measured in alternation."""
    best = [float("inf")] * len(works)
    for _ in range(rounds):
        for k, work in enumerate(works):
            best[k] = min(best[k], timed(work))
    return best


def threads() -> tuple[float, float]:
    """Speed-up of two threads over one, and of one thread in a pool over none."""
    scene = ca.load("plate")
    jobs = 8

    def alone() -> None:
        for _ in range(jobs):
            scene.render(1.0)

    def pool(n: int) -> Callable[[], None]:
        def work() -> None:
            with ThreadPoolExecutor(n) as all:
                list(all.map(lambda _: scene.render(1.0), range(jobs)))

        return work

    one, two, none = in_turn([pool(1), pool(2), alone], 21)
    return one / two, none / one


def overheads() -> dict[str, float]:
    """Times of the smallest calls [µs]."""
    scene = ca.load("hammered_string")
    sim = scene.open(block=16)
    out = np.zeros((16, 2), np.float32)
    force = np.zeros((16, 1))
    calls: dict[str, tuple[Callable[[], object], int]] = {
        "`render` of one sample": (lambda: scene.render(1 / RATE), 200),
        "`replace`, which compiles again": (lambda: scene.replace({"hammer.m": "30 g"}), 20),
        "`step` of 16 samples into given arrays": (lambda: sim.step(out=out, force=force), 2000),
        "`ca.load` of a bundled model": (lambda: ca.load("hammered_string"), 20),
    }

    def many(call: Callable[[], object], n: int) -> Callable[[], None]:
        def work() -> None:
            for _ in range(n):
                call()

        return work

    times = in_turn([many(*c) for c in calls.values()])
    return {name: 1e6 * t / n for (name, (_, n)), t in zip(calls.items(), times)}


def sweeps() -> dict[str, float]:
    """Overhead of a run in a sweep [µs], and the speed-up by two threads."""
    scene = ca.examples.string()
    vary = {"hammer.m": ca.Range(0.01, 0.03)}
    runs = 400

    def sweep(**more: object) -> Callable[[], object]:
        return lambda: ca.sweep(scene, vary, runs, **more)  # type: ignore[arg-type]

    one, two = ThreadPoolExecutor(1), ThreadPoolExecutor(2)
    with tempfile.TemporaryDirectory() as folder, one, two, get_executor(2) as processes:
        count = iter(range(1000))
        tick = {"seconds": 1 / RATE, "measure": False}

        def files(audio: str) -> Callable[[], object]:
            return lambda: sweep(to=f"{folder}/{next(count)}", audio=audio, executor=one, seconds=0.1, measure=False)()

        works = {
            "in memory, one thread": sweep(executor=one, **tick),
            "in memory, processes of loky": sweep(executor=processes, **tick),
            "0.1 s": sweep(executor=one, seconds=0.1, measure=False),
            "0.1 s, measured": sweep(executor=one, seconds=0.1, measure=True),
            "0.1 s, rows in a folder": files("none"),
            "0.1 s, WAV": files("wav"),
            "0.1 s, FLAC": files("flac"),
            "1 s, one thread": sweep(executor=one, seconds=1.0, measure=False),
            "1 s, two threads": sweep(executor=two, seconds=1.0, measure=False),
        }
        times = in_turn(list(works.values()), 7)
    return {name: 1e6 * t / runs for name, t in zip(works, times)}


def ours() -> ca.Scene:
    """The string in per-sample units: k T² = 0.25, z T = 2e-3 and 1e-4 for a mass of 1."""
    per_tick = 1 / RATE
    m = ca.Model().add("SOL", "l").add("SOL", "r").add("ENF", "push", to="p5")
    for i in range(24):
        m.add("CEL", f"p{i}", m=1, k=0, z=1e-4 / per_tick)
    for i in range(25):
        ends = ["l" if i == 0 else f"p{i - 1}", "r" if i == 24 else f"p{i}"]
        m.add("REF", f"s{i}", between=ends, k=0.25 / per_tick**2, z=2e-3 / per_tick)
    return m.add("SOX", "a", from_="p3").add("SOX", "b", from_="p19").compile(rate=RATE)


FAUST_MAIN = """
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <vector>
struct Meta { void declare(const char*, const char*) {} };
struct UI { void openVerticalBox(const char*) {} void closeBox() {} };
struct dsp {};
#define FAUSTFLOAT double
<<includeIntrinsic>>
<<includeclass>>
int main(int, char** argv) {
    int n = std::atoi(argv[1]);
    std::vector<double> in(n), a(n), b(n);
    double* ins[] = {in.data()};
    double* outs[] = {a.data(), b.data()};
    double best = 1e9;
    for (int turn = 0; turn < 7; turn++) {
        in[0] = 1e-3;
        mydsp d;
        d.init(48000);
        auto begin = std::chrono::steady_clock::now();
        for (int i = 0; i < n; i += 512) {
            double* x[] = {ins[0] + i};
            double* y[] = {outs[0] + i, outs[1] + i};
            d.compute(n - i < 512 ? n - i : 512, x, y);
        }
        std::chrono::duration<double> t = std::chrono::steady_clock::now() - begin;
        if (t.count() < best) best = t.count();
    }
    std::printf("%.9e %.17g\\n", best, b[n - 1]);
}
"""


def faust(work: Path) -> Path | None:
    """Compiles the string with Faust's mi.lib; None without Faust."""
    if not shutil.which("faust") or not shutil.which("g++"):
        return None
    (work / "main.cpp").write_text(FAUST_MAIN)
    dsp = ROOT / "tests/peers/string.dsp"
    subprocess.run(["faust", "-double", "-a", work / "main.cpp", dsp, "-o", work / "string.cpp"], check=True)
    subprocess.run(["g++", "-O3", "-march=native", work / "string.cpp", "-o", work / "string"], check=True)
    return work / "string"


def first_sound(script: str) -> float:
    """Time for a new interpreter to compute one second of sound [s]."""
    run = [sys.executable, "-c", script]
    return min(timed(lambda: subprocess.run(run, check=True, cwd=HERE, stdout=subprocess.DEVNULL)) for _ in range(3))


def peers() -> list[tuple[str, float, float]]:
    """Name, ns per sample, and seconds to the first second of sound."""
    n = RATE
    push = np.zeros(n)
    push[0] = 1e-3
    scene = ours()
    want = by_numpy.play(2000, push)
    got = scene.render(2000 / RATE, gesture={"push": push / (1 / RATE) ** 2}, probes=["p3", "p19"])
    apart = np.abs(np.stack([got.probes["p3"], got.probes["p19"]], axis=1) - want).max() / np.abs(want).max()
    assert apart < 1e-9, apart
    assert np.abs(by_numba.play(2000, push) - want).max() / np.abs(want).max() < 1e-9
    times = in_turn([lambda: scene.render(1.0), lambda: by_numba.play(n, push)])
    slow = in_turn([lambda: by_numpy.play(n, push)], 2)
    shared = "import numpy as np; push = np.zeros(48000); push[0] = 1e-3; "
    rows = [
        ("cordis-anima", times[0], first_sound("import cordis_anima as ca; ca.examples.string().render(1.0)")),
        ("loops by numba", times[1], first_sound(shared + "import by_numba; by_numba.play(48000, push)")),
        ("arrays by NumPy", slow[0], first_sound(shared + "import by_numpy; by_numpy.play(48000, push)")),
    ]
    with tempfile.TemporaryDirectory() as folder:
        work = Path(folder)
        begin = time.perf_counter()
        program = faust(work)
        if program is not None:
            subprocess.run([program, "48000"], check=True, stdout=subprocess.DEVNULL)
            first = time.perf_counter() - begin
            reported = subprocess.run([program, str(n)], check=True, capture_output=True, text=True).stdout.split()
            rows.append(("Faust's mi.lib to C++, `-O3 -march=native`", float(reported[0]), first))
    return [(name, 1e9 * t / n, first) for name, t, first in rows]


def machine() -> str:
    cpu = next((l.split(":")[1].strip() for l in open("/proc/cpuinfo") if l.startswith("model name")), platform.machine())
    return f"{cpu}, {os.cpu_count()} cores, Python {platform.python_version()}, NumPy {np.__version__}"


def main() -> None:
    two, pooled = threads()
    calls = overheads()
    runs = sweeps()
    batch = batches.table(in_turn)
    rows = peers()
    own = rows[0]
    lines = [
        "# The Python package, measured",
        "",
        "Written by `UPDATE=1 crates/ca-py/benches/run`; every figure is the fastest of several turns, and compared programs take",
        f"turns. {machine()}; shared with others, so figures differ by a tenth and more from run to run.",
        "",
        "## Threads",
        "",
        f"Renders of `plate` by two threads on two idle cores: **{two:.2f} ×** as fast as by one thread (limit: 1.8).",
        f"A pool of one thread costs {100 * (1 / pooled - 1):+.1f} % compared with no pool.",
        "",
        "## What a call costs",
        "",
        "| call | µs |",
        "|---|---|",
        *(f"| {name} | {us:.3g} |" for name, us in calls.items()),
        "",
        "## Runs of a sweep",
        "",
        "400 runs of a struck string of 41 masses; time per run.",
        "",
        "| | µs |",
        "|---|---|",
        f"| compiled, drawn, hashed, a row: one thread, one sample long | {runs['in memory, one thread']:.0f} |",
        f"| the same by two processes of loky | {runs['in memory, processes of loky']:.0f} |",
        f"| playing 0.1 s adds | {runs['0.1 s'] - runs['in memory, one thread']:.0f} |",
        f"| pitch and decay of it add | {runs['0.1 s, measured'] - runs['0.1 s']:.0f} |",
        f"| rows in a folder add | {runs['0.1 s, rows in a folder'] - runs['0.1 s']:.0f} |",
        f"| sounds as WAV add to that | {runs['0.1 s, WAV'] - runs['0.1 s, rows in a folder']:.0f} |",
        f"| sounds as FLAC add to that | {runs['0.1 s, FLAC'] - runs['0.1 s, rows in a folder']:.0f} |",
        "",
        f"Runs of one second by two threads: {runs['1 s, one thread'] / runs['1 s, two threads']:.2f} × as fast as by one thread.",
        "",
        "## Batches",
        "",
        "Instances of one scene with other values by `ca.batch`, two threads, compared with a pool of two threads that replace and render;",
        "the bits are the same. Several small instances are played at a time as one scene; large ones are played separately.",
        "",
        "| scene | each [s] | instances | ms an instance | times as fast as the pool |",
        "|---|---|---|---|---|",
        *(f"| {name} | {seconds:g} | {n} | {ms:.3g} | {times:.2f} |" for name, seconds, n, ms, times in batch),
        "",
        "## Peers",
        "",
        "A string of 24 masses with dampers, pushed once: time per sample, and from the start (of an interpreter, or of a",
        "compiler) to one second of sound. NumPy, numba and the package agree to 1e-9; `tests/suite/outside/peers.rs` compares with",
        "mi.lib. numba and Faust compile one network each; the package plays any network without a compiler.",
        "",
        "| | ns/sample | over ours | first second [s] | over ours |",
        "|---|---|---|---|---|",
        *(f"| {name} | {ns:.0f} | {ns / own[1]:.2f} | {first:.2f} | {first / own[2]:.2f} |" for name, ns, first in rows),
        "",
    ]
    page = "\n".join(lines)
    print(page)
    if os.environ.get("UPDATE"):
        (ROOT / "docs/measured/python.md").write_text(page)
    if two < 1.8:
        print(f"two threads make only {two:.2f} times what one makes; is the machine idle?", file=sys.stderr)


if __name__ == "__main__":
    main()
