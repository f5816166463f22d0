"""Sections that the pages of several results have in common."""
