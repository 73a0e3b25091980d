"""Uses of the package, for the type checker."""

from __future__ import annotations

import numpy as np

import cordis_anima as ca
from cordis_anima import plot


def struck(hardness: float) -> tuple[float, str]:
    """Peak of a string struck by a hammer of this hardness [N/m], and its stability level."""
    scene = ca.examples.string().replace({"strike.k": hardness})
    r = scene.render(0.5, probes=["strike"], energy=True, progress=lambda done, of: None)
    if r.energy is not None:
        assert abs(r.energy.residual) <= 1e-9 * r.energy.peak
    force: float = float(np.abs(r.probes["strike"]).max())
    return force, scene.certificate.level


def played() -> int:
    """Number of samples of a scene run step by step."""
    with ca.load("hammered_string").open(block=160) as sim:
        audio, force = sim.step({"key": np.linspace(-0.008, 0.0, 160)})
        sim.params["rest"] = 1.0
        return len(audio) + len(force)


def shown() -> list[str]:
    """Axis labels of a few plots."""
    scene = ca.examples.string()
    r = scene.render(0.5, probes=["strike"], energy=True)
    axes = [plot.spectrum(r, scene.modes()), plot.energy(r), plot.probes(r, ["strike"]), plot.modes(scene.modes(), "out")]
    return [ax.get_xlabel() for ax in axes]


def swept() -> dict[str, int]:
    """Statuses of the runs of a few strings."""
    vary = {"low.f": ca.Range("110 Hz", "440 Hz", log=True)}
    s = ca.sweep(ca.examples.string(), vary, 4, seconds="100 ms", audio=True, measure=True)
    ax = plot.sweep(s, "low.f", "partial", color="peak")
    loudest: float = float(s["peak"].max())
    assert s.audio is not None and loudest > 0 and ax.get_xlabel() == "low.f"
    return s.counts


def taken(path: str) -> list[str]:
    """Axis labels of a take, and causes of its faults."""
    take = ca.record(ca.load("hammered_string"), path, 0.5)
    position, force = plot.take(take, "tgr12", [0, 1])
    plot.take(take, axes=(position, force))
    return [position.get_ylabel(), force.get_ylabel(), *(fault.cause for fault in take.faults)]


if __name__ == "__main__":
    print(struck(8e3), played(), swept(), [m for m in ca.load("harmonic_chain").modes().heard[:3]])
