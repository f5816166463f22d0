"""A simulation against its targets, as a CI job asks: limits, what breaks them, and margins."""
