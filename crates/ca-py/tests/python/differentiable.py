"""Renders that libraries differentiate; run by `tests/python/wheel` in an environment with the library.

python differentiable.py torch
python differentiable.py jax
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import cordis_anima as ca

STRING = ca.examples.string()
#: a hammer that arrives between two ticks, so that a small change does not move its first contact to another tick
START = {"hammer.v": 1.013, "hammer.m": 0.021, "low.f": 111.0}


def want(values: dict[str, float], seconds: float) -> tuple[float, dict[str, float]]:
    """The loss and its gradient, computed without these libraries."""
    g = STRING.replace(values).gradient(list(values), loss=lambda y: ((y**2).sum(), 2 * y), seconds=seconds)
    return float(g.loss or 0.0), {name: g[name] for name in values}


def by_torch() -> None:
    import torch

    import cordis_anima.torch as cat

    leaves = {name: torch.tensor(v, dtype=torch.float64, requires_grad=True) for name, v in START.items()}
    loss = cat.render(STRING, leaves, 0.02).square().sum()
    loss.backward()
    value, slopes = want(START, 0.02)
    assert abs(float(loss.detach()) - value) < 1e-12 * value
    for name, leaf in leaves.items():
        assert abs(float(leaf.grad) - slopes[name]) < 1e-12 * abs(slopes[name]), name

    batch = torch.tensor([1.013, 1.31, 0.7], dtype=torch.float64, requires_grad=True)
    mass = torch.tensor(0.021, dtype=torch.float64, requires_grad=True)
    f = lambda v, m: cat.render(STRING, {"hammer.v": v, "hammer.m": m}, 0.01)  # noqa: E731
    assert f(batch, mass).shape == (3, 480, 1)
    assert torch.autograd.gradcheck(f, (batch, mass), eps=1e-6, atol=1e-5, rtol=1e-4)
    single = cat.render(STRING, {"low.f": torch.tensor([[110.0], [220.0]])}, 0.01)
    assert single.dtype == torch.float32 and single.shape == (2, 1, 480, 1) and not single.requires_grad

    y = cat.render(STRING, {"hammer.v": batch}, 0.01)
    (slope,) = torch.autograd.grad(y.square().sum(), batch, create_graph=True)
    refused(lambda: slope.sum().backward(), ca.UsageError, "second derivatives")
    # a loss linear in the sound has a constant cotangent
    linear = cat.render(STRING, {"hammer.v": batch}, 0.01).mean()
    (slope,) = torch.autograd.grad(linear, batch, create_graph=True)
    refused(lambda: torch.autograd.grad(slope.sum(), batch), ca.UsageError, "second derivatives")
    refused(lambda: torch.autograd.functional.hessian(lambda v: cat.render(STRING, {"hammer.v": v}, 0.01).mean(), batch), ca.UsageError, "second derivatives")
    refused(lambda: cat.render(STRING, {}), ca.UsageError, "tensors by name")
    refused(lambda: cat.render(STRING, {"low.f": torch.tensor(1j)}), ca.UsageError, "complex")
    refused(lambda: cat.render(STRING, {"low.ff": batch}), ca.UsageError, "no parameter `ff`")
    # constants are not differentiated, be they Python numbers or tensors without a gradient
    for n in (40, torch.tensor(40.0)):
        cat.render(STRING, {"low.n": n, "hammer.v": batch}, 0.02).square().sum().backward()
    # one entry of a list, and a parameter written with a unit
    glass = torch.tensor([523.25], dtype=torch.float64, requires_grad=True)
    cat.render(ca.load("glass"), {"rim.f[0]": glass}, 0.01).sum().backward()
    assert torch.isfinite(glass.grad).all()
    refused(lambda: cat.render(STRING, {"hammer.m": torch.tensor([0.02, -1.0])}), ca.FailedError, "instance 1 .*hammer.m = -1")

    # learns the speed of a hammer from its sound
    target = cat.render(STRING, {"hammer.v": 1.2}, 0.02)
    v = torch.tensor(0.9, dtype=torch.float64, requires_grad=True)
    optimiser = torch.optim.LBFGS([v], lr=0.5, max_iter=40, line_search_fn="strong_wolfe")

    def closure() -> torch.Tensor:
        optimiser.zero_grad()
        off = (cat.render(STRING, {"hammer.v": v}, 0.02) - target).square().sum()
        off.backward()
        return off

    optimiser.step(closure)
    assert abs(float(v.detach()) - 1.2) < 1e-3, v


def by_jax() -> None:
    import jax
    import jax.numpy as jnp

    import cordis_anima.jax as caj

    jax.config.update("jax_enable_x64", True)

    def loss(values: dict[str, jax.Array]) -> jax.Array:
        return (caj.render(STRING, values, 0.02) ** 2).sum()

    value, slopes = want(START, 0.02)
    for function in (jax.value_and_grad(loss), jax.jit(jax.value_and_grad(loss))):
        got, found = function(START)
        assert abs(float(got) - value) < 1e-12 * value
        assert all(abs(float(found[name]) - slopes[name]) < 1e-12 * abs(slopes[name]) for name in START)
    many = {name: jnp.array([v, 1.07 * v, 0.93 * v]) for name, v in START.items()}
    found = jax.jit(jax.vmap(jax.grad(loss)))(many)
    for i in range(3):
        _, slopes = want({name: float(v[i]) for name, v in many.items()}, 0.02)
        assert all(abs(float(found[name][i]) - slopes[name]) < 1e-12 * abs(slopes[name]) for name in START)
    assert caj.render(STRING, {"low.f": jnp.array([110.0, 220.0])}, 0.01).shape == (2, 480, 1)
    refused(lambda: caj.render(STRING, {}), ca.UsageError, "arrays by name")
    refused(lambda: jax.jit(lambda v: caj.render(STRING, {"low.ff": v}))(1.0), ca.UsageError, "no parameter `ff`")
    refused(lambda: caj.render(STRING, {"low.f": jnp.array(1j)}), ca.UsageError, "complex")
    jax.grad(lambda v: (caj.render(STRING, {"hammer.v": v, "low.n": 40}, 0.02) ** 2).sum())(1.0)
    # half a sample is rounded up
    assert caj.render(ca.load("hammered_string", rate=44100), {"hammer.m": jnp.array(0.004)}, 0.125).shape == (5513, 2)
    refused(lambda: caj.render(STRING, {"hammer.m": jnp.array(-1.0)}, 0.01).block_until_ready(), Exception, "instance 0 .*hammer.m = -1")


def page(library: str) -> None:
    """Runs the README example of a library."""
    blocks = (Path(__file__).parents[2] / "README.md").read_text().split("```py\n")[1:]
    (block,) = [b.split("```")[0] for b in blocks if f"cordis_anima.{library}" in b]
    exec(compile(block, "README.md", "exec"), {"ca": ca, "np": np})


def refused(call: Callable[[], Any], kind: type[BaseException], says: str) -> None:
    """Checks that a call is refused with these words."""
    try:
        call()
    except kind as e:
        assert re.search(says, str(e), re.DOTALL), e
    else:
        raise AssertionError(f"it is not refused: {says}")


if __name__ == "__main__":
    np.seterr(all="raise", under="ignore")
    {"torch": by_torch, "jax": by_jax}[sys.argv[1]]()
    page(sys.argv[1])
    print(f"{sys.argv[1]}: gradients through renders hold")
