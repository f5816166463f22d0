"""A pattern learned from one sensor: a map beside the model, and the effect that adds it."""
