"""Shows the moving instrument, without a server."""

from __future__ import annotations

import html
import os
from pathlib import Path


class View:
    """A page with the moving instrument, in step with its sound. A notebook shows it as the last value of a cell.

    >>> import cordis_anima as ca, tempfile, os
    >>> view = ca.load("hammered_string").view(0.5)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = os.path.join(folder, "string.html")
    ...     view.save(path)
    ...     os.path.getsize(path) == len(view.html.encode())
    True
    """

    __slots__ = ("html",)
    #: text of the page, which loads no other resources
    html: str

    def __init__(self, html: str) -> None:
        self.html = html

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the page to a file, for any browser."""
        Path(path).write_text(self.html, encoding="utf-8")

    def __repr__(self) -> str:
        return f"<View: a page of {len(self.html) / 1e6:.1f} MB>"

    def _repr_html_(self) -> str:
        # a separate frame isolates its script and style from other cells
        return f'<iframe srcdoc="{html.escape(self.html)}" style="width:100%;height:640px;border:0"></iframe>'
