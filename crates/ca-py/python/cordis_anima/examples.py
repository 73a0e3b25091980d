"""The bundled models, as functions: ``examples.hammered_string()`` is ``load("hammered_string")``."""

from __future__ import annotations

from collections.abc import Callable

from . import _core
from ._scene import Scene


def string() -> Scene:
    """A plucked string, one channel.

    >>> from cordis_anima import examples
    >>> r = examples.string().render(2)
    >>> r.audio.shape, r.sr
    ((96000, 1), 48000)
    """
    return _load("plucked_string")


def names() -> list[str]:
    """Names of all of them.

    >>> from cordis_anima import examples
    >>> "rattle" in examples.names()
    True
    """
    return list(_core.bundled())


def _load(name: str) -> Scene:
    from ._model import Model

    return Model.load(name).compile()


def __getattr__(name: str) -> Callable[[], Scene]:
    if name not in _core.bundled():
        raise AttributeError(f"no bundled model `{name}`; `examples.names()` has them all")

    def model() -> Scene:
        return _load(name)

    model.__name__ = name
    return model


def __dir__() -> list[str]:
    return ["names", "string", *_core.bundled()]
