"""Two Statistics to discrepancies, floor and error."""
