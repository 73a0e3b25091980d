"""Plays a bundled model by `ca render` along positions of its ports; returns sound and probes as arrays.

The command is used, not the package, so that anyone can repeat a row of a page with a command. All files are in a temporary
folder.
"""

from __future__ import annotations

import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

ROOT = Path(__file__).resolve().parents[2]
RATE = 48000
Points = Sequence[tuple[float, float]]
Array = NDArray[np.float64]


@dataclass
class Played:
    """Mean of the channels, and each probe by name, in SI units."""

    sound: Array
    probes: dict[str, Array]


def table(tracks: Mapping[str, Points]) -> str:
    """Formats positions as a CSV file for `--gesture`: a row at each time at which a track has a point."""
    times = sorted({t for points in tracks.values() for t, _ in points})
    rows = ["time," + ",".join(tracks)]
    for t in times:
        at = (np.interp(t, [p[0] for p in points], [p[1] for p in points]) for points in tracks.values())
        rows.append(",".join(f"{v:.7g}" for v in (t, *at)))
    return "\n".join(rows) + "\n"


def sound_of(path: Path) -> Array:
    """Returns the mean of the channels of a file of 32-bit floats."""
    raw = path.read_bytes()
    channels = int.from_bytes(raw[22:24], "little")
    begin = raw.index(b"data") + 8
    size = int.from_bytes(raw[begin - 4 : begin], "little")
    return np.frombuffer(raw[begin : begin + size], "<f4").reshape(-1, channels).mean(1).astype(float)


def play(command: str, text: str, tracks: Mapping[str, Points], seconds: float, probes: Sequence[str]) -> Played:
    """Renders the text of a model."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "model.ca.toml").write_text(text)
        (folder / "hands.csv").write_text(table(tracks))
        files = {probe: folder / f"probe{i}.npy" for i, probe in enumerate(probes)}
        args = [command, "render", str(folder / "model.ca.toml"), "-q", "-o", str(folder / "sound.wav"), "--no-fade"]
        args += ["--seconds", f"{seconds:.6f}", "--gesture", str(folder / "hands.csv")]
        for probe, file in files.items():
            args += ["--probe", f"{probe}={file}"]
        subprocess.run(args, check=True)
        return Played(sound_of(folder / "sound.wav"), {p: np.load(f).reshape(-1) for p, f in files.items()})
