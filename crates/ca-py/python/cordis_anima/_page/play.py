"""Plays scenes interactively in a page."""

from __future__ import annotations

import html
import os
import re
import shutil
import subprocess
import sys
import tempfile
import threading
import weakref
from collections.abc import Mapping, Sequence
from typing import Protocol

from .. import _core
from .._errors import FailedError, UsageError

#: time limit for the program to report the address of its page [s]
_PATIENCE = 60.0
_ADDRESS = re.compile(r"play it at (http://127\.0\.0\.1:\d+/[0-9a-f]+/)")


class _Performance(Protocol):
    """Interface of a player: a thread of this process, or a program."""

    def address(self) -> str | None: ...
    def is_playing(self) -> bool: ...
    def lines(self) -> list[str]: ...
    def set(self, values: list[tuple[str, str]]) -> str: ...
    def stop(self) -> None: ...


def _program(given: str | os.PathLike[str] | None) -> list[str]:
    """Command of the program ``ca``: the given one, or the one of this package."""
    wanted = os.fspath(given) if given is not None else os.environ.get("CA")
    if wanted is None:
        return [sys.executable, "-m", "cordis_anima"]
    found = shutil.which(wanted)
    if found is None:
        where = "`ca=`" if given is not None else "the environment variable CA"
        raise UsageError(f"the program `{wanted}` given by {where} is not found; leave it out to use `python -m cordis_anima`")
    return [found]


class _Program:
    """Runs ``ca play`` as a process, which ends with this process."""

    def __init__(self, program: list[str], name: str, text: str, args: Sequence[str]) -> None:
        self._ca = program
        self._folder = tempfile.TemporaryDirectory(prefix="ca-play-")
        path = os.path.join(self._folder.name, name + ".ca.toml")
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        self.process = subprocess.Popen(
            [*program, "play", path, "--no-open", *args],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        )
        self._lines: list[str] = []
        self._address: str | None = None
        self._found = threading.Event()
        threading.Thread(target=self._read, daemon=True).start()
        self._found.wait(_PATIENCE)

    def _read(self) -> None:
        assert self.process.stderr is not None
        for line in self.process.stderr:
            self._lines.append(line.rstrip())
            if address := _ADDRESS.search(line):
                self._address = address[1]
                self._found.set()
            if len(self._lines) > 1000:
                del self._lines[:500]
        self._found.set()

    def address(self) -> str | None:
        return self._address

    def is_playing(self) -> bool:
        return self.process.poll() is None

    def lines(self) -> list[str]:
        return list(self._lines)

    def set(self, values: list[tuple[str, str]]) -> str:
        if not self.is_playing():
            raise FailedError("the scene has stopped; play it again")
        words = [f"{name}={value}" for name, value in values]
        told = subprocess.run([*self._ca, "set", *words], capture_output=True, text=True)
        if told.returncode:
            raise UsageError(told.stderr.removeprefix("error: ").strip())
        return told.stdout.strip()

    def stop(self) -> None:
        if self.is_playing():
            self.process.terminate()
            try:
                self.process.wait(5)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()
        self._folder.cleanup()


class Playing:
    """A scene that plays in a page: the moving instrument, touch, parameters, sound.

    A notebook shows the page as the last value of a cell. It ends with `stop`, with a ``with`` block, or when nothing
    refers to it. It plays in this process, unless the model has force devices or another program is named.

    >>> import cordis_anima as ca
    >>> with ca.load("hammered_string").play() as playing:
    ...     playing.url.startswith("http://127.0.0.1:"), playing.is_playing
    (True, True)
    >>> playing.is_playing
    False
    """

    #: address of the page, on this machine
    url: str

    def __init__(self, *_: object, **__: object) -> None:
        raise UsageError("use `Scene.play` to play a scene")

    @classmethod
    def _of(
        cls,
        model: _core.Model,
        program: str | os.PathLike[str] | None,
        devices: bool,
        args: Sequence[str],
    ) -> Playing:
        made = cls.__new__(cls)
        name = model.name or "model"
        args = ["--framed", *args]
        # forces on a hand must not depend on other work of this process
        if devices or program is not None or "CA" in os.environ:
            made._plays = _Program(_program(program), name, model.toml(), args)
        else:
            made._plays = _core.Performance(model, name, args)
        made._end = weakref.finalize(made, made._plays.stop)
        address = made._plays.address()
        if address is None:
            why = "\n".join(made._plays.lines()) or f"no answer within {_PATIENCE:g} s"
            made._end()
            raise FailedError(f"`ca play` failed: {why}")
        made.url = address
        return made

    _plays: _Performance
    _end: weakref.finalize[..., Playing]

    @property
    def is_playing(self) -> bool:
        """True until it ends."""
        return self._plays.is_playing()

    @property
    def said(self) -> str:
        """Messages so far: warnings of the model, refused requests."""
        return "\n".join(self._plays.lines())

    def set(self, values: Mapping[str, float | str]) -> str:
        """Changes live parameters, all in one tick, or other numbers of the model.

        With other numbers, the model is compiled again and plays on.

        Args:
            values: numbers in SI units, or quantities as text, by name, e.g. ``{"k": "900 N/m"}``.

        Returns:
            The answer as text.

        Raises:
            UsageError: if a name or a value is refused.
            FailedError: if it no longer plays.
        """
        typed = [(name, v if isinstance(v, str) else repr(float(v))) for name, v in values.items()]
        return self._plays.set(typed)

    def stop(self) -> None:
        """Stops it, and waits until its files are complete."""
        self._end()

    def __enter__(self) -> Playing:
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    def __repr__(self) -> str:
        return f"<Playing at {self.url}>" if self.is_playing else "<Playing: ended>"

    def _repr_html_(self) -> str:
        if not self.is_playing:
            return "<p>playing has ended</p>"
        url = html.escape(self.url)
        frame = f'<iframe src="{url}" allow="autoplay; midi" style="width:100%;height:640px;border:0"></iframe>'
        return f'{frame}<p><a href="{url}" target="_blank" rel="noreferrer">open the page in a new tab</a></p>'
