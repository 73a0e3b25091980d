"""Bundled models as functions: ``examples.hammered_string()`` is ``load("hammered_string")``.

>>> import cordis_anima as ca
>>> ca.examples.hammered_string() == ca.load("hammered_string")
True
"""

from __future__ import annotations

from collections.abc import Callable

from . import _core
from ._scene import Scene


def string(f: float | str = "110 Hz", t60: float | str = "4 s") -> Scene:
    """A string struck by a flying hammer, built by calls, with one channel.

    >>> from cordis_anima import examples
    >>> r = examples.string().render(2)
    >>> r.audio.shape, r.sr, r.status
    ((96000, 1), 48000, 'ok')
    """
    from ._model import Model

    model = (
        Model(title="A struck string")
        .add("STRING", "low", n=40, f=f, t60=t60, m="1 g")
        .add("MAS", "hammer", m="20 g", x="-5 mm", v="1 m/s")
        .add("BUT", "strike", between=["hammer", "low[8]"], k="8 kN/m", z="0.2 N s/m")
        .add("SOX", "out", from_="low[3]", gain=800)
    )
    return model.compile()


def names() -> list[str]:
    """Returns the names of all bundled models.

    >>> from cordis_anima import examples
    >>> "rattle" in examples.names()
    True
    """
    return list(_core.bundled())


def parts() -> dict[str, str]:
    """Returns the names of all shipped parts, each with a one-line description; see ``Model.use``.

    >>> from cordis_anima import examples
    >>> examples.parts()["plectrum"]
    'a key that plucks a string with a plectrum'
    """
    return dict(_core.parts())


def _load(name: str) -> Scene:
    from ._model import Model

    return Model.load(name).compile()


def __getattr__(name: str) -> Callable[[], Scene]:
    if name not in _core.bundled():
        raise AttributeError(f"no bundled model `{name}`; `examples.names()` lists them all")

    def model() -> Scene:
        return _load(name)

    model.__name__ = name
    return model


def __dir__() -> list[str]:
    return ["names", "string", *_core.bundled()]
