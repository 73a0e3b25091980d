"""A render as a function that JAX differentiates, traces and maps.

```py
import jax, cordis_anima as ca, cordis_anima.jax as caj

loss = lambda f: (caj.render(ca.examples.string(), {"low.f": f}, 0.1) ** 2).mean()
value, slope = jax.value_and_grad(loss)(110.0)
slopes = jax.vmap(jax.grad(loss))(jax.numpy.array([110.0, 220.0]))
```

Nothing of JAX is loaded before `render` is called; ``pip install "cordis-anima[jax]"`` adds it.
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
    """The sound of a scene as an array that knows its gradients: by the ticks' own derivatives. For ``grad``, ``vjp`` and ``jacrev``,
    once; ``jacfwd`` and second derivatives are refused by JAX.

    Args:
        scene: what is played.
        values: by name, as `Scene.tangents` knows them, arrays that are broadcast to one shape: that of the batch. Numbers and
            quantities of Python are values that stay.
        seconds: as for `Scene.render`.
        gesture: as for `Scene.render`; it drives ports.
        threads: how many play at once; one for each core if none.

    Returns:
        An array (batch…, frames, channels) of the values' type; it was computed in double precision, by a callback to this
        process, also under ``jit`` and ``vmap``.

    Raises:
        MissingError: JAX is not installed.
        UsageError: as `Scene.tangents`, when the gradient is asked for; no values.
        FailedError: an instance cannot be played, diverges or is too loud, with its values; JAX may show it within an error of
            its own.
    """
    jnp = needed("jax.numpy", "jax")
    scene, arrays = constants(scene, values, "arrays by name, e.g. {\"low.f\": jax.numpy.array(110.0)}")
    if not arrays:
        return jnp.asarray(alone(scene, seconds, gesture), jnp.result_type(float))
    real = {name: jnp.asarray(v) for name, v in arrays.items()}
    for name, v in real.items():
        if jnp.iscomplexobj(v):
            raise UsageError(f"`{name}` holds complex numbers: real numbers are wanted")
    each = jnp.broadcast_arrays(*[v.astype(jnp.result_type(float, v)) for v in real.values()])
    return _function()(Instances(scene, list(arrays), seconds, gesture, threads), jnp.stack(each, axis=-1))


@functools.cache
def _function() -> Any:
    """The function that is differentiated."""
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
