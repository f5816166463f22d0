"""Diagnosis of missing effects, and stepwise refinement."""
