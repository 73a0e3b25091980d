"""Scenes that are played by hand in the page of ``ca play``."""

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
from collections.abc import Sequence

from .. import _core
from .._errors import FailedError, UsageError

#: how long the program may take until it says where its page is [s]
_PATIENCE = 60.0
_ADDRESS = re.compile(r"play it at (http://127\.0\.0\.1:\d+/[0-9a-f]+/)")


def _program(given: str | os.PathLike[str] | None) -> list[str]:
    """The program ``ca``: the one that is given, or the one of this package."""
    wanted = os.fspath(given) if given is not None else os.environ.get("CA")
    if wanted is None:
        return [sys.executable, "-m", "cordis_anima"]
    found = shutil.which(wanted)
    if found is None:
        where = "`ca=`" if given is not None else "the environment variable CA"
        raise UsageError(f"the program `{wanted}` is not found ({where}); without it, `python -m cordis_anima` plays")
    return [found]


def _end(process: subprocess.Popen[str], folder: tempfile.TemporaryDirectory[str]) -> None:
    """Ends the program, and takes its model away."""
    if process.poll() is None:
        process.terminate()
        try:
            process.wait(5)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
    folder.cleanup()


class Playing:
    """A scene that is played in the page of ``ca play``: the moving instrument, touch, parameters, sound. In a notebook its
    last value in a cell shows the page there. It ends with `stop`, with a ``with`` block, or when nothing refers to it.

    >>> import cordis_anima as ca
    >>> with ca.load("hammered_string").play() as playing:
    ...     playing.url.startswith("http://127.0.0.1:"), playing.is_playing
    (True, True)
    >>> playing.is_playing
    False
    """

    #: where the page is, on this machine
    url: str

    def __init__(self, *_: object, **__: object) -> None:
        raise UsageError("a scene is played by `Scene.play`")

    @classmethod
    def _of(cls, model: _core.Model, text: str, program: str | os.PathLike[str] | None, args: Sequence[str]) -> Playing:
        made = cls.__new__(cls)
        folder = tempfile.TemporaryDirectory(prefix="ca-play-")
        name = (model.name or "model") + ".ca.toml"
        path = os.path.join(folder.name, name)
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        # one that ends with this process, however that ends, since nobody reads what it says any more
        process = subprocess.Popen(
            [*_program(program), "play", path, "--no-open", "--framed", *args],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        )
        made._end = weakref.finalize(made, _end, process, folder)
        made._process, made._said = process, []
        found = threading.Event()

        def read(said: list[str], made: weakref.ref[Playing]) -> None:
            assert process.stderr is not None
            for line in process.stderr:
                said.append(line.rstrip())
                address, playing = _ADDRESS.search(line), made()
                if address and playing is not None:
                    playing.url = address[1]
                    found.set()
                del playing
                if len(said) > 1000:
                    del said[:500]
            found.set()

        threading.Thread(target=read, args=(made._said, weakref.ref(made)), daemon=True).start()
        if not found.wait(_PATIENCE) or not hasattr(made, "url"):
            why = "\n".join(made._said) or f"it says nothing within {_PATIENCE:g} s"
            made._end()
            raise FailedError(f"`ca play` does not play it: {why}")
        return made

    _process: subprocess.Popen[str]
    _said: list[str]
    _end: weakref.finalize[..., Playing]

    @property
    def is_playing(self) -> bool:
        """Whether it plays still."""
        return self._process.poll() is None

    @property
    def said(self) -> str:
        """What the program has said so far: the model's warnings, what was refused."""
        return "\n".join(self._said)

    def stop(self) -> None:
        """Ends it."""
        self._end()

    def __enter__(self) -> Playing:
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    def __repr__(self) -> str:
        return f"<Playing at {self.url}>" if self.is_playing else "<Playing: ended>"

    def _repr_html_(self) -> str:
        if not self.is_playing:
            return "<p>it has ended</p>"
        url = html.escape(self.url)
        frame = f'<iframe src="{url}" allow="autoplay; midi" style="width:100%;height:640px;border:0"></iframe>'
        return f'{frame}<p><a href="{url}" target="_blank" rel="noreferrer">the page by itself</a></p>'
