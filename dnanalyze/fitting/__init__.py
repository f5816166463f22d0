"""Fits of models to statistics, by simulation with common random numbers.

The fit needs nothing of a model but its frames: it simulates the captures, takes the same
statistics, and moves the parameters until they agree within what two captures of one sensor differ
by. Because every random number is fixed by its place, the statistics move smoothly with the
parameters.
"""
