"""A pattern's line in frames made without the package's simulator: read off, held, reported."""

import numpy as np
import pytest

from dnanalyze.analyzers.analyze import analyze
from dnanalyze.diagnosis.refine import add_on
from dnanalyze.fitting.design import design
from dnanalyze.fitting.fit import fit_on, paper_start
from dnanalyze.fitting.measured_parameters import at_measured_parameters, measured_parameters
from dnanalyze.fitting.problem import fit_problem
from dnanalyze.fitting.readings import Readings
from dnanalyze.fitting.residual import Residual
from dnanalyze.fitting.state import start
from dnanalyze.loaders import load
from dnanalyze.model.effects.periodic_pattern import PeriodicPattern

SHAPE = (128, 112)


def frames_in(folder, places, seed, amplitude):
    """Four codes frames a temperature, Gaussian, with sines of random phase at ``places``."""
    rng = np.random.default_rng(seed)
    y, x = np.indices(SHAPE)
    level = 100.0 + 1.5 * rng.normal(size=SHAPE)
    table = ["file,temperature_c,exposure_s"]
    for t, dark in ((25, 2.0), (45, 8.0)):
        for n in range(4):
            frame = level + rng.poisson(dark, SHAPE) + 1.5 * rng.normal(size=SHAPE)
            for (u, v), a in zip(places, amplitude, strict=True):
                frame += a * np.sin(2 * np.pi * (u * x + v * y + rng.random()))
            name = f"t{t}_{n}.npy"
            np.save(folder / name, np.clip(np.rint(frame), 0, 4095).astype(np.uint16))
            table.append(f"{name},{t},0.1")
    (folder / "manifest.csv").write_text("\n".join(table) + "\n")
    return load(folder)


def test_an_added_pattern_stays_at_the_line_that_stands_highest(tmp_path):
    place, weaker = (0.0931, 0.4021), (0.37, 0.21)
    captures = frames_in(tmp_path, [place, weaker], 1, (0.8, 0.5))
    problem = fit_problem(design(captures))
    found = add_on(captures, "periodic_pattern", paper_start(problem), problem=problem).model
    pattern = found.get("periodic_pattern")
    exact = measured_parameters(problem, found)
    for axis, truth in zip("uv", place, strict=True):
        number, sign = exact[f"periodic_pattern.{axis}"], np.sign(pattern.u)
        assert getattr(pattern, axis) == pytest.approx(number.value)
        assert abs(sign * number.value - truth) < 4 * number.se
        assert number.se < 0.05 / min(SHAPE)


def guessed(captures):
    """First guesses beside the model of the first fit."""
    problem = fit_problem(design(captures))
    model = paper_start(problem)
    return PeriodicPattern.guess(Residual(problem, start(problem, model)))


def test_a_guess_has_both_lines_of_the_captures_or_the_stronger(tmp_path):
    """Harmonics 1 and 2 of a band, of .8 and .4 DN, in 1.5 DN of noise."""
    captures = frames_in(tmp_path, [(0.0, 0.2131), (0.0, 0.4262)], 3, (0.8, 0.4))
    several, alone = (g for g in guessed(captures) if g.phase == "random")
    ((u, v, relative),) = several.further
    assert np.abs([several.u, u]).max() < 2e-3
    assert (abs(several.v), abs(v)) == pytest.approx((0.2131, 0.4262), abs=2e-3)
    # medians of four places, each a mean power over 4 random phases: 29 % of the power
    assert relative == pytest.approx(0.5, rel=0.4)
    assert (several.u, several.v) == (alone.u, alone.v)
    assert alone.more == ()


def test_captures_of_one_line_are_guessed_no_other(tmp_path):
    captures = frames_in(tmp_path, [(0.0931, 0.4021)], 4, (0.8,))
    assert [g.more for g in guessed(captures)] == [()] * len(guessed(captures))


def test_lines_off_and_on_an_axis_are_read(tmp_path):
    captures = frames_in(tmp_path, [(0.0931, 0.4021), (0.0, 0.2131)], 5, (0.8, 0.6))
    waves = Readings(analyze(captures)).waves("temporal", 0)
    assert [wave.shared for wave in waves] == ["", "rows"]


def test_a_fit_begins_at_the_measured_line_and_reports_its_error(tmp_path):
    captures = frames_in(tmp_path, [(0.2213, -0.1147)], 2, (0.8,))
    problem = fit_problem(design(captures))
    near = PeriodicPattern(0.5, 0.2213 + 0.6 / SHAPE[1], -0.1147 - 0.6 / SHAPE[0])
    model = paper_start(problem).with_effect(near)
    found = fit_on(captures, model, problem=problem, replicates=0)
    numbers = {p.name: p for p in found.parameters}
    assert found.correlations.shape == (len(numbers),) * 2
    for axis, truth in (("u", 0.2213), ("v", -0.1147)):
        p = numbers[f"periodic_pattern.{axis}"]
        assert abs(p.value - truth) < 4 * p.se
        assert p.unit == "cycles/pixel"
    frozen = ("periodic_pattern.u", "periodic_pattern.v")
    assert at_measured_parameters(problem, model, frozen).get("periodic_pattern") == near


def test_a_line_of_the_sample_captures_is_kept(captures_root):
    """Four lines of nearly the same power repeat every four columns and eight rows."""
    captures = load(captures_root / "real" / "msdp_lines")
    spectra = [np.fft.rfft2(f.read().astype(float)) for f in captures.frames()]
    power = np.sum(np.abs(np.array(spectra) - np.mean(spectra, axis=0)) ** 2, axis=0)
    power[0], power[:, 0] = 0, 0
    rows, columns = captures.sensor.shape
    problem = fit_problem(design(captures))
    model = paper_start(problem).with_effect(PeriodicPattern(u=0.4, v=0.28))  # nothing there
    pattern = at_measured_parameters(problem, model).get("periodic_pattern")
    exact = measured_parameters(problem, model)
    assert (pattern.u, pattern.v) == tuple(exact[f"periodic_pattern.{k}"].value for k in "uv")
    i, k = round(pattern.v * rows), round(pattern.u * columns)
    sign = -1 if k < 0 else 1
    assert power[sign * i, sign * k] > 0.5 * power.max()
    for at, size, axis in ((i, rows, "v"), (k, columns, "u")):
        number = exact[f"periodic_pattern.{axis}"]
        assert abs(number.value - at / size) < 4 * number.se < 0.2 / size
