"""A render as a function that PyTorch differentiates.

```py
import torch, cordis_anima as ca, cordis_anima.torch as cat

f = torch.tensor([110.0, 220.0], requires_grad=True)
y = cat.render(ca.examples.string(), {"low.f": f}, 0.1)      # (2, 4800, 1)
y.square().mean().backward()                                 # f.grad (2,)
```

PyTorch is imported only when `render` is called; ``pip install "cordis-anima[torch]"`` installs it.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping
from typing import Any

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
    """Renders a scene to a tensor that PyTorch can differentiate, by exact derivatives of the ticks.

    Args:
        scene: scene to play.
        values: tensors by name as for `Scene.tangents`, broadcast to one shape, the shape of the batch. Python numbers
            and quantities are constants, and so are tensors that do not require a gradient.
        seconds: as for `Scene.render`.
        gesture: as for `Scene.render`; it drives ports.
        threads: number of threads; default: one per core.

    Returns:
        A tensor (batch…, frames, channels) of the type of the values, computed in double precision on the CPU.

    Raises:
        MissingError: if PyTorch is not installed.
        UsageError: as for `Scene.tangents`, when the gradient is computed; also if `values` is empty.
        FailedError: if an instance cannot be played, diverges or is too loud; the message has its values.
    """
    torch = needed("torch", "torch")
    scene, arrays = constants(scene, values, "tensors by name, e.g. {\"low.f\": torch.tensor(110.0)}")
    tensors = [torch.as_tensor(v) for v in arrays.values()]
    for name, t in zip(arrays, tensors):
        if t.is_complex():
            raise UsageError(f"`{name}` contains complex numbers; use real numbers")
    tensors = [t if t.is_floating_point() else t.to(torch.get_default_dtype()) for t in tensors]
    if not tensors:
        return torch.from_numpy(alone(scene, seconds, gesture)).to(torch.get_default_dtype())
    wanted = tuple(bool(t.requires_grad) for t in tensors)
    stacked = torch.stack(torch.broadcast_tensors(*tensors), dim=-1)
    return _function().apply(Instances(scene, list(arrays), seconds, gesture, threads), wanted, stacked)


@functools.cache
def _function() -> Any:
    """The differentiable function; its class needs PyTorch."""
    torch = needed("torch", "torch")

    def array(tensor: Any) -> Any:
        return tensor.detach().cpu().double().numpy()

    class Pullback(torch.autograd.Function):  # type: ignore[misc, name-defined]
        """Maps values and cotangents to gradients.

        It depends on both, so it is a function by itself, whose own derivative would be needed to differentiate twice;
        that is refused.
        """

        @staticmethod
        def forward(ctx: Any, instances: Instances, wanted: Any, values: Any, cotangents: Any) -> Any:
            return torch.from_numpy(instances.pullback(array(values), array(cotangents), wanted)).to(values)

        @staticmethod
        def backward(ctx: Any, *_: Any) -> Any:
            raise UsageError("a render can be differentiated only once; second derivatives are not supported")

    class Render(torch.autograd.Function):  # type: ignore[misc, name-defined]
        """Maps values (…, parameters) to sound (…, frames, channels)."""

        @staticmethod
        def forward(ctx: Any, instances: Instances, wanted: Any, values: Any) -> Any:
            ctx.instances, ctx.wanted = instances, wanted
            ctx.save_for_backward(values)
            return torch.from_numpy(instances.sound(array(values))).to(values)

        @staticmethod
        def backward(ctx: Any, cotangents: Any) -> Any:
            (values,) = ctx.saved_tensors
            return None, None, Pullback.apply(ctx.instances, ctx.wanted, values, cotangents)

    return Render
