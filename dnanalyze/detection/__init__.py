"""Hidden defect-pixel correction and denoise: has the raw data been filtered?"""

from dnanalyze.detection.detect import detect
from dnanalyze.detection.results import Detection, FilterEstimate, Finding

__all__ = ["Detection", "FilterEstimate", "Finding", "detect"]
