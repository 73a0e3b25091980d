"""What the page of the package shows is run."""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest


def blocks(page: str) -> list[str]:
    text = (Path(os.environ.get("CA_ROOT", Path(__file__).parents[4])) / page).read_text()
    return re.findall(r"^```python\n(.*?)^```", text, re.DOTALL | re.MULTILINE)


@pytest.mark.parametrize("page", ["README.md", "crates/ca-py/README.md"])
def test_pages_run_from_top_to_bottom(page: str, capsys: pytest.CaptureFixture[str]) -> None:
    all = blocks(page)
    assert len(all) >= 1
    space: dict[str, object] = {}
    for block in all:
        exec(compile(block, page, "exec"), space)
    assert capsys.readouterr().out.startswith("(96000, 1) 48000\n")
