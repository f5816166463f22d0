"""The dark quantities of EMVA 1288 Release 4.0, from statistics of dark frames."""

from dnanalyze.emva.evaluate import evaluate
from dnanalyze.emva.quantity import Emva, Quantity

__all__ = ["Emva", "Quantity", "evaluate"]
