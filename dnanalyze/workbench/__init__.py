"""The workbench: a session on one capture folder, and the page that shows it.

The session is plain Python, without any widget; the page is a thin view of it.
"""
