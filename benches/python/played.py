"""A bundled model played by `ca render` along positions of its ports: what was heard and probed, as arrays.

By the command, not by the package, so that each row of a page is a command that people can give. All files are in a folder of
their own that is gone afterwards.
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
    """Mean of the channels, and each probe by its name, in SI."""

    sound: Array
    probes: dict[str, Array]


def table(tracks: Mapping[str, Points]) -> str:
    """Positions as a CSV file that `--gesture` reads: a row wherever one of them has a point."""
    times = sorted({t for points in tracks.values() for t, _ in points})
    rows = ["time," + ",".join(tracks)]
    for t in times:
        at = (np.interp(t, [p[0] for p in points], [p[1] for p in points]) for points in tracks.values())
        rows.append(",".join(f"{v:.7g}" for v in (t, *at)))
    return "\n".join(rows) + "\n"


def sound_of(path: Path) -> Array:
    """Mean of the channels of a file of 32-bit floats."""
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
