"""Detectors of pyxel-sim 3.0.2: its model functions, one after another, on one detector.

What they draw, read in their frames:
- `empty()` resets the generators of pink noise: a model with a seed would draw the same noise in
  every frame, so each frame has a seed of its own;
- the fixed-pattern noise of `dark_current` is one scalar a call: it scales whole frames;
- `multiplication_register` adds to the charge that entered, not to what the last element gave:
  n elements of a gain g have 1/(1 - (g^(1/n) - 1)) together, hardly more than 1;
- `radiation_induced_dark_current` leaves out the pixels that were hit most often: at a small dose,
  where none is hit twice, it draws nothing;
- the maps of `dark_current_prerad` and `radiation_induced_dark_current` are drawn with their shot
  noise in one call: a map that stays is drawn once without it, and `shot_noise` follows.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from third_party.case import FRAMES, SHAPE, Claim, Drawn, Point, Recipe, near

VOLT_PER_E = 1e-5
TEMPERATURES = (283.0, 293.0, 303.0, 313.0, 323.0)
EXPOSURE_S = 1.0
ELEMENTS = 10  # of the multiplication register
ZERO_C = 273.15


@dataclass(frozen=True)
class Setup:
    """Ordinary values: gain (DN/e-), read noise (e-), offset (DN), dark current (nA/cm2)."""

    gain: float
    read_e: float
    offset_dn: float
    figure: float
    nonuniformity: float
    seed: int

    @property
    def noise_dn(self) -> float:
        """Without dark current."""
        return float(np.sqrt((self.gain * self.read_e) ** 2 + 1 / 12))


def draw_setup(seed: int) -> Setup:
    """At random."""
    rng = np.random.default_rng([seed, 0])
    gain = float(np.exp(rng.uniform(np.log(0.4), np.log(1.5))))
    return Setup(
        gain=gain,
        read_e=max(float(rng.uniform(2, 5)), 0.8 / gain),
        offset_dn=float(rng.integers(150, 400)),
        figure=float(np.exp(rng.uniform(np.log(0.01), np.log(0.04)))),
        nonuniformity=float(rng.uniform(0.05, 0.2)),
        seed=seed % (1 << 31),
    )


@dataclass(frozen=True)
class Chain:
    """What happens to a frame; each part is called with (detector, seed of the frame).

    ``dark`` gives the charge, ``pixels`` changes it, ``measure`` makes volts of it, ``volts``
    changes those, ``adc`` makes codes.
    """

    dark: Callable[[Any, int], None] | None = None
    pixels: tuple[Callable[[Any, int], None], ...] = ()
    measure: Callable[[Any, int], None] | None = None
    volts: tuple[Callable[[Any, int], None], ...] = ()
    adc: Callable[[Any], None] | None = None
    ccd: bool = False
    settings: dict[str, float] = field(default_factory=dict)


def detector(setup: Setup, ccd: bool = False) -> Any:
    """A detector whose converter gives ``gain`` DN for an electron."""
    import pyxel.detectors as kinds

    geometry = {
        "row": SHAPE[0], "col": SHAPE[1], "total_thickness": 10.0, "pixel_vert_size": 6.0,
        "pixel_horz_size": 6.0,
    }  # fmt: skip
    character = {
        "quantum_efficiency": 1.0,
        "charge_to_volt": kinds.ChargeToVoltSettings(value=VOLT_PER_E),
        "pre_amplification": 1.0,
        "full_well_capacity": 1e6,
        "adc_bit_resolution": 16,
        "adc_voltage_range": (0.0, 65535 * VOLT_PER_E / setup.gain),
    }
    surroundings = kinds.Environment(temperature=300.0)
    if ccd:
        return kinds.CCD(
            kinds.CCDGeometry(**geometry), surroundings, kinds.Characteristics(**character)
        )
    return kinds.CMOS(
        kinds.CMOSGeometry(**geometry), surroundings, kinds.CMOSCharacteristics(**character)
    )


def frames_of(setup: Setup, chain: Chain) -> dict[Point, np.ndarray]:
    """A temperature series."""
    device = detector(setup, chain.ccd)
    stacks = {}
    for number, kelvin in enumerate(TEMPERATURES):
        device.environment.temperature = kelvin
        frames = [expose(device, setup, chain, 100 * number + n) for n in range(FRAMES)]
        stacks[Point(round(kelvin - ZERO_C, 2), EXPOSURE_S)] = np.array(frames)
    return stacks


def expose(device: Any, setup: Setup, chain: Chain, number: int) -> np.ndarray:
    """One frame; every random number of it follows from its seed."""
    from pyxel.models.charge_collection import simple_collection
    from pyxel.models.charge_measurement import dc_offset, output_node_noise, simple_measurement
    from pyxel.models.readout_electronics import simple_adc

    seed = (setup.seed + 7919 * number) % (1 << 31)
    device.set_readout(times=[EXPOSURE_S])
    device.empty(True)
    device.readout_properties.time = EXPOSURE_S
    device.readout_properties.time_step = EXPOSURE_S
    np.random.seed(seed)  # noqa: NPY002  (the models draw from this one)
    (chain.dark or uneven_dark(setup))(device, seed)
    if device.charge.array.any():
        simple_collection(device)
    for step in chain.pixels:
        step(device, seed)
    if chain.measure is None:
        simple_measurement(device)
    else:
        chain.measure(device, seed)
    output_node_noise(device, std_deviation=setup.read_e * VOLT_PER_E)
    offset = chain.settings.get("offset_dn", setup.offset_dn)
    dc_offset(device, offset=offset / setup.gain * VOLT_PER_E)
    for step in chain.volts:
        step(device, seed)
    (chain.adc or simple_adc)(device)
    return np.asarray(device.image.array, np.uint16)


# ---- dark charge -------------------------------------------------------------------------------


def mean_dark_e(setup: Setup, kelvin: float) -> float:
    """The mean of pyxel's silicon dark current for an exposure, e-."""
    from astropy.units import Quantity
    from pyxel.models.charge_generation.dark_current import calculate_band_gap, simulate_dark_signal

    now, room = Quantity(kelvin, "K"), Quantity(300.0, "K")
    rate = simulate_dark_signal(
        temperature=now,
        pixel_area=Quantity(36.0, "um2 / pix"),
        figure_of_merit=Quantity(setup.figure, "nA / cm2"),
        band_gap=calculate_band_gap(now, "silicon"),
        band_gap_room_temperature=calculate_band_gap(room, "silicon"),
    )
    return float(rate.value) * EXPOSURE_S


def uniform_dark(setup: Setup, **more: Any) -> Callable[[Any, int], None]:
    """`dark_current` as it comes: every pixel alike."""

    def make(device: Any, seed: int) -> None:
        from pyxel.models.charge_generation import dark_current

        dark_current(device, figure_of_merit=setup.figure, **more)

    return make


def uneven_dark(
    setup: Setup, extra: Callable[[Any], np.ndarray] | None = None
) -> Callable[[Any, int], None]:
    """`dark_current_prerad` drawn once without shot noise, `shot_noise` in every frame."""

    def make(device: Any, seed: int) -> None:
        from pyxel.models.charge_generation import dark_current_prerad, simple_conversion
        from pyxel.models.photon_collection import shot_noise

        dark_current_prerad(
            device, figure_of_merit=setup.figure, shot_noise=False,
            spatial_noise_factor=setup.nonuniformity, tail_fraction=0.0,
            mu_ln=0.0, sigma_ln=0.1, gamma_k=1.0, gamma_theta=1.0, seed=setup.seed,
        )  # fmt: skip
        mean = np.array(device.charge.array)
        if extra is not None:
            mean = mean + extra(device)
        device.charge.empty()
        device.photon.array = np.maximum(mean, 0.0)
        shot_noise(device)
        simple_conversion(device, quantum_efficiency=1.0, binomial_sampling=False)

    return make


def tail(setup: Setup, share: float) -> Chain:
    """Log-normal factors of a share of the pixels: the tail of `dark_current_prerad`."""

    def extra(device: Any) -> np.ndarray:
        rng = np.random.default_rng([setup.seed, 9])
        sites = rng.random(SHAPE) < share
        mean = mean_dark_e(setup, device.environment.temperature)
        return mean * sites * rng.lognormal(2.5, 0.6, SHAPE)

    return Chain(dark=uneven_dark(setup, extra))


def radiation(setup: Setup, dose: float) -> Chain:
    """`radiation_induced_dark_current`, drawn once for the silicon."""

    def extra(device: Any) -> np.ndarray:
        from pyxel.models.charge_generation import radiation_induced_dark_current

        before = np.array(device.charge.array)
        radiation_induced_dark_current(
            device, depletion_volume=64.0, annealing_time=1500.0, displacement_dose=dose,
            shot_noise=False, seed=setup.seed,
        )  # fmt: skip
        return np.array(device.charge.array) - before

    return Chain(dark=uneven_dark(setup, extra))


def jitter(setup: Setup, factor: float) -> Chain:
    """`dark_current` with its fixed-pattern noise: one log-normal scalar a frame."""
    coldest = mean_dark_e(setup, TEMPERATURES[0])
    return Chain(dark=uniform_dark(setup, spatial_noise_factor=factor / max(coldest, 1.0)))


# ---- charge transfer and coupling --------------------------------------------------------------


def coupled(setup: Setup, coupling: float, diagonal: float = 0.0, uneven: float = 0.0) -> Chain:
    def measure(device: Any, seed: int) -> None:
        from pyxel.models.charge_measurement import simple_ipc

        simple_ipc(
            device, coupling=coupling, diagonal_coupling=diagonal * coupling,
            anisotropic_coupling=uneven * coupling,
        )  # fmt: skip

    return Chain(measure=measure)


def register(setup: Setup, gain: float) -> Chain:
    def multiply(device: Any, seed: int) -> None:
        from pyxel.models.charge_transfer import multiplication_register

        device.pixel.array = np.rint(device.pixel.array)
        multiplication_register(device, total_gain=int(gain), gain_elements=ELEMENTS, seed=seed)

    few = replace(setup, figure=0.2 * setup.figure)  # it draws for every electron
    return Chain(dark=uneven_dark(few), pixels=(multiply,), ccd=True)


def distortion(setup: Setup, density: float) -> Chain:
    """`cdm`: traps that release within a few transfers, behind hot pixels."""

    def transfer(device: Any, seed: int) -> None:
        from pyxel.models.charge_transfer import cdm

        cdm(
            device, direction="parallel", beta=0.37, trap_release_times=[3e-3],
            trap_densities=[density], sigma=[1e-10], full_well_capacity=1e6,
            max_electron_volume=1.6e-10, transfer_period=1e-3,
        )  # fmt: skip

    return Chain(dark=tail(setup, 0.004).dark, pixels=(transfer,), ccd=True)


def hits(setup: Setup, count: float) -> Chain:
    """`cosmix`-like protons by `charge_deposition`: straight tracks through the layer."""

    def deposit(device: Any, seed: int) -> None:
        from pathlib import Path

        import pyxel
        from pyxel.models.charge_generation import charge_deposition

        data = Path(pyxel.__file__).parent / "models/charge_generation/data"
        charge_deposition(
            device, flux=count / EXPOSURE_S, step_size=1.0, energy_mean=100.0, energy_spread=10.0,
            energy_spectrum=data / "proton_L2_solarMax_NoShielding.txt",
            ehpair_creation=3.65, material_density=2.33,
            stopping_power_curve=data / "protons-in-silicon_stopping-power.csv", seed=seed,
        )  # fmt: skip

    dark = uneven_dark(setup)

    def make(device: Any, seed: int) -> None:
        dark(device, seed)
        deposit(device, seed)

    return Chain(dark=make)


# ---- readout -----------------------------------------------------------------------------------


def pink(setup: Setup, amount: float) -> Chain:
    def add(device: Any, seed: int) -> None:
        from pyxel.models.charge_measurement import correlated_pink_noise_cmos

        correlated_pink_noise_cmos(device, std=amount * setup.read_e, seed=seed)

    return Chain(volts=(add,))


def alternating(setup: Setup, amount: float) -> Chain:
    def add(device: Any, seed: int) -> None:
        from pyxel.models.charge_measurement import alternating_column_noise_cmos

        alternating_column_noise_cmos(device, std=amount * setup.read_e, seed=seed)

    return Chain(volts=(add,))


def bent(setup: Setup, curvature: float) -> Chain:
    def bend(device: Any, seed: int) -> None:
        from pyxel.models.charge_measurement import output_node_linearity_poly

        full = 4 * mean_dark_e(setup, TEMPERATURES[-1]) * VOLT_PER_E
        output_node_linearity_poly(device, coefficients=[0.0, 1.0, -curvature / full])

    def measure(device: Any, seed: int) -> None:
        from pyxel.models.charge_measurement import simple_measurement

        simple_measurement(device)
        bend(device, seed)

    return Chain(measure=measure)


def successive(setup: Setup, strength: float) -> Chain:
    """`sar_adc_with_noise`: references of five bits that are off by so many DN."""

    def convert(device: Any) -> None:
        from pyxel.models.readout_electronics import sar_adc_with_noise

        off = np.zeros(16)
        rng = np.random.default_rng([setup.seed, 5])
        step = VOLT_PER_E / setup.gain  # 1 DN
        off[8:13] = strength * step * rng.choice([-1, 1], 5)  # bits worth 128 to 8 DN
        sar_adc_with_noise(device, strengths=tuple(off), noises=(0.0,) * 16)

    return Chain(adc=convert)


def low_black(setup: Setup, amount: float) -> Chain:
    """The offset so many deviations of the noise above code 0, with a small dark current."""
    small = replace(setup, figure=0.1 * setup.figure)
    return Chain(dark=uneven_dark(small), settings={"offset_dn": amount * setup.noise_dn})


# ---- claims ------------------------------------------------------------------------------------

Claims = Callable[[Setup, float], tuple[Claim, ...]]


def hot_dn(setup: Setup) -> float:
    """Mean dark charge at the hottest point, DN."""
    return setup.gain * mean_dark_e(setup, TEMPERATURES[-1])


def ordinary(s: Setup, amount: float) -> tuple[Claim, ...]:
    return (
        near("charge_slope", s.gain, 0.12),
        # normal but for the counting of the charge; a log-normal nonuniformity has 3 times its own
        Claim("pattern_skewness", -0.5 * s.nonuniformity, 0.5 * s.nonuniformity + 0.04),
        Claim("row_noise_sd", 0, 0.05 * s.noise_dn, 0),
        Claim("column_fpn_sd", 0, 0.1 * s.noise_dn, 0),
        Claim("smooth_rms", 0, 0.15 * s.noise_dn, 0),
        Claim("frame_offset_sd", 0, 0.05 * s.noise_dn, 0),
    )


def hardly_multiplied(s: Setup, amount: float) -> tuple[Claim, ...]:
    """Of n elements of a gain 1 + l, n large: 1/(1 - l) with a variance of l/(1 - l^2) each."""
    each = amount ** (1 / ELEMENTS) - 1
    gain, variance = 1 / (1 - each), each / (1 - each**2)
    return (near("charge_slope", s.gain * (gain + variance), 0.2),)


def scaled_frames(s: Setup, amount: float) -> tuple[Claim, ...]:
    """Whole frames differ by far more than their pixels' noise allows."""
    return (Claim("frame_offset_sd", 0.5 * s.noise_dn / 256 * 10, np.inf, 1),)


def damaged(s: Setup, amount: float) -> tuple[Claim, ...]:
    return (Claim("hot_share", 2e-4, 0.3, -1, {"sigmas": 6.0}), Claim("hot_spread", 0.2, 3.0))


def coupling(s: Setup, amount: float) -> tuple[Claim, ...]:
    charge = s.gain**2 * mean_dark_e(s, TEMPERATURES[-1])
    shot = charge / (charge + s.noise_dn**2)
    return (
        near("neighbour_correlation", 2 * amount * shot, 0.4, options={"rows": 1, "columns": 0}),
    )


def transient(s: Setup, amount: float) -> tuple[Claim, ...]:
    return (Claim("transient_share", 0.5 * amount / 65536, 60 * amount / 65536),)


def raster(lag: int) -> Claims:
    def claims(s: Setup, amount: float) -> tuple[Claim, ...]:
        variance = (s.gain * amount * s.read_e) ** 2
        return (Claim("raster_covariance", 0.25 * variance, 1.2 * variance, 0, {"lag": lag}),)

    return claims


def curved(s: Setup, amount: float) -> tuple[Claim, ...]:
    return (Claim("charge_slope", 0.15 * s.gain, s.gain * (1 - 0.2 * amount)),)


def tailing(s: Setup, amount: float) -> tuple[Claim, ...]:
    return (Claim("trailing_share", 0.005, 0.5, -1, {"sigmas": 10.0}),)


def rough(s: Setup, amount: float) -> tuple[Claim, ...]:
    return (Claim("code_roughness", 0.05, 2.0),)


def clipped(s: Setup, amount: float) -> tuple[Claim, ...]:
    return (Claim("lowest_code_share", 0.005, 0.6, 0),)


Make = Callable[[Setup, float], Chain]

# name: (kinds, chain, claims, moderate, strong)
EFFECTS: dict[str, tuple[tuple[str, ...], Make, Claims, float, float]] = {
    "tail": (("hot_pixels",), tail, damaged, 0.002, 0.01),
    "radiation": (("damage_hot_pixels",), radiation, damaged, 8.0, 30.0),
    "dark_jitter": (("dark_jitter",), jitter, scaled_frames, 0.01, 0.04),
    "coupling": (("crosstalk",), coupled, coupling, 0.012, 0.03),
    "uneven_coupling": (("anisotropic_crosstalk",), lambda s, a: coupled(s, a, 0.1, 0.5),
                        lambda s, a: coupling(s, 0.5 * a), 0.02, 0.04),
    "register": ((), register, hardly_multiplied, 10.0, 100.0),
    "distortion": (("transfer_tails", "hot_pixels"), distortion, tailing, 6e10, 3e11),
    "hits": (("tracks",), hits, transient, 8.0, 40.0),
    "pink": (("flicker_cutoff",), pink, raster(1), 0.5, 1.2),
    "alternating": (("alternating_flicker",), alternating, raster(2), 0.5, 1.2),
    "nonlinearity": (("nonlinearity",), bent, curved, 0.4, 1.0),
    "successive": (("sar_converter",), successive, rough, 0.5, 1.5),
    "black_clipping": (("clipping_at_zero",), low_black, clipped, 1.5, 0.5),
}  # fmt: skip

PAIRS = (("tail", "pink"), ("coupling", "alternating"), ("radiation", "pink"))
UNIFORM, ORDINARY = 2, 4


def _drawn(name: str, amount: float, seed: int) -> Drawn:
    _, make, claims, *_ = EFFECTS[name]
    setup = draw_setup(seed)
    return Drawn(
        frames_of(setup, make(setup, amount)), claims(setup, amount),
        vars(setup) | {"amount": amount},
    )  # fmt: skip


def _together(names: tuple[str, str], seed: int) -> Drawn:
    setup = draw_setup(seed)
    one, two = (EFFECTS[n][1](setup, EFFECTS[n][4]) for n in names)
    chain = Chain(
        dark=one.dark or two.dark, pixels=one.pixels + two.pixels,
        measure=one.measure or two.measure, volts=one.volts + two.volts,
        adc=one.adc or two.adc, settings=one.settings | two.settings,
    )  # fmt: skip
    return Drawn(frames_of(setup, chain), (), vars(setup))


def _plain(chain: Callable[[Setup], Chain], seed: int) -> Drawn:
    setup = draw_setup(seed)
    return Drawn(frames_of(setup, chain(setup)), ordinary(setup, 0.0), vars(setup))


def _single(name: str) -> Recipe:
    return Recipe(EFFECTS[name][0], lambda a, seed: _drawn(name, a, seed), EFFECTS[name][3:])


def _pair(names: tuple[str, str]) -> Recipe:
    kinds = EFFECTS[names[0]][0] + EFFECTS[names[1]][0]
    return Recipe(kinds, lambda a, seed: _together(names, seed))


RECIPES: dict[str, Recipe] = {
    **{name: _single(name) for name in EFFECTS},
    **{"+".join(names): _pair(names) for names in PAIRS},
    **{
        f"uniform_{n}": Recipe((), lambda a, s: _plain(lambda u: Chain(dark=uniform_dark(u)), s))
        for n in range(1, UNIFORM + 1)
    },
    **{
        f"ordinary_{n}": Recipe((), lambda a, s: _plain(lambda u: Chain(), s))
        for n in range(1, ORDINARY + 1)
    },
}
