"""Comparison of measured and simulated statistics: discrepancies and model error."""
