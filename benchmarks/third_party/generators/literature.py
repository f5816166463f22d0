"""Noise models of the literature, from their printed formulas; NumPy alone.

- eld: raw frames in extreme low light. Shot noise, Tukey-lambda read noise, rows, a bias of each
  colour (Wei et al., CVPR 2020).
- starlight: video at starlight. Gaussian read noise, rows of a frame, rows that stay, a periodic
  noise of four columns (Monakhova et al., CVPR 2022).
- h2rg: an infrared array read through four outputs side by side, every other one mirrored; pink
  noise common to the outputs, and of each (Rauscher, PASP 127, 1144, 2015).
- guide: a cooled CCD with hot pixels and offset columns (Craig and Chambers, CCD Data Reduction
  Guide, the astropy project).
- konnik: CMOS with log-normal dark current, reset noise and column offsets that follow an
  autoregression (Konnik and Welsh, arXiv:1412.4031, 2014), and telegraph noise.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass

import numpy as np

from third_party.case import FRAMES, SHAPE, Claim, Drawn, Point, Recipe, near
from third_party.dark_current import dark_growth

Generator = np.random.Generator
ROWS, COLUMNS = SHAPE
OUTPUTS, TURN = 4, 12  # of the infrared array; pixel periods between two rows


@dataclass(frozen=True)
class Camera:
    """Gain (DN/e-), read noise (DN), dark charge at the hottest temperature (e-) and its gap."""

    gain: float
    read_dn: float
    dark_e: float
    gap_ev: float
    pedestal: float
    exposure_s: float
    temperatures_c: tuple[float, ...]

    def charge(self, celsius: float) -> float:
        """Mean dark charge at a temperature, e-."""
        return self.dark_e * dark_growth(celsius, self.temperatures_c[-1], self.gap_ev)


# the electrons of a frame, its random numbers -> DN beyond the pedestal, before rounding
Read = Callable[[np.ndarray, Generator], np.ndarray]
# the camera, random numbers of its fixed maps, an amount -> relative dark current, reading, claims
Made = tuple[np.ndarray, Read, tuple[Claim, ...]]
Model = Callable[[Camera, Generator, float], Made]
EVEN = np.ones(SHAPE)


def drawn(model: Model, amount: float, seed: int) -> Drawn:
    """A camera of ordinary values, five temperatures."""
    rng = np.random.default_rng([seed, 0])
    start, step = float(rng.choice([-10, 0, 15])), float(rng.choice([8, 10, 12]))
    camera = Camera(
        gain=float(np.exp(rng.uniform(np.log(0.4), np.log(2.0)))),
        read_dn=float(rng.uniform(1.5, 5.0)),
        dark_e=float(np.exp(rng.uniform(np.log(40), np.log(300)))),
        gap_ev=float(rng.uniform(1.12, 1.4)),
        pedestal=float(rng.integers(150, 600)),
        exposure_s=float(rng.choice([0.1, 1.0, 30.0])),
        temperatures_c=tuple(start + step * n for n in range(5)),
    )
    relative, read, claims = model(camera, np.random.default_rng([seed, 1]), amount)
    stacks = {}
    for number, celsius in enumerate(camera.temperatures_c):
        frames = []
        for frame in range(FRAMES):
            now = np.random.default_rng([seed, 2, number, frame])
            electrons = now.poisson(camera.charge(celsius) * relative).astype(float)
            frames.append(np.rint(camera.pedestal + read(electrons, now)))
        codes = np.clip(frames, 0, 65535).astype(np.uint16)
        stacks[Point(celsius, camera.exposure_s)] = codes
    return Drawn(stacks, claims, asdict(camera) | {"amount": amount})


def tukey(rng: Generator, lam: float, sigma: float) -> np.ndarray:
    """Tukey's lambda by its quantile function (u^lam - (1 - u)^lam) / lam, scaled to sigma."""
    u = rng.random(SHAPE)
    grid = (np.arange(200_000) + 0.5) / 200_000
    unit = np.std((grid**lam - (1 - grid) ** lam) / lam)
    return sigma * (u**lam - (1 - u) ** lam) / lam / unit


NORMAL = 0.14  # lambda at which Tukey's law is nearly the normal one


def eld(c: Camera, lam: float, rows: float, bias: np.ndarray) -> Read:
    """K times the shot noise, read noise, rows, and a bias of each of four colours; DN."""
    colour = np.tile(bias.reshape(2, 2), (ROWS // 2, COLUMNS // 2))

    def read(electrons: np.ndarray, rng: Generator) -> np.ndarray:
        lines = rows * rng.standard_normal((ROWS, 1))
        return c.gain * electrons + tukey(rng, lam, c.read_dn) + lines + colour

    return read


def eld_tails(c: Camera, rng: Generator, amount: float) -> Made:
    """Lambda below 0: tails heavier than those of the logistic law."""
    return EVEN, eld(c, -amount, 0.0, np.zeros(4)), (Claim("temporal_kurtosis", 0.4, 99.0, 0),)


def eld_rows(c: Camera, rng: Generator, amount: float) -> Made:
    sigma = amount * c.read_dn
    return EVEN, eld(c, NORMAL, sigma, np.zeros(4)), (near("row_noise_sd", sigma, 0.25, point=0),)


def eld_colours(c: Camera, rng: Generator, amount: float) -> Made:
    bias = amount * c.read_dn * np.array([-1.2, 0.5, -0.3, 1.0])
    return EVEN, eld(c, NORMAL, 0.0, bias), (near("mosaic_sd", bias.std(), 0.4, point=0),)


def eld_all(c: Camera, rng: Generator, amount: float) -> Made:
    """All of them."""
    sigma, bias = 0.4 * c.read_dn, 0.4 * c.read_dn * np.array([-1.2, 0.5, -0.3, 1.0])
    claims = (
        near("row_noise_sd", sigma, 0.3, point=0),
        near("mosaic_sd", bias.std(), 0.5, point=0),
        Claim("temporal_kurtosis", 0.3, 99.0, 0),
    )
    return EVEN, eld(c, -0.15, sigma, bias), claims


def starlight(c: Camera, rows: float, fixed: np.ndarray, wave: float) -> Read:
    """Read noise, rows of each frame, a fixed map, and a wave of four columns; DN."""
    angle = np.pi / 2.0 * np.arange(COLUMNS)

    def read(electrons: np.ndarray, rng: Generator) -> np.ndarray:
        a, b = wave * rng.standard_normal(2)
        noise = c.read_dn * rng.standard_normal(SHAPE) + rows * rng.standard_normal((ROWS, 1))
        return c.gain * electrons + noise + fixed + a * np.cos(angle) + b * np.sin(angle)

    return read


def _pixels(c: Camera, rng: Generator) -> np.ndarray:
    return 0.4 * c.read_dn * rng.standard_normal(SHAPE)


def starlight_rows(c: Camera, rng: Generator, amount: float) -> Made:
    sigma = amount * c.read_dn
    read = starlight(c, sigma, _pixels(c, rng), 0.0)
    return EVEN, read, (near("row_noise_sd", sigma, 0.25, point=0),)


def starlight_banding(c: Camera, rng: Generator, amount: float) -> Made:
    """Rows that stay as they are over the whole clip."""
    lines = amount * c.read_dn * rng.standard_normal((ROWS, 1))
    read = starlight(c, 0.0, _pixels(c, rng) + lines, 0.0)
    return EVEN, read, (near("row_fpn_sd", lines.std(), 0.25, point=0),)


def starlight_wave(c: Camera, rng: Generator, amount: float) -> Made:
    read = starlight(c, 0.0, _pixels(c, rng), amount * c.read_dn)
    sigma = amount * c.read_dn  # of the columns of one frame, from frame to frame
    return EVEN, read, (near("column_noise_sd", sigma, 0.6, point=0),)


def pink(rng: Generator, count: int) -> np.ndarray:
    """Noise of power 1/f, of unit variance."""
    f = np.fft.rfftfreq(count)
    f[0] = f[1]
    phases = np.exp(2j * np.pi * rng.random(f.size))
    x = np.fft.irfft(rng.rayleigh(1.0, f.size) * f**-0.5 * phases, count)
    return (x - x.mean()) / x.std()


def h2rg(c: Camera, common: float, own: float) -> Read:
    """Four outputs at a time along the rows, every other one mirrored; pink noise in DN."""
    width = COLUMNS // OUTPUTS

    def scanned(rng: Generator) -> np.ndarray:
        return pink(rng, ROWS * (width + TURN)).reshape(ROWS, -1)[:, :width]

    def read(electrons: np.ndarray, rng: Generator) -> np.ndarray:
        dn = c.gain * electrons + c.read_dn * rng.standard_normal(SHAPE)
        shared = common * scanned(rng)
        for output in range(OUTPUTS):
            noise = shared + own * scanned(rng)
            strip = np.s_[:, output * width : (output + 1) * width]
            dn[strip] += noise[:, ::-1] if output % 2 else noise
        return dn

    return read


def _lognormal(rng: Generator, spread: float) -> np.ndarray:
    return np.exp(spread * rng.standard_normal(SHAPE) - spread**2 / 2.0)


def _of_outputs(common: float, own: float) -> Model:
    def model(c: Camera, rng: Generator, amount: float) -> Made:
        read = h2rg(c, common * amount * c.read_dn, own * amount * c.read_dn)
        variance = (amount * c.read_dn) ** 2
        claim = Claim("raster_covariance", 0.3 * variance, 1.0 * variance, 0)
        return _lognormal(rng, 0.25), read, (claim,)

    return model


def guide(c: Camera, columns: np.ndarray) -> Read:
    """Read noise and columns whose bias is higher; DN."""

    def read(electrons: np.ndarray, rng: Generator) -> np.ndarray:
        return c.gain * electrons + c.read_dn * rng.standard_normal(SHAPE) + columns

    return read


def guide_hot(c: Camera, rng: Generator, amount: float) -> Made:
    """A share of the pixels with more dark current, exponential; at least 8 times the usual."""
    hot = rng.random(SHAPE) < amount
    relative = 1.0 + hot * (8.0 + rng.exponential(30.0, SHAPE))
    claim = Claim("hot_share", 0.5 * amount, 1.5 * amount, -1, {"sigmas": 5.0})
    return relative, guide(c, np.zeros(COLUMNS)), (claim,)


def guide_columns(c: Camera, rng: Generator, amount: float) -> Made:
    """A few columns with an offset of their own."""
    columns = np.zeros(COLUMNS)
    at = rng.choice(np.arange(4, COLUMNS - 4), 5, replace=False)
    columns[at] = amount * c.read_dn * rng.uniform(0.7, 1.6, at.size)
    return EVEN, guide(c, columns), (near("column_fpn_sd", columns.std(), 0.35, point=0),)


def konnik(c: Camera, columns: np.ndarray, traps: np.ndarray, step: float) -> Read:
    """Reset noise in electrons, the amplifier's in DN, column offsets, telegraph steps; DN."""
    reset = c.read_dn / c.gain

    def read(electrons: np.ndarray, rng: Generator) -> np.ndarray:
        up = traps & (rng.random(SHAPE) < 0.5)
        noisy = electrons + reset * rng.standard_normal(SHAPE)
        return c.gain * noisy + 1.0 * rng.standard_normal(SHAPE) + columns + step * up

    return read


NONE = np.zeros(SHAPE, bool)


def konnik_fpn(c: Camera, rng: Generator, amount: float) -> Made:
    """A log-normal dark current and nothing else: what the baseline model has."""
    read = konnik(c, np.zeros(COLUMNS), NONE, 0.0)
    return _lognormal(rng, amount), read, (near("charge_slope", c.gain, 0.2),)


def konnik_columns(c: Camera, rng: Generator, amount: float) -> Made:
    """x_j = 0.5 x_(j-1) + e_j over the columns."""
    columns = np.zeros(COLUMNS)
    for j, e in enumerate(rng.standard_normal(COLUMNS)):
        columns[j] = (0.5 * columns[j - 1] if j else 0.0) + e
    columns *= amount * c.read_dn / columns.std()
    read = konnik(c, columns, NONE, 0.0)
    return _lognormal(rng, 0.3), read, (near("column_fpn_sd", columns.std(), 0.3, point=0),)


def konnik_telegraph(c: Camera, rng: Generator, amount: float) -> Made:
    """2 % of the pixels are up in half of the frames."""
    step = amount * float(np.hypot(c.read_dn, 1.0))
    read = konnik(c, np.zeros(COLUMNS), rng.random(SHAPE) < 0.02, step)
    claim = Claim("noisy_share", 0.002, 0.1, 0, {"times": 1.8})
    return _lognormal(rng, 0.3), read, (claim,)


# name: (kinds, model, moderate, strong)
EFFECTS: dict[str, tuple[tuple[str, ...], Model, float, float]] = {
    "eld_tails": (("heavy_tailed_read_noise",), eld_tails, 0.05, 0.2),
    "eld_rows": (("row_noise",), eld_rows, 0.25, 0.8),
    "eld_colours": (("cfa_mismatch",), eld_colours, 0.3, 1.0),
    "starlight_rows": (("row_noise",), starlight_rows, 0.25, 0.8),
    "starlight_banding": (("row_fpn",), starlight_banding, 0.25, 0.8),
    "starlight_wave": (("periodic_pattern",), starlight_wave, 0.25, 0.6),
    "h2rg_common": (("output_flicker",), _of_outputs(1.0, 0.0), 0.5, 1.0),
    "h2rg_own": (("output_flicker",), _of_outputs(0.0, 1.0), 0.5, 1.0),
    "guide_hot": (("hot_pixels",), guide_hot, 0.001, 0.006),
    "guide_columns": (("defect_lines",), guide_columns, 0.6, 3.0),
    "konnik_columns": (("column_fpn",), konnik_columns, 0.25, 0.8),
    "konnik_telegraph": (("rts",), konnik_telegraph, 5.0, 10.0),
}
ORDINARY = {"lognormal_1": 0.2, "lognormal_2": 0.35, "lognormal_3": 0.5}


def _recipe(hides: tuple[str, ...], model: Model, *amounts: float) -> Recipe:
    return Recipe(hides, lambda amount, seed: drawn(model, amount, seed), amounts)


RECIPES: dict[str, Recipe] = {
    **{name: _recipe(*row) for name, row in EFFECTS.items()},
    "eld_all": _recipe(("heavy_tailed_read_noise", "row_noise", "cfa_mismatch"), eld_all, 1.0),
    **{name: _recipe((), konnik_fpn, spread) for name, spread in ORDINARY.items()},
}
