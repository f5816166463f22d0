"""The catalogue: one file an effect."""
