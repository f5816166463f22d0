"""A virtual sensor, counted in electrons: the truth that the model is held against.

Nothing here uses ``dnanalyze.model``: where the two agree, they agree by physics and not by shared
code. It feeds the ``demo`` command, the hidden-effect tests and the benchmark.
"""

from dnanalyze.demo.folder import write_folder
from dnanalyze.demo.hdr_sensor import Channel, generate_channels
from dnanalyze.demo.hidden import LEVELS
from dnanalyze.demo.sensor import VirtualSensor, draw_sensor
from dnanalyze.demo.tiny import tiny
from dnanalyze.demo.virtual_sensor import CATALOGUED, EFFECTS, OUTSIDE, generate, resolve, truth

__all__ = [
    "CATALOGUED",
    "EFFECTS",
    "LEVELS",
    "OUTSIDE",
    "Channel",
    "VirtualSensor",
    "draw_sensor",
    "generate",
    "generate_channels",
    "resolve",
    "tiny",
    "truth",
    "write_folder",
]
