"""The type stubs match the package."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import cordis_anima


def run(*args: str) -> None:
    done = subprocess.run([sys.executable, "-m", *args], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_stub_is_the_module() -> None:
    run("mypy.stubtest", "cordis_anima._core", "--ignore-missing-stub")


def test_the_package_and_its_users_are_strict() -> None:
    package = Path(cordis_anima.__file__).parent
    here = Path(__file__).parent
    env = os.environ.get("PYTHONPATH", "")
    assert str(package.parent) in env or not env
    run("mypy", "--strict", "--no-incremental", "--cache-dir=/dev/null", str(package), str(here / "uses.py"))


def test_everything_public_has_a_document() -> None:
    for name in cordis_anima.__all__:
        thing = getattr(cordis_anima, name)
        # type aliases have a comment instead
        assert getattr(thing, "__doc__", None) or name in ("Curve", "Gesture", "Inputs", "Progress"), name
