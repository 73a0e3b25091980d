"""Learns the numbers of 64 strings at once with PyTorch: by the engine's derivatives, and by ticks written as tensors.

Both minimise the same loss from the same start with the same optimiser, so only time and rounding differ. The tensor
program covers one network of one kind, without contacts, friction or other methods.
"""

from __future__ import annotations

import os
import platform
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import torch

import cordis_anima as ca
import cordis_anima.torch as cat

ROOT = Path(__file__).resolve().parents[3]
MASSES, INSTANCES, STEPS, SECONDS = 24, 64, int(os.environ.get("STEPS", "200")), 0.05
K, Z, M, T = 1000.0, 2e-3, 1e-3, 1 / 48000


def scene() -> ca.Scene:
    """A string of masses between two walls, one of them thrown; stiffness and viscosity are parameters."""
    ends = ["l", *(f"p{i}" for i in range(MASSES)), "r"]
    text = f'[param]\nk = "{K} N/m"\nz = "{Z} N s/m"\n[SOL]\nl = {{}}\nr = {{}}\n[MAS]\n'
    text += "".join(f"p{i} = {{ m = {M}, v = {1.0 if i == 5 else 0.0} }}\n" for i in range(MASSES))
    text += "[REF]\n"
    text += "".join(f's{i} = {{ between = ["{a}", "{b}"], k = "k", z = "z" }}\n' for i, (a, b) in enumerate(zip(ends, ends[1:])))
    return ca.parse(text + '[SOX]\nout = { from = "p3", gain = 500 }\n')


def by_hand(k: torch.Tensor, z: torch.Tensor, frames: int) -> torch.Tensor:
    """The same string as tensors (instances, masses), tick by tick."""
    x = torch.zeros(len(k), MASSES + 2, dtype=torch.float64)
    stiff, loss = (k * T * T / M)[:, None], (z * T / M)[:, None]
    d = torch.zeros_like(x)
    d[:, 6] = T
    # the motion into the first tick includes half a tick of viscosity
    d = d - torch.nn.functional.pad(torch.diff(loss * torch.diff(d, dim=1), dim=1), (1, 1)) / 2
    heard = []
    for _ in range(frames):
        heard.append(500 * x[:, 4])
        force = stiff * torch.diff(x, dim=1) + loss * torch.diff(d, dim=1)
        d = d + torch.nn.functional.pad(torch.diff(force, dim=1), (1, 1))
        x = x + d
    return torch.stack(heard, dim=1)[..., None]


def learn(play: Callable[[torch.Tensor, torch.Tensor], torch.Tensor], target: torch.Tensor, steps: int) -> tuple[float, Any]:
    """Returns the seconds for `steps` steps, and the logarithms of the found values relative to the hidden ones."""
    draw = np.random.default_rng(1)
    start = np.stack([draw.uniform(-0.01, 0.01, INSTANCES), draw.uniform(-0.5, 0.5, INSTANCES)])
    logs = torch.tensor(start, requires_grad=True)
    optimiser = torch.optim.Adam([{"params": [logs]}], lr=2e-3)
    begin = time.perf_counter()
    for _ in range(steps):
        optimiser.zero_grad()
        (play(K * logs[0].exp(), Z * logs[1].exp()) - target).square().mean().mul(1e3).backward()
        optimiser.step()
    return time.perf_counter() - begin, logs.detach().numpy()


def main() -> None:
    s = scene()
    frames = round(SECONDS / T)
    target = torch.from_numpy(s.render(SECONDS, dtype="float64").audio)
    hand: Callable[[torch.Tensor, torch.Tensor], torch.Tensor] = lambda k, z: by_hand(k, z, frames)
    ours: Callable[[torch.Tensor, torch.Tensor], torch.Tensor] = lambda k, z: cat.render(s, {"k": k, "z": z}, SECONDS)
    # both give the same sound and the same gradient
    at = [torch.tensor([1.003 * v, 1.01 * v], dtype=torch.float64, requires_grad=True) for v in (K, Z)]
    sounds = [f(*at) for f in (hand, ours)]
    apart = float((sounds[0] - sounds[1]).detach().abs().max() / target.abs().max())
    gradients = [torch.autograd.grad((y - target).square().sum(), at) for y in sounds]
    off = max(float(((a - b) / a).abs().max()) for a, b in zip(*gradients))
    assert apart < 1e-9 and off < 1e-6, (apart, off)
    rows = []
    for name, play in [("`cordis_anima.torch.render`", ours), ("ticks in tensors, PyTorch", hand)]:
        took, found = learn(play, target, STEPS)
        rows.append((name, took, 1200 / np.log(2) * np.abs(found[0]).max() / 2, 100 * np.abs(np.expm1(found[1])).max()))
    cpu = next((l.split(":")[1].strip() for l in open("/proc/cpuinfo") if l.startswith("model name")), platform.machine())
    page = "\n".join(
        [
            "# Learning through renders",
            "",
            f"Written by `UPDATE=1 crates/ca-py/benches/learn`. {cpu}, {os.cpu_count()} cores, Python {platform.python_version()},",
            f"PyTorch {torch.__version__.split('+')[0]}; shared with others, so figures differ by a tenth and more from run to run.",
            "",
            f"Stiffness and viscosity of {INSTANCES} strings of {MASSES} masses, from starts up to 9 cents and a factor of 1.6 off, by {STEPS} steps of",
            f"Adam, each through {INSTANCES} renders of {SECONDS} s in double precision and back. The sound of both differs by",
            f"{apart:.0e} of its peak, the gradients by {off:.0e}.",
            "",
            "| | seconds | pitch off, worst [cents] | viscosity off, worst [%] |",
            "|---|---|---|---|",
            *(f"| {name} | {took:.0f} | {cents:.2g} | {percent:.2g} |" for name, took, cents, percent in rows),
            "",
            f"{rows[1][1] / rows[0][1]:.1f} times as fast. The tensors are written for this one string; the engine's function takes any scene, with",
            "contacts and friction, and its memory grows with the square root of the length of the sound.",
            "",
        ]
    )
    print(page)
    if os.environ.get("UPDATE"):
        (ROOT / "docs/measured/learning.md").write_text(page)


if __name__ == "__main__":
    main()
