"""Exceptions of the package: all of them derive from ``CaError``."""

from __future__ import annotations

import importlib
import json
from dataclasses import dataclass
from typing import Any


class CaError(Exception):
    """Base class of all exceptions raised by this package."""


class UsageError(CaError, ValueError):
    """The request is invalid: an unknown name, a value out of range, an array of the wrong shape."""


class FailedError(CaError, RuntimeError):
    """The request is valid but failed."""


class MissingError(CaError, ImportError):
    """An optional package is missing; the message says how to install it."""


def needed(name: str, extra: str) -> Any:
    """Imports an optional package.

    Raises:
        MissingError: if it is not installed.
    """
    try:
        return importlib.import_module(name)
    except ImportError as e:
        raise MissingError(f'this needs {name}: pip install "cordis-anima[{extra}]"', name=name) from e


class FileError(CaError, OSError):
    """A file cannot be read, or its contents cannot drive a model.

    Attributes:
        file: path as given; empty for data in memory.
        place: position in the file, e.g. ``line 3, column 2``; empty if not known.
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
        code: e.g. ``E013``; ``ca explain`` prints its documentation.
        severity: ``error``, ``warning`` or ``note``.
        message: one self-contained line.
        file: name of the model's file.
        line: line number from 1; ``None`` if the finding is not about the text.
        column: column number from 1, in characters; ``None`` likewise.
        help: how to fix it, if known.
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
        """``file:line:column``, or the file alone if the line is unknown.

        >>> Diagnostic("E013", "error", "no module `bop`", "a.ca.toml", 3, 9, None).location
        'a.ca.toml:3:9'
        """
        return self.file if self.line is None else f"{self.file}:{self.line}:{self.column}"


def diagnostics(text: str) -> tuple[Diagnostic, ...]:
    """Parses findings from JSON."""
    return tuple(
        Diagnostic(d["code"], d["severity"], d["title"], d["file"], d["line"], d["column"], d["help"])
        for d in json.loads(text)
    )


class ModelError(CaError, ValueError):
    """A model has errors. The text of the exception shows each error with its source lines.

    Attributes:
        diagnostics: all findings, including warnings and notes, in order of place.

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
        """Message of the first error."""
        return self._first.message

    @property
    def location(self) -> str:
        """Place of the first error."""
        return self._first.location

    @property
    def help(self) -> str | None:
        """How to fix the first error, if known."""
        return self._first.help


class UnstableError(CaError, ArithmeticError):
    """A model diverged in a call with ``on_unstable="raise"``.

    Attributes:
        time: time of divergence [s].
        module: module that caused it.
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
