"""Sweeps and batches: one model with many values, the executors that play it, and where its sounds go."""
