"""Plots for ``plot``: axes, then measurements, runs and sounds."""
