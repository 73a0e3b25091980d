"""One model with many values: sweeps, who plays their tasks, where their sound goes, and batches in one call."""
