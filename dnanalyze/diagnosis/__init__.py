"""What is missing in a model; add it; refine until nothing is left to find."""
