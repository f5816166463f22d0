"""A model for those who do not run dnanalyze: tables, a NumPy function, a torch transform."""
