"""Compiled loops: over pixels, over pixels and their neighbours, over Fourier modes."""
