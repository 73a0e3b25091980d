"""A render as a function that JAX differentiates, traces and maps.

```py
import jax, cordis_anima as ca, cordis_anima.jax as caj

loss = lambda f: (caj.render(ca.examples.string(), {"low.f": f}, 0.1) ** 2).mean()
value, slope = jax.value_and_grad(loss)(110.0)
slopes = jax.vmap(jax.grad(loss))(jax.numpy.array([110.0, 220.0]))
```

JAX is imported only when `render` is called; ``pip install "cordis-anima[jax]"`` installs it.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping
from typing import Any

import numpy as np

from ._analysis.differentiable import Instances, alone, constants
from ._errors import UsageError, needed
from ._gestures import Gesture
from ._scene import Scene

__all__ = ["render"]


def render(
    scene: Scene,
    values: Mapping[str, Any],
    seconds: float | str | None = None,
    *,
    gesture: Gesture = None,
    threads: int | None = None,
) -> Any:
    """Renders a scene to an array that JAX can differentiate, by exact derivatives of the ticks.

    Supports ``grad``, ``vjp`` and ``jacrev``, once; JAX refuses ``jacfwd`` and second derivatives.

    Args:
        scene: scene to play.
        values: arrays by name as for `Scene.tangents`, broadcast to one shape, the shape of the batch. Python numbers
            and quantities are constants.
        seconds: as for `Scene.render`.
        gesture: as for `Scene.render`; it drives ports.
        threads: number of threads; default: one per core.

    Returns:
        An array (batch…, frames, channels) of the type of the values. It is computed in double precision by a callback
        to this process, also under ``jit`` and ``vmap``.

    Raises:
        MissingError: if JAX is not installed.
        UsageError: as for `Scene.tangents`, when the gradient is computed; also if `values` is empty.
        FailedError: if an instance cannot be played, diverges or is too loud; the message has its values. JAX may wrap
            it in its own error.
    """
    jnp = needed("jax.numpy", "jax")
    scene, arrays = constants(scene, values, "arrays by name, e.g. {\"low.f\": jax.numpy.array(110.0)}")
    if not arrays:
        return jnp.asarray(alone(scene, seconds, gesture), jnp.result_type(float))
    real = {name: jnp.asarray(v) for name, v in arrays.items()}
    for name, v in real.items():
        if jnp.iscomplexobj(v):
            raise UsageError(f"`{name}` contains complex numbers; use real numbers")
    each = jnp.broadcast_arrays(*[v.astype(jnp.result_type(float, v)) for v in real.values()])
    return _function()(Instances(scene, list(arrays), seconds, gesture, threads), jnp.stack(each, axis=-1))


@functools.cache
def _function() -> Any:
    """The differentiable function."""
    jax = needed("jax", "jax")

    def called(f: Any, shape: tuple[int, ...], *args: Any) -> Any:
        dtype = args[0].dtype
        like = jax.ShapeDtypeStruct(shape, dtype)
        return jax.pure_callback(
            lambda *a: np.asarray(f(*(np.asarray(v) for v in a)), dtype), like, *args, vmap_method="broadcast_all"
        )

    @functools.partial(jax.custom_vjp, nondiff_argnums=(0,))
    def play(instances: Instances, values: Any) -> Any:
        return called(instances.sound, (*values.shape[:-1], instances.frames, instances.channels), values)

    def forward(instances: Instances, values: Any) -> Any:
        return play(instances, values), values

    def backward(instances: Instances, values: Any, cotangents: Any) -> Any:
        return (called(instances.pullback, values.shape, values, cotangents),)

    play.defvjp(forward, backward)
    return play
