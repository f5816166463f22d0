"""Frames to Statistics in one streaming pass.

The path of a frame: ``analyze`` reads it; ``streaming`` hands it to the ``accumulators``, whose
loops over pixels are ``kernels``; from their sums the ``families`` make the statistics, with the
``estimators`` and ``spectra``. ``statistics`` is what comes out, ``catalogue`` lists all of it.
"""
