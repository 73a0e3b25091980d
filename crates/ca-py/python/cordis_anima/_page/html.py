"""Pictures and players for notebooks, as self-contained HTML."""

from __future__ import annotations

import base64
import html
import io
import struct
import textwrap
from collections.abc import Mapping, Sequence

import numpy as np

from .._results import Param, Port, Sound

#: columns of a drawn waveform
_WIDTH = 600
#: longest text in a table [characters]
_TEXT = 60


def _wav(audio: Sound, sr: int) -> bytes:
    """Encodes a 16-bit WAV file in memory."""
    frames, channels = audio.shape
    data = np.clip(np.rint(audio.astype(np.float64) * 32768), -32768, 32767).astype("<i2").tobytes()
    head = struct.pack("<IHHIIHH", 16, 1, channels, sr, sr * channels * 2, channels * 2, 16)
    out = io.BytesIO()
    out.write(b"RIFF" + struct.pack("<I", 36 + len(data)) + b"WAVEfmt " + head)
    out.write(b"data" + struct.pack("<I", len(data)) + data)
    return out.getvalue()


def _wave(x: Sound, height: int = 60) -> str:
    """Draws a waveform as SVG: smallest and largest sample of each column."""
    edges = np.linspace(0, len(x), min(_WIDTH, len(x)) + 1).astype(int)[:-1]
    low, high = np.minimum.reduceat(x, edges), np.maximum.reduceat(x, edges)
    top = max(float(np.abs(x).max()), 1e-9)
    mid = height / 2
    lines = "".join(
        f"M{k} {mid - mid * float(h) / top:.1f}V{mid - mid * float(l) / top + 0.5:.1f}" for k, (l, h) in enumerate(zip(low, high))
    )
    return (
        f'<svg viewBox="0 0 {len(edges)} {height}" style="width:100%;max-width:{_WIDTH}px;height:{height}px" '
        f'preserveAspectRatio="none"><path d="{lines}" stroke="currentColor" fill="none"/></svg>'
    )


def _player(audio: Sound, sr: int, channels: Sequence[str]) -> str:
    """Player and waveforms of the channels; empty without sound."""
    if not audio.size:
        return ""
    sound = base64.b64encode(_wav(audio[:, :2], sr)).decode()
    waves = "".join(f"<div>{html.escape(name)}<br>{_wave(x)}</div>" for name, x in zip(channels, audio.T))
    return f'<audio controls src="data:audio/wav;base64,{sound}"></audio>{waves}'


def render(title: str, audio: Sound, sr: int, channels: Sequence[str]) -> str:
    """A render: title, player, waveforms."""
    return f"<div><p>{html.escape(title)}</p>{_player(audio, sr, channels)}</div>"


def take(title: str, facts: Sequence[tuple[str, str]], audio: Sound, sr: int, channels: Sequence[str]) -> str:
    """A take: title, facts, player, waveforms."""
    rows = "".join(f"<tr><th>{html.escape(name)}</th><td>{html.escape(text)}</td></tr>" for name, text in facts)
    return f"<div><p>{html.escape(title)}</p><table>{rows}</table>{_player(audio, sr, channels)}</div>"


def scene(title: str, inputs: Sequence[Port], params: Sequence[Param]) -> str:
    """A scene: title, ports, live parameters."""
    rows = "".join(
        f"<tr><td>{html.escape(p.name)}</td><td>{p.value:g} {html.escape(p.unit)}</td>"
        f"<td>{p.min:g} … {p.max:g}</td><td>{html.escape(p.doc)}</td></tr>"
        for p in params
    )
    ports = ", ".join(html.escape(f"{p.name} ({p.role})") for p in inputs) or "none"
    table = f"<table><tr><th>live</th><th>value</th><th>range</th><th></th></tr>{rows}</table>" if rows else ""
    return f"<div><p>{html.escape(title)}</p><p>ports: {ports}</p>{table}</div>"


def sweep(title: str, columns: Mapping[str, Sequence[object]], left: int) -> str:
    """A sweep: title, the first rows, and the number of rows left. Missing values are empty cells."""

    def cell(value: object) -> str:
        if isinstance(value, float):
            return "" if value != value else f"{value:.6g}"
        return "" if value is None else html.escape(textwrap.shorten(str(value), _TEXT, placeholder=" …"))

    head = "".join(f"<th>{html.escape(name)}</th>" for name in columns)
    rows = "".join("<tr>" + "".join(f"<td>{cell(v)}</td>" for v in row) + "</tr>" for row in zip(*columns.values()))
    more = f"<p>and {left} more</p>" if left else ""
    return f"<div><p>{html.escape(title)}</p><table><tr>{head}</tr>{rows}</table>{more}</div>"
