"""What is computed of a scene: modes, energy and accuracy, its linear part, derivatives, and numbers found by a recorded sound."""
