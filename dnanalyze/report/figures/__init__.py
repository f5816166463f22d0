"""The figures, one file a family; each returns a `Picture` or None where it has nothing to show."""
