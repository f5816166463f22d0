"""A model as a pipeline of Pyxel (a YAML file of its exposure mode) at one temperature."""

from __future__ import annotations

from typing import Any

import yaml

from dnanalyze.model.export.electrons import Electrons, Translation, in_electrons
from dnanalyze.model.noise_model import NoiseModel

VOLT_PER_E = 1e-5
ZERO_C = 273.15
MOST_CODES = 2**16 - 1  # the widest converter there
PIXEL_UM = 10.0
HALF_CODE = 0.5  # DN: its converter truncates, and does not round
EXPRESSED = {
    "convolved_lognormal", "dark_shot_noise", "read_noise", "quantization", "crosstalk",
}  # fmt: skip


def pyxel_pipeline(
    model: NoiseModel, shape: tuple[int, int] = (512, 512), temperature_c: float | None = None
) -> Translation:
    """The model as far as the detector models of Pyxel 3.0 go.

    Parameters
    ----------
    model : NoiseModel
    shape : tuple of int
        Rows and columns.
    temperature_c : float, optional
        C; the model's reference by default.

    Returns
    -------
    Translation
        YAML, and what it lacks.

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
    >>> "simple_dark_current" in pyxel_pipeline(model).text
    True
    """
    here = in_electrons(model, temperature_c)
    lost = [
        f"temperature: the file is valid at {here.point.temperature_c:.1f} C only",
        "convolved_lognormal.delta, phi, sigma: every pixel has the same dark current",
    ]
    if here.read_spread:
        lost.append("read_noise.spread: every pixel has the same read noise")
    lost += [f"{n}: no model for it" for n in model.names if n not in EXPRESSED]
    head = ["# Pipeline of Pyxel, from a noise model fitted by dnanalyze."]
    head += [f"# Not expressed: {what}" for what in lost]
    plain = _document(here, shape, model)
    return Translation("\n".join(head) + "\n" + yaml.safe_dump(plain, sort_keys=False), lost)


def _document(here: Electrons, shape: tuple[int, int], model: NoiseModel) -> dict[str, Any]:
    codes = min(2**here.bits - 1, MOST_CODES)
    bits = min(here.bits, 16)
    volt_per_dn = VOLT_PER_E / here.dn_per_e
    crosstalk = model.get("crosstalk")
    pipeline: dict[str, Any] = {
        "charge_generation": [
            _model("charge_generation", "simple_dark_current", dark_rate=here.dark_e_s)
        ],
        "charge_collection": [_model("charge_collection", "simple_collection")],
        "charge_measurement": [_model("charge_measurement", "simple_measurement")],
        "readout_electronics": [_model("readout_electronics", "simple_adc")],
    }
    volts = pipeline["charge_measurement"]
    if crosstalk is not None:
        share = crosstalk.value("alpha", here.point)
        volts.append(
            _model(
                "charge_measurement",
                "simple_ipc",
                coupling=share,
                diagonal_coupling=share * crosstalk.value("diagonal", here.point),
                anisotropic_coupling=share * crosstalk.value("anisotropy", here.point),
            )
        )
    read = here.read_e * VOLT_PER_E
    volts.append(_model("charge_measurement", "output_node_noise", std_deviation=read))
    volts.append(
        _model("charge_measurement", "dc_offset", offset=(here.offset_dn + HALF_CODE) * volt_per_dn)
    )
    assert here.point.temperature_c is not None
    return {
        "exposure": {
            "readout": {"times": [here.exposure_s], "non_destructive": False},
        },
        "cmos_detector": {
            "geometry": {
                "row": shape[0], "col": shape[1], "total_thickness": 10.0,
                "pixel_vert_size": PIXEL_UM, "pixel_horz_size": PIXEL_UM,
            },
            "environment": {"temperature": here.point.temperature_c + ZERO_C},
            "characteristics": {
                "quantum_efficiency": 1.0,
                "charge_to_volt": {"value": VOLT_PER_E},
                "pre_amplification": 1.0,
                "adc_bit_resolution": bits,
                "adc_voltage_range": [0.0, codes * volt_per_dn],
                "full_well_capacity": 1e7,
            },
        },
        "pipeline": pipeline,
    }  # fmt: skip


def _model(group: str, name: str, **arguments: float) -> dict[str, Any]:
    made: dict[str, Any] = {"name": name, "func": f"pyxel.models.{group}.{name}", "enabled": True}
    return made | ({"arguments": arguments} if arguments else {})
