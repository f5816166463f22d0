"""What sensors are compared by: each figure's name, unit, source, and which way is better."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Criterion:
    """One figure.

    Parameters
    ----------
    name, title, unit : str
    statistics : tuple of str
        Where it is read from: the first that the frames tell; those after it are told by single
        frames, in which the fixed pattern is not told from the noise.
    better : str
        "low", "high", or "" where neither is.
    thermal : bool
        Runs with temperature, so that it is compared at common ones by its law.
    floor : bool
        A noise that does not vanish in the cold.
    electrons : bool
        Has a form in electrons, where the conversion gain is known.
    per_area : bool
        Has a form per area, where the pixel pitch is known.
    """

    name: str
    title: str
    unit: str
    statistics: tuple[str, ...]
    better: str = "low"
    thermal: bool = True
    floor: bool = True
    electrons: bool = False
    per_area: bool = False


CRITERIA = (
    Criterion("dark_current", "dark current", "DN/s", ("dark_rate_dn_s",),
              floor=False, electrons=True, per_area=True),
    # of EMVA 1288, without what moves whole frames
    Criterion("temporal_noise", "temporal dark noise", "DN", ("s2_temporal",), electrons=True),
    Criterion("dsnu", "EMVA 1288 DSNU", "DN", ("dsnu_1288",), electrons=True),
    Criterion("dsnu_column", "DSNU of columns", "DN", ("dsnu_1288_col",), electrons=True),
    Criterion("dsnu_row", "DSNU of rows", "DN", ("dsnu_1288_row",), electrons=True),
    Criterion("dsnu_pixel", "DSNU of pixels", "DN", ("dsnu_1288_pix",), electrons=True),
    Criterion("row_noise", "temporal row noise", "DN", ("temporal_row_mean_sd",), electrons=True),
    Criterion("column_noise", "temporal column noise", "DN", ("temporal_column_mean_sd",),
              electrons=True),
    Criterion("hot_pixels", "hot pixels above 5 sigma", "ppm",
              ("hot_density_pattern", "hot_density_frame"), floor=False),
)  # fmt: skip

SINGLE = (
    Criterion("read_noise", "baseline noise floor", "DN",
              ("temporal_noise_core", "frame_noise_core"), thermal=False, electrons=True),
    Criterion("spectral_slope", "1/f slope of the spectrum", "1",
              ("pattern_slope_low", "frame_slope_low"), better="", thermal=False),
    Criterion("tail_index", "tail index", "1", ("tail_index",), better="", thermal=False),
    Criterion("pedestal", "black level", "DN", ("pedestal",), better="", thermal=False),
    Criterion("activation_energy", "activation energy", "eV", ("activation_energy_ev",),
              better="", thermal=False),
    Criterion("doubling_step", "doubling temperature", "C", ("doubling_step_c",),
              better="", thermal=False),
)  # fmt: skip

ERRORS = (
    Criterion("error_gaussian", "model error, Gaussian model", "", (), thermal=False, better=""),
    Criterion("error_paper", "model error, Wang 2025 model", "", (), thermal=False, better=""),
    Criterion("error_refined", "model error, refined model", "", (), thermal=False, better=""),
)
