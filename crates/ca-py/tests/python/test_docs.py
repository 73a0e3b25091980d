"""Runs the examples in the README of the package and in its docstrings."""

from __future__ import annotations

import ast
import doctest
import inspect
import os
import re
from pathlib import Path

import pytest

import cordis_anima

#: other packages, not needed to read their examples
OTHERS = ("joblib", "mpi4py", "dask")


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


def documents() -> list[tuple[str, str]]:
    """Docstrings of the package with their places; pytest runs the examples in all of them."""
    found = []
    for file in sorted(Path(cordis_anima.__file__).parent.rglob("*.py")):
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef)) and (text := ast.get_docstring(node)):
                found.append((f"{file.name}: {getattr(node, 'name', 'the file')}", text))
    return found


def calls(text: str) -> list[str]:
    """Complete calls of this package in the text of a docstring."""
    found = []
    for code in re.findall(r"``([^`]+)``", text):
        try:
            call = ast.parse(code, mode="eval").body
        except SyntaxError:
            continue
        if isinstance(call, ast.Call) and not code.startswith(OTHERS):
            found.append(code)
    return found


def test_calls_that_documents_show_are_run() -> None:
    all = documents()
    examples = [e.source for _, text in all for e in doctest.DocTestParser().get_examples(text)]
    assert len(examples) > 60
    shown = [(where, code) for where, text in all for code in calls(text)]
    assert shown, "there are some"
    assert [(where, code) for where, code in shown if not any(code in e for e in examples)] == []


def test_what_builds_a_model_has_an_example() -> None:
    for name in ("add", "group", "param", "gesture", "set", "check"):
        assert ">>>" in (inspect.getdoc(getattr(cordis_anima.Model, name)) or ""), name
