"""Folder of dark frames to a ``CaptureSet``: one file a format."""
