"""What can go wrong, as one tree of exceptions: ``CaError`` catches all of them."""

from __future__ import annotations

import importlib
import json
from dataclasses import dataclass
from typing import Any


class CaError(Exception):
    """Anything this package raises of its own accord."""


class UsageError(CaError, ValueError):
    """The request makes no sense: an unknown name, a value out of its range, an array of the wrong shape."""


class FailedError(CaError, RuntimeError):
    """The request makes sense, but cannot be done."""


class MissingError(CaError, ImportError):
    """A package is missing that this needs and all else does not; the text says how to install it."""


def needed(name: str, extra: str) -> Any:
    """A package that few need.

    Raises:
        MissingError: it is not there.
    """
    try:
        return importlib.import_module(name)
    except ImportError as e:
        raise MissingError(f'this needs {name}: pip install "cordis-anima[{extra}]"', name=name) from e


class FileError(CaError, OSError):
    """A file cannot be read, or what it holds cannot drive a model.

    Attributes:
        file: as it was named; empty where it came from memory.
        place: where in it, e.g. ``line 3, column 2``; empty where it is all of it.
    """

    def __init__(self, message: str, file: str = "", place: str = "") -> None:
        super().__init__(message)
        self.message = message
        self.file = file
        self.place = place

    def __str__(self) -> str:
        return self.message

    def __reduce__(self) -> tuple[Any, ...]:
        return (FileError, (self.message, self.file, self.place))


@dataclass(frozen=True)
class Diagnostic:
    """One finding about a model.

    Attributes:
        code: e.g. ``E013``; ``ca explain`` prints its page.
        severity: ``error``, ``warning`` or ``note``.
        message: one line that stands by itself.
        file: the name of the model's file.
        line: where it stands, from 1 on; ``None`` where it stands in no text.
        column: the same, in characters.
        help: what to do, if that is known.
    """

    code: str
    severity: str
    message: str
    file: str
    line: int | None
    column: int | None
    help: str | None

    @property
    def location(self) -> str:
        """``file:line:column``, or the file alone.

        >>> Diagnostic("E013", "error", "no module `bop`", "a.ca.toml", 3, 9, None).location
        'a.ca.toml:3:9'
        """
        return self.file if self.line is None else f"{self.file}:{self.line}:{self.column}"


def diagnostics(text: str) -> tuple[Diagnostic, ...]:
    """Findings from their JSON."""
    return tuple(
        Diagnostic(d["code"], d["severity"], d["title"], d["file"], d["line"], d["column"], d["help"])
        for d in json.loads(text)
    )


class ModelError(CaError, ValueError):
    """A model has errors. The text shows each where it stands.

    Attributes:
        diagnostics: all findings, errors and others, in order of place.

    >>> import cordis_anima as ca
    >>> try:
    ...     ca.parse('[MAS]\\nbob = { m = 1, dxo = 3 }\\n')
    ... except ca.ModelError as e:
    ...     print(e.code, e.location, e.help)
    E004 model.ca.toml:2:16 did you mean `dx0`?
    """

    def __init__(self, found: str, text: str) -> None:
        super().__init__(found, text)
        self.diagnostics = diagnostics(found)
        self._text = text

    def __str__(self) -> str:
        return "\n" + self._text.rstrip()

    @property
    def _first(self) -> Diagnostic:
        return next(d for d in self.diagnostics if d.severity == "error")

    @property
    def code(self) -> str:
        """Code of the first error."""
        return self._first.code

    @property
    def message(self) -> str:
        """The first error in one line."""
        return self._first.message

    @property
    def location(self) -> str:
        """Where the first error stands."""
        return self._first.location

    @property
    def help(self) -> str | None:
        """What to do about the first error."""
        return self._first.help


class UnstableError(CaError, ArithmeticError):
    """A model diverged and ``on_unstable="raise"`` was asked for.

    Attributes:
        time: when [s].
        module: which one is to blame.
    """

    def __init__(self, message: str, time: float, module: str) -> None:
        super().__init__(message)
        self.message = message
        self.time = time
        self.module = module

    def __str__(self) -> str:
        return self.message

    def __reduce__(self) -> tuple[Any, ...]:
        return (UnstableError, (self.message, self.time, self.module))
