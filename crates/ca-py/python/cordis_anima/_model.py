"""Models as written by an author, in a file or by calls."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from . import _core
from ._errors import Diagnostic, ModelError, diagnostics
from ._results import number
from ._results import value as _value
from ._scene import Scene


@dataclass(frozen=True, repr=False)
class Check:
    """Result of checking a model.

    Attributes:
        ok: true if it compiles.
        diagnostics: all findings, in order of place.
        text: the findings as text, with their source lines.
    """

    ok: bool
    diagnostics: tuple[Diagnostic, ...]
    text: str

    def __bool__(self) -> bool:
        return self.ok

    def __repr__(self) -> str:
        return self.text.rstrip() or "no findings"


class Model:
    """A model under construction: kinds, names and values as written. `compile` interprets them.

    It writes the same files as an author would. Most methods return the model, so calls can be chained.

    >>> import cordis_anima as ca
    >>> m = ca.Model(title="A bob on a spring")
    >>> m = (m.add("SOL", "wall")
    ...       .add("MAS", "bob", m="1 g", dx0="1 mm")
    ...       .add("REF", "spring", between=["wall", "bob"], k="7.6 kN/m", z="5 mN s/m")
    ...       .add("SOX", "out", from_="bob", gain=1000))
    >>> m.compile().render(0.1).audio.shape
    (4800, 1)
    >>> print(m.to_toml().splitlines()[1])
    title = "A bob on a spring"
    """

    __slots__ = ("_core",)
    __hash__ = None  # type: ignore[assignment]

    def __init__(self, title: str = "", *, seconds: float | str | None = None) -> None:
        self._core = _core.Model()
        if title:
            self.put("model", "title", title)
        if seconds is not None:
            self.put("model", "seconds", number("seconds", seconds, "s"))

    @classmethod
    def _of(cls, core: _core.Model) -> Model:
        made = cls.__new__(cls)
        made._core = core
        return made

    @classmethod
    def of(cls, scene: Scene) -> Model:
        """Returns a copy of the model that a scene was compiled from, to change and compile again.

        >>> import cordis_anima as ca
        >>> ca.Model.of(ca.load("rattle")).title
        'The rattle, on two keys'
        """
        return cls._of(scene._model.copy())

    @classmethod
    def load(cls, source: str | os.PathLike[str]) -> Model:
        """Reads a file ``*.ca.toml``, a MIMS file ``*.mdl``, or a bundled model by its name."""
        return cls._of(_core.Model.open(os.fspath(source)))

    @classmethod
    def parse(cls, text: str, file: str = "model.ca.toml") -> Model:
        """Reads the text of a model; `file` is its name in findings, and the base of files it refers to."""
        return cls._of(_core.Model.read(text, file))

    @classmethod
    def from_mims(cls, text: str, file: str = "model.mdl") -> Model:
        """Imports the text of a MIMS model.

        >>> import cordis_anima as ca
        >>> m = ca.Model.from_mims("@m1 mass 1. 0. 0.\\n@g ground 0.\\n@s spring @m1 @g 0.01 0.001\\n@o posOutput @m1\\n")
        >>> m.check().ok
        True
        """
        return cls._of(_core.Model.mims(text, file))

    def add(self, kind: str, name: str, **values: object) -> Model:
        """Adds a module.

        Args:
            kind: code of the kind, such as ``"MAS"``; see `kinds`.
            name: unique name; ``"a.b"`` is in the group ``a``.
            values: parameters as numbers in SI units, quantities, names or lists. A trailing underscore is removed, so
                that ``from_`` can stand for the reserved word ``from``.

        Raises:
            UsageError: if the kind or a parameter does not exist (the message suggests the nearest), if the name is in
                use or has characters other than letters from a to z, digits and underscores, or if a value is invalid.

        >>> import cordis_anima as ca
        >>> ca.Model().add("MAS", "bob", m="1 g").add("SOX", "out", from_="bob").items
        (('MAS', 'bob'), ('SOX', 'out'))
        """
        self._core.add(kind, name, _entries(name, values))
        return self

    def group(self, name: str, **values: object) -> Model:
        """Adds a group of modules that share a medium or a space. Give all of its properties at once.

        >>> import cordis_anima as ca
        >>> m = ca.Model().group("hall", dim=3, gravity=9.81).add("MAS", "hall.ball", m="10 g")
        >>> m.add("SOX", "out", from_="hall.ball", along="z").check().ok
        True
        """
        self._core.group(name, _entries(name, values))
        return self

    def use(
        self, name: str, part: str | Model, *, n: int | None = None, of: Model | None = None, **values: object
    ) -> Model:
        """Adds instances of a part.

        Args:
            name: name of the instance, or of each as ``name[0]`` to ``name[n - 1]`` with `n`.
            part: name of a part of this model, of the model `of`, or of the shipped parts (``examples.parts()``); or
                another model, used as a whole.
            n: number of instances; a list among the values then has one entry for each.
            of: model that has the part.
            values: parameters of the part.

        Raises:
            UsageError: if the part does not exist, a value is missing or unknown, a list has the wrong length, or the
                name is in use.

        >>> import cordis_anima as ca
        >>> tine = ca.Model().param("f", unit="Hz").add("CEL", "bar", m="1 g", f="f", t60="2 s", dx0="1 mm")
        >>> m = ca.Model().use("tine", tine, n=3, f=["C4", "E4 -14 c", "392 Hz"])
        >>> m.add("SOX", "out", from_="tine[*].bar", channel=0).check().ok
        True
        >>> m.items[2]
        ('CEL', 'tine[2].bar')
        >>> m.use("thumb", "plectrum", on="tine[0].bar", note="C4").check().ok
        True
        """
        source = part if isinstance(part, Model) else of
        word = part if isinstance(part, str) else ""
        self._core.use_part(name, word, None if source is None else source._core, n, _entries(name, values))
        return self

    def param(self, name: str, value: object = None, **about: object) -> Model:
        """Adds or replaces a parameter.

        The ends of its range are quantities like its value, or numbers in its ``unit``. A parameter driven by a port
        has ``port``, ``span``, ``min`` and ``max`` instead of a value.

        >>> import cordis_anima as ca
        >>> m = ca.Model().param("k", "3 kN/m", live=True, min="100 N/m", max="9 kN/m", doc="stiffness")
        >>> m = m.param("felt", 0, live=True, min=0, max=1, unit="N s/m")
        >>> m = m.add("CEL", "bar", m="1 g", k="k", z="felt", dx0="1 mm").add("SOX", "out", from_="bar")
        >>> m.compile().params["k"].min
        100.0
        >>> m = m.param("felt", port="press", span=[0, "20 mm"], min=0, max="1 N s/m").add("ENX", "press")
        >>> [p.name for p in m.compile().inputs], list(m.compile().params)
        (['press'], ['k'])
        """
        full = about if value is None else {"value": value, **about}
        return self.put("param", name, full if about else value)

    def gesture(self, name: str, points: object) -> Model:
        """Sets the built-in gesture of a port or a live parameter: a list of times [s] and values.

        >>> import cordis_anima as ca
        >>> m = ca.Model().add("ENF", "push", to="bar").add("CEL", "bar", m="1 g", f="440 Hz").add("SOX", "out", from_="bar")
        >>> m.gesture("push", [[0, 0], ["1 ms", "1 N"], ["2 ms", 0]]).compile().render(0.1).status
        'ok'
        """
        return self.put("gesture", name, points)

    def preset(self, name: str, values: Mapping[str, object]) -> Model:
        """Values of live parameters that are chosen together, under a name. See ``Scene.presets``."""
        return self.put("preset", name, dict(values))

    def put(self, section: str, key: str, value: object) -> Model:
        """Writes an entry of ``model``, ``rate``, ``param``, ``gesture``, ``preset`` or ``equivalence``."""
        self._core.put(section, key, _value(key, value))
        return self

    def set(self, name: str, value: object) -> Model:
        """Sets an existing parameter, as ``ca render --set`` does.

        >>> import cordis_anima as ca
        >>> ca.Model.load("hammered_string").set("hammer.m", "30 g").check().ok
        True
        """
        self._core.set(name, _value(name, value))
        return self

    @property
    def title(self) -> str:
        """Title of the model."""
        return self._core.title

    @property
    def name(self) -> str:
        """Name of its file without folder and extension."""
        return self._core.name

    @property
    def file(self) -> str:
        """File it was read from; empty if it was built by calls."""
        return self._core.file

    @property
    def items(self) -> tuple[tuple[str, str], ...]:
        """Kinds and names of its modules, in order."""
        return tuple(self._core.items)

    def check(self, *, rate: float | str | None = None) -> Check:
        """Compiles without playing and returns all findings.

        >>> import cordis_anima as ca
        >>> c = ca.Model().add("MAS", "bob", m="20 gr").check()
        >>> c.ok, c.diagnostics[0].code
        (False, 'E007')
        """
        ok, found, text = self._core.check(None if rate is None else number("rate", rate, "Hz"))
        return Check(ok, diagnostics(found), text)

    def compile(self, *, rate: float | str | None = None, exact: bool = False) -> Scene:
        """Compiles a scene.

        Args:
            rate: sound rate [Hz]; default: the rate of the model.
            exact: compute the largest eigenvalue for the certificate.

        Raises:
            ModelError: if the model has errors.
        """
        return Scene._of(self._core.copy(), rate, exact)

    def to_toml(self) -> str:
        """Returns the text of a readable model file; of the comments only those at its head are kept."""
        return self._core.toml()

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes it to a file ``*.ca.toml``."""
        Path(path).write_text(self.to_toml(), encoding="utf-8")

    def copy(self) -> Model:
        """Returns an equal model."""
        return Model._of(self._core.copy())

    def __eq__(self, other: object) -> bool:
        """Returns true if the same values are written in the same order. A model with errors equals only itself."""
        if self is other or not isinstance(other, Model):
            return self is other
        try:
            return self._core.bytes() == other._core.bytes()
        except ModelError:
            return False

    def __copy__(self) -> Model:
        return self.copy()

    def __deepcopy__(self, memo: object) -> Model:
        return self.copy()

    def __reduce__(self) -> tuple[Any, ...]:
        return (_again, (self._core.bytes(), self._core.name))

    def __repr__(self) -> str:
        return f"<Model {self.title or self.name or 'untitled'!r}: {len(self._core.items)} modules>"


def _entries(name: str, values: Mapping[str, object]) -> list[tuple[str, Any]]:
    """Parameters of a module or part, under the names used in models."""
    keys = ((k.rstrip("_"), v) for k, v in values.items())
    return [(k, _value(f"{name}.{k}", v)) for k, v in keys]


def _again(data: bytes, name: str) -> Model:
    """Restores a pickled model."""
    return Model._of(_core.Model.from_bytes(data, name))
