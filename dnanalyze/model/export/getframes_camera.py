"""A model as a camera preset of getframes (a TOML file of its ``CameraConfig``)."""

from __future__ import annotations

import json
import math
from typing import Any

from dnanalyze.model.effect import Effect
from dnanalyze.model.export.electrons import Electrons, Translation, in_electrons
from dnanalyze.model.noise_model import NoiseModel

PIXEL_UM = 10.0  # a million of these are 1 cm2, the area in which hits are counted there
NEVER_C = 1e6  # doubling temperature of a dark current that stays


def getframes_preset(
    model: NoiseModel, shape: tuple[int, int] = (512, 512), temperature_c: float | None = None
) -> Translation:
    """The model as far as a camera of getframes 2.6 goes.

    Parameters
    ----------
    model : NoiseModel
    shape : tuple of int
        Rows and columns.
    temperature_c : float, optional
        Where the dark current is stated, C; the model's reference by default.

    Returns
    -------
    Translation
        TOML, and what it lacks.

    Raises
    ------
    InputError
        The model has no dark current or no conversion gain.

    Examples
    --------
    >>> from dnanalyze.model.effects.convolved_lognormal import ConvolvedLognormal
    >>> from dnanalyze.model.effects.dark_shot_noise import DarkShotNoise
    >>> from dnanalyze.model.noise_model import NoiseModel
    >>> model = NoiseModel((ConvolvedLognormal(mu=2.0, phi=0.0), DarkShotNoise(dn_per_e=0.5)))
    >>> "gain_e_per_adu = 2" in getframes_preset(model).text
    True
    """
    here = in_electrons(model, temperature_c)
    fields, lost = _camera(here, shape), _lost_of_base(model)
    for effect in model.effects:
        told = WORDS.get(effect.name)
        if told is not None:
            more, without = told(effect, here)
            fields |= more
            lost += [f"{effect.name}: {what}" for what in without]
        elif effect.name not in PLAIN:
            lost.append(f"{effect.name}: no parameter for it")
    lines = ["# Camera of getframes, from a noise model fitted by dnanalyze."]
    lines += [f"# Not expressed: {what}" for what in lost]
    lines += [f"{name} = {_toml(value)}" for name, value in fields.items()]
    return Translation("\n".join(lines) + "\n", lost)


PLAIN = {
    "convolved_lognormal", "dark_shot_noise", "read_noise", "pixel_fpn", "quantization",
}  # fmt: skip


def _camera(here: Electrons, shape: tuple[int, int]) -> dict[str, Any]:
    """What every camera has. A log-normal read noise is stated there by its mean, not its rms."""
    top = (2**here.bits - 1 - here.offset_dn) / here.dn_per_e
    return {
        "name": "dnanalyze model",
        "sensor_type": "CMOS",
        "resolution": list(shape),
        "pixel_size_um": PIXEL_UM,
        "quantum_efficiency": 1.0,
        "full_well_e": top,
        "bit_depth": here.bits,
        "gain_e_per_adu": 1.0 / here.dn_per_e,
        "bias_offset_adu": here.offset_dn,
        "bias_pixel_spread_adu": here.pixel_offset_dn,
        "read_noise_e": here.read_e * math.exp(-(here.read_spread**2) / 2.0),
        "read_noise_nonuniformity": here.read_spread,
        "dark_current_e_per_s": here.dark_e_s,
        "dark_current_ref_temp_c": here.point.temperature_c,
        "dark_current_doubling_temp_c": min(here.doubling_c, NEVER_C),
        "dark_current_nonuniformity": here.dark_spread,
    }


def _lost_of_base(model: NoiseModel) -> list[str]:
    base = model.effects[model.names.index("convolved_lognormal")]
    at, lost = model.reference, ["dark current: one doubling temperature for all, no Arrhenius law"]
    if base.value("phi", at) > 0.0:
        lost.append("convolved_lognormal.phi: correlation of neighbours' dark current")
    lost.append("convolved_lognormal.sigma: noise of the random kernel")
    return lost


Told = tuple[dict[str, Any], list[str]]


def _hot_pixels(effect: Effect, here: Electrons) -> Told:
    point, law = here.point, getattr(effect, "law", "exponential")
    tail = effect.value("tail", point)
    mean = effect.value("scale", point) / (1.0 - tail if 0.0 < tail < 1.0 else 1.0)
    lost = ["their own activation energy"]
    if law != "narrow":
        lost.append(f"their {law} distribution; all have the mean dark current")
    return {
        "hot_pixel_fraction": effect.value("fraction", point),
        "hot_pixel_factor": 1.0 + mean / (here.dn_per_e * here.dark_e),
    }, lost


def _noisy_pixels(effect: Effect, here: Electrons) -> Told:
    own = here.read_e * here.dn_per_e
    added = effect.value("sigma", here.point)
    if own == 0.0:
        return {}, ["a factor of the read noise, which is 0 in this model"]
    return {
        "read_noise_rts_fraction": effect.value("fraction", here.point),
        "read_noise_rts_factor": math.hypot(1.0, added / own),
    }, []


def _dead_pixels(effect: Effect, here: Electrons) -> Told:
    return {"dead_pixel_fraction": effect.value("fraction", here.point)}, []


def _crosstalk(effect: Effect, here: Electrons) -> Told:
    words = {
        "diagonal": "the share of the diagonal neighbours",
        "anisotropy": "the difference between the shares along rows and columns",
    }
    lost = [text for name, text in words.items() if effect.value(name, here.point)]
    return {"ipc_coupling": effect.value("alpha", here.point)}, lost


def _offset_drift(effect: Effect, here: Electrons) -> Told:
    white = effect.value("white", here.point)
    return {"readout_common_mode_noise_adu": white}, ["offsets that drift or settle"]


def _column_taps(effect: Effect, here: Electrons) -> Told:
    sigma = effect.value("sigma", here.point)
    begins = [round(x) for x in getattr(effect, "begins")]  # noqa: B009
    taps = int(getattr(effect, "taps"))  # noqa: B009
    lost = ["the measured levels; getframes draws them at random"]
    rows = getattr(effect, "axis") == "rows"  # noqa: B009
    if getattr(effect, "kind") == "interleaved":  # noqa: B009
        if rows:
            return {}, ["interleaved taps of rows"]
        return {"readout_channel_count": taps, "bias_channel_spread_adu": sigma}, lost
    count = len(begins) + 1 if begins else taps
    fields: dict[str, Any] = {
        "amplifier_layout": [count, 1] if rows else [1, count],
        "amp_offset_spread_adu": sigma,
    }
    if begins:
        fields[f"amplifier_boundaries_{'y' if rows else 'x'}_px"] = begins
    return fields, lost


def _cosmic_rays(effect: Effect, here: Electrons) -> Told:
    return {
        "cosmic_ray_rate_per_cm2_s": effect.value("rate", here.point),
        "cosmic_ray_track_length_px": effect.value("length", here.point),
    }, ["the charge of a hit"]


WORDS = {
    "hot_pixels": _hot_pixels,
    "noisy_pixels": _noisy_pixels,
    "dead_pixels": _dead_pixels,
    "crosstalk": _crosstalk,
    "offset_drift": _offset_drift,
    "column_taps": _column_taps,
    "cosmic_rays": _cosmic_rays,
}


def _toml(value: Any) -> str:
    """A value of a TOML file."""
    return f"{value:.6g}" if isinstance(value, float) else json.dumps(value)
