"""Frames to Statistics in one streaming pass: one file a family of statistics."""
