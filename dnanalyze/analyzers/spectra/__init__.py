"""Fourier spectra: sums of powers, their modes, lines that stand out, and where these lie."""
