"""NoiseModel = ordered effects; its YAML; the random streams; simulate."""
