"""Levels from which a deviation counts, one for all of the engine.

In standard deviations of what chance shows, each for so many numbers as are looked at: by chance,
less than one of them lies beyond. The shares are two-sided ones of a normal distribution.
"""

from __future__ import annotations

TOLERATED = 2.0  # 5 %: of one number that a fit holds within its error
SIGN = 2.5  # 1 %: of a statistic worth a simulation, which then decides
STATED = 3.0  # .3 %: of the some hundred numbers that a report states
NOTICEABLE = 4.0  # 6e-5: of the thousands of statistics, terms and line means of a model
CLEAR = 5.0  # 6e-7: of the ten thousands of lines of all operating points
CERTAIN = 6.0  # 2e-9: of the millions of pixels of a sensor

UNLIKELY = 0.01  # chance that a test of one question is wrong: further terms and structure
RARE = 1e-3  # the same of a test of every captures: filters, laws and bands of a pattern

# Twice the log likelihood ratio that a superfluous effect does not reach: on 60 virtual sensors
# without a missing effect, 19 candidates were refitted; the smaller gain of the halves reached 10,
# the mean of both 28.
EVIDENCE_NULL = 25.0
# Of either half; less is not worth a refit (Akaike: 3 parameters)
LEAST_GAIN = EVIDENCE_NULL / 4.0
