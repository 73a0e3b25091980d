"""Analyses of a scene: modes, energy, accuracy, linear part, derivatives, and fits to a recorded sound."""
