"""Pictures, for ``plot``: their axes, then those of measurements, of many runs, and of sounds."""
