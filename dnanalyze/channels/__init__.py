"""Readout channels of an HDR sensor: refined one by one, then as one model of all."""
