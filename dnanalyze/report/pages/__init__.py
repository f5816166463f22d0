"""The pages, one file a command."""
