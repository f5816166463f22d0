"""Results as the terminal prints them, one file a result: the verdict first, then small tables."""
