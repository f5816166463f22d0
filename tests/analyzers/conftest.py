"""Lets the tests in folders below import the frames that they share."""
