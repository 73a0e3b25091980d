"""Every notebook runs from top to bottom, in the long form twice; its claims hold, and it leaves no file."""

from __future__ import annotations

import base64
import copy
import io
import json
import os
import re
import sys
from pathlib import Path

import nbclient
import nbformat
import pytest
import soundfile
from sweeps import LONG

ROOT = Path(os.environ.get("CA_ROOT", Path(__file__).parents[4]))
FOLDER = ROOT / "crates/ca-py/notebooks"
#: published as run, with pictures and players, for reading
PUBLISHED = ROOT / "docs/notebooks"
BOOKS = sorted(FOLDER.glob("*.ipynb"))


@pytest.fixture
def kernel(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder to run in, and a kernel with this interpreter, whatever other kernels are installed."""
    spec = tmp_path / "jupyter/kernels/python3/kernel.json"
    spec.parent.mkdir(parents=True)
    argv = [sys.executable, "-m", "ipykernel_launcher", "-f", "{connection_file}"]
    spec.write_text(json.dumps({"argv": argv, "display_name": "here", "language": "python"}))
    for name in ("PATH", "CONFIG_DIR", "RUNTIME_DIR"):
        monkeypatch.setenv(f"JUPYTER_{name}", str(tmp_path / "jupyter"))
    monkeypatch.setenv("IPYTHONDIR", str(tmp_path / "ipython"))
    # pictures as shown to users
    monkeypatch.delenv("MPLBACKEND")
    folder = tmp_path / "run"
    folder.mkdir()
    return folder


@pytest.fixture
def temporary(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Directory for temporary files of a kernel."""
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setenv("TMPDIR", str(folder))
    return folder


def test_there_are_some() -> None:
    assert len(BOOKS) >= 7


@pytest.mark.parametrize("path", BOOKS, ids=lambda p: p.stem)
def test_it_is_kept_without_what_a_run_leaves(path: Path) -> None:
    notebook = json.loads(path.read_text())
    nbformat.validate(nbformat.from_dict(notebook))
    assert (notebook["nbformat"], notebook["nbformat_minor"]) == (4, 5)
    assert set(notebook["metadata"]) == {"kernelspec", "language_info"}
    for cell in notebook["cells"]:
        assert cell["metadata"] == {} and "".join(cell["source"]).strip()
        assert cell.get("outputs", []) == [] and cell.get("execution_count") is None


#: left to the long form for their run time
LONG_BOOKS = () if LONG else ("train_a_hammer",)


@pytest.mark.parametrize("path", [b for b in BOOKS if b.stem not in LONG_BOOKS], ids=lambda p: p.stem)
def test_it_runs(path: Path, kernel: Path, temporary: Path) -> None:
    notebook = nbformat.read(path, as_version=4)
    once = len(notebook.cells)
    # its claims are also assertions
    assert sum("assert " in cell.source for cell in notebook.cells if cell.cell_type == "code") >= 2
    # runs again in the same kernel and folder, in the long form
    if LONG:
        again = copy.deepcopy(notebook.cells)
        for cell in again:
            cell["id"] += "-again"
        notebook.cells += again
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    nbclient.NotebookClient(notebook, timeout=300, kernel_name="python3", resources={"metadata": {"path": str(kernel)}}).execute()
    outputs = [output for cell in code for output in cell.outputs]
    assert all(cell.execution_count for cell in code)
    # no warnings, and at least one picture; how long a worker takes to end depends on the machine
    said = [output.text for output in outputs if output.output_type == "stream" and output.name == "stderr"]
    assert not [line for text in said for line in text.splitlines() if "Worker process still alive after" not in line]
    assert any("image/png" in output.get("data", {}) for output in outputs)
    # no file is left behind
    assert list(kernel.iterdir()) == []
    assert [p.name for p in temporary.iterdir() if not p.name.startswith("dask")] == []
    if os.environ.get("UPDATE"):
        notebook.cells = notebook.cells[:once]
        for output in (o for cell in notebook.cells for o in cell.get("outputs", []) if "text/html" in o.get("data", {})):
            output["data"]["text/html"] = re.sub(r"data:audio/wav;base64,([A-Za-z0-9+/=]+)", smaller, output["data"]["text/html"])
        PUBLISHED.mkdir(exist_ok=True)
        nbformat.write(notebook, PUBLISHED / path.name)


def smaller(wav: re.Match[str]) -> str:
    """Converts a player's sound to MP3, a tenth of the size, for readers; a run gives the samples."""
    sound, sr = soundfile.read(io.BytesIO(base64.b64decode(wav[1])))
    mp3 = io.BytesIO()
    soundfile.write(mp3, sound, sr, format="MP3")
    return f"data:audio/mpeg;base64,{base64.b64encode(mp3.getvalue()).decode()}"


@pytest.mark.parametrize("path", BOOKS, ids=lambda p: p.stem)
def test_the_published_one_is_this_one_after_a_run(path: Path) -> None:
    source, published = nbformat.read(path, as_version=4), nbformat.read(PUBLISHED / path.name, as_version=4)
    fix = "`UPDATE=1 cargo test --workspace --test python` makes it anew"
    assert [c.source for c in published.cells] == [c.source for c in source.cells], fix
    outputs = [output for cell in published.cells for output in cell.get("outputs", [])]
    assert any("image/png" in output.get("data", {}) for output in outputs), fix
    assert (PUBLISHED / path.name).stat().st_size < 1_000_000, "what is read is not to be waited for"
