"""Simulation on a CUDA device: an effect's own code, recorded, becomes one kernel."""
