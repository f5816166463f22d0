"""What the user sees of a result: figures, one self-contained HTML page, JSON, CSV, JUnit."""
