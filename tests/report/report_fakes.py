"""Results as the library would give them, small and of known content."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np

from dnanalyze.analyzers.statistics import SettingStatistics, Statistics, Value
from dnanalyze.classifier.result import Cell, Classification, Told
from dnanalyze.detection.results import Detection, FilterEstimate, Finding, TailBound
from dnanalyze.detection.series import SuppressionSeries
from dnanalyze.fitting.fit import Parameter
from dnanalyze.loaders.captures import CaptureSet, Frame, OperatingPoint, Sensor, Setting
from dnanalyze.model.effects.convolved_lognormal import ConvolvedLognormal
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.result import Result


class Fake(SimpleNamespace):
    """Attributes as they are given, printed as such."""


class Comparison(Fake, Result):
    """Looks as a comparison does."""

    @property
    def adequate(self) -> bool:
        return not self.unexplained


class Diagnosis(Fake, Result):
    """Looks as a diagnosis does."""


class Refinement(Fake, Result):
    """Looks as a refinement does."""


class Fit(Fake, Result):
    """Looks as a fit does."""


SHAPE = (64, 64)
POINTS = tuple(OperatingPoint(t, 0.05, 1.0) for t in (25.0, 65.0, 105.0))


def captures(name: str = "folder/<sensor> & co", cfa: Any = None) -> CaptureSet:
    """Three temperatures, four frames of noise each."""

    def frame(point: OperatingPoint, number: int) -> Frame:
        def load(window: Any) -> np.ndarray:
            rng = np.random.default_rng([number, int(point.temperature_c or 0)])
            y = np.rint(rng.normal(64, 3, SHAPE)).astype(np.uint16)
            return y if window is None else y[window.slices]

        return Frame(f"frame {number}", point, load)

    made = tuple(Setting(p, tuple(frame(p, n) for n in range(4))) for p in POINTS)
    return CaptureSet(name, Sensor(SHAPE, bits=12, cfa=cfa), made, notes=("a note with <b>",))


def statistics(noise: float = 3.0, plane: str = "") -> Statistics:
    """Statistics of Gaussian frames, made with NumPy; every curve that the figures draw."""
    settings = []
    for n, point in enumerate(POINTS):
        rng = np.random.default_rng(n)
        y = np.rint(rng.normal(64 + 10 * n, noise, SHAPE))
        codes, counts = np.unique(y, return_counts=True)
        f = np.arange(1, 40) / 80
        values = {
            "mean": Value(float(y.mean()), 0.05),
            "median": Value(float(np.median(y)), 0.05),
            "temporal_noise": Value(noise * (n + 1), 0.01),
            "pattern_noise": Value(noise / 2, 0.02),
            "hot_count_8": Value(float(n), 1.0),
            "pattern_psd_0.08_0.16": Value(noise**2, 0.05),
            "column_outliers": Value(0.0, 1.0),
            "pattern_corr_10": Value(0.01 * n, 0.01),
            "drift": Value(0.02, 0.2),
            "lattice": Value(1.0, 0.05),
            "shading_0_1": Value(0.1, 0.05),
            "temporal_kurtosis": Value(float("nan"), 0.1),
        }
        curves = {
            "histogram_codes": codes,
            "histogram_counts": counts,
            "exceedance_k": np.geomspace(1, 30, 12),
            "exceedance_n": np.geomspace(1000, 0.5, 12).round(),
            "frame_means": rng.normal(64, 0.05, 4),
            "block_means": rng.normal(0, 0.2, (8, 8)),
            "column_mean": rng.normal(0, 0.4, 64),
            "row_mean": rng.normal(0, 0.4, 64),
            "column_spectrum_f": np.arange(1, 33) / 64,
            "row_spectrum_f": np.arange(1, 33) / 64,
        }
        for part in ("pattern", "temporal"):
            curves |= {
                f"{part}_radial_f": f,
                f"{part}_radial_s": noise**2 * rng.gamma(20, 1 / 20, len(f)),
                f"{part}_radial_full_s": noise**2 * rng.gamma(20, 1 / 20, len(f)),
                f"{part}_column_spectrum": noise**2 * rng.gamma(1, 1, 32),
                f"{part}_row_spectrum": noise**2 * rng.gamma(1, 1, 32),
                f"{part}_psd2d": rng.normal(0, 0.3, (32, 17)),
            }
        missing = {"hot_halo": "Fewer than 10 isolated hot pixels."}
        settings.append(SettingStatistics(point, plane, 4, SHAPE, values, curves, missing))
    trends = {
        "pedestal": Value(60.0, 0.1),
        "activation_energy_ev": Value(0.65, 0.02),
        "doubling_step_c": Value(6.1, 0.2),
    }
    return Statistics(
        "folder", Sensor(SHAPE, bits=12), tuple(settings), trends, captures=captures()
    )


def rows(measured: Statistics, simulated: Statistics) -> list[dict[str, Any]]:
    """Rows with the contract's keys."""
    made = []
    for m, s in zip(measured.settings, simulated.settings, strict=True):
        for name, value in m.values.items():
            other = s.values[name].value
            made.append(
                {
                    "name": name,
                    "family": "spectrum" if "psd" in name else "level",
                    **vars(m.point),
                    "plane": m.plane,
                    "unit": "DN^2" if "psd" in name else "DN",
                    "scale": "linear",
                    "measured": value.value,
                    "simulated": other,
                    "floor": 0.1,
                    "discrepancy": (value.value - other) / 0.1,
                    "relative": None,
                }
            )
    return made


def model() -> NoiseModel:
    """The paper's model."""
    return NoiseModel((ConvolvedLognormal(),), 64.0)


def comparison() -> Comparison:
    """A comparison with a hostile sentence among its failures."""
    measured, simulated, gaussian = statistics(3.0), statistics(2.5), statistics(4.0)
    return Comparison(
        captures=captures(),
        error=6.5,
        baselines={"gaussian": 80.0, "paper": 7.5},
        families={"level": 9.0, "spectrum": 1.1, "tails": float("nan")},
        failures=[f"failure {n} <script>alert(1)</script>" for n in range(8)],
        unexplained=["pattern_q0.001"],
        statistics=rows(measured, simulated),
        measured=measured,
        simulated=simulated,
        gaussian=gaussian,
        model=model(),
        level=None,
        coverage=None,
    )


def diagnosis(verdict: str = "missing") -> Diagnosis:
    """Two candidates."""
    candidates = [
        SimpleNamespace(
            effect=name, error_after=after, explained=0.9, confidence=sure,
            confused_with=rivals, evidence=["striped power 38 times the model's"], leaves=[],
        )
        for name, after, sure, rivals in (
            ("column_fpn", 1.1, 0.97, ["column_gain"]), ("column_gain", 3.0, 0.02, []),
        )
    ]  # fmt: skip
    return Diagnosis(
        captures=captures(),
        error=6.5,
        verdict=verdict,
        candidates=candidates if verdict != "adequate" else [],
        ordinary=[],
        unexplained=["pattern_q0.001"] if verdict != "adequate" else [],
        detection_limits={"row_fpn": "row_fpn below 0.02 DN would not be seen"},
        next_capture=["eight more frames at 45 C"],
        finished=True,
        screened=[],
        model=model(),
        law="",
        direct=[],
        level=None,
        coverage=None,
    )


def refinement(**more: object) -> Refinement:
    """Something added, something taken out again."""
    steps = [
        SimpleNamespace(
            added=a, error=e, confidence=c, evidence=["stripes"] if c else [], confused_with=r,
            supported=True, model=None,
        )
        for a, e, c, r in (
            (None, 6.5, None, []), ("row_fpn", 4.0, 0.6, ["row_noise"]),
            ("column_fpn", 1.1, 0.97, []), ("-row_fpn", 1.05, None, []),
        )
    ]  # fmt: skip
    return Refinement(
        captures=captures(),
        steps=steps,
        effects=["convolved_lognormal", "column_fpn"],
        verdict="adequate",
        unexplained=[],
        finished=True,
        timed_out=False,
        parameters=fit().parameters,
        model=model(),
        diagnosis=diagnosis("adequate"),
        problem=None,
        state=None,
        undetermined=[],
        direct=[],
        level=None,
        coverage=None,
        **{"by_hand": False, "classification": None, **more},
    )


def addition() -> Refinement:
    """An effect that the user named."""
    made = refinement(by_hand=True)
    made.steps = [made.steps[0], made.steps[2]]
    return made


def classification() -> Classification:
    """Told at one operating point of three."""
    cells = [
        Cell(p, "mean", "mean frame", auc, auc - 0.08, auc + 0.08, 0.51, auc > 0.7)
        for p, auc in zip(POINTS, (0.5, 0.55, 0.76), strict=True)
    ]
    told = ["upper tail of the mean frame", "excess kurtosis of the mean frame"]
    patches = np.random.default_rng(3).standard_normal((2, 6, 16, 16))
    shown = Told(POINTS[2], "mean frame", *patches)
    together = [Cell(None, "mean", "mean frame", 0.6, 0.51, 0.69, 0.5)]
    return Classification(captures(), model(), cells, together, told, shown)


def detection(filtered: bool = True) -> Detection:
    """One flagged finding, one not."""
    findings = (
        Finding("rank", "dpc", 105.0, 1e-9, 0.2, filtered, "frame", "why"),
        Finding("memory", "temporal_denoise", None, float("nan"), 0.0, False),
    )
    if not filtered:
        return Detection(captures(), False, "none", 0.9, findings=findings)
    celsius = np.array([25.0, 65.0, 105.0])
    series = SuppressionSeries(
        celsius,
        np.log([1.0, 0.8, 0.4]),
        np.full(3, 0.02),
        0.9,
        np.log([1.0, 0.9, 0.8]),
        0.01,
        99.0,
        9.0,
    )
    return Detection(
        captures(), True, "dpc", 0.99999, FilterEstimate("dynamic", threshold_dn=8.0),
        ("denoise",), findings,
        ("The vertical arm is gone.",), ("denoise or crosstalk",),
        (TailBound(105.0, 8.0, 10.0, 2000.0, 3000.0),), {}, series,
    )  # fmt: skip


def fit() -> Fit:
    """Two parameters, one without an error."""
    parameters = [
        Parameter("convolved_lognormal.mu", 1.234, 0.012, "ln DN"),
        Parameter("pedestal", 64.0, float("nan"), "DN"),
    ]
    return Fit(
        captures=captures(),
        model=model(),
        parameters=parameters,
        correlations=np.array([[1.0, np.nan], [np.nan, 1.0]]),
        undetermined=["mu and pedestal cannot be told apart"],
        direct=[],
    )
