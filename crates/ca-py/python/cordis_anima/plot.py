"""Plots of sounds and measurements with matplotlib: ``pip install "cordis-anima[plot]"``.

>>> import cordis_anima as ca
>>> from cordis_anima import plot
>>> ax = plot.spectrum(ca.examples.string().render(1.0))
>>> ax.get_xlabel(), ax.get_ylabel()
('frequency [Hz]', 'level of a sine [dBFS]')

Each function draws one record and returns its Axes, which are new unless given as `ax`. Further styling is up to the
caller.
"""

from __future__ import annotations

from ._plots.measured import accuracy, energy, modes
from ._plots.runs import sweep, take
from ._plots.sound import probes, sound, spectrogram, spectrum

__all__ = ["accuracy", "energy", "modes", "probes", "sound", "spectrogram", "spectrum", "sweep", "take"]
