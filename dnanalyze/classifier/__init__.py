"""Classifier two-sample test: can a trained classifier tell simulated frames from measured ones."""
