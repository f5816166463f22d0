"""A user's own effect that fails is told in one line that names the file and the effect."""

import numpy as np
import pytest

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import catalogue
from dnanalyze.model.simulate import simulate

OWN = """
from dataclasses import dataclass
import numpy as np
from dnanalyze import Effect
from dnanalyze.model.effect import Stage, parameter


@dataclass(frozen=True)
class Mine(Effect):
    name = "mine"
    stage = Stage.LINE_READ
    sigma: float = parameter(1.0, "DN", 0.0, 10.0, "amplitude")

    def apply(self, signal, site):
        {apply}

    @classmethod
    def guess(cls, clues):
        {guess}
"""


def own(tmp_path, apply="return signal", guess="return []"):
    (tmp_path / "own.py").write_text(OWN.format(apply=apply, guess=guess))
    return catalogue((tmp_path / "own.py",))["mine"]


def frame(kind):
    made = simulate(NoiseModel((kind(),), 64.0), (16, 20), [(OperatingPoint(25.0), 1)])
    return next(made.frames()).read()


@pytest.mark.parametrize(
    ("code", "pattern"),
    [
        ("raise ValueError('no\\nway')", r"raises ValueError \(no way\)$"),
        ("raise SystemExit(0)", r"raises SystemExit \(0\)$"),
        ("import sys; sys.exit('bye')", r"raises SystemExit \(bye\)$"),
        ("def f(): f()\nf()", "raises RecursionError"),
        ("def (", "raises SyntaxError"),
    ],
)
def test_a_file_that_raises_when_it_is_read(tmp_path, code, pattern):
    (tmp_path / "own.py").write_text(code)
    with pytest.raises(InputError, match=r"^--effects .*own\.py: " + pattern):
        catalogue((tmp_path / "own.py",))


@pytest.mark.parametrize(
    ("apply", "pattern"),
    [
        ("raise KeyError('x')", r"raises KeyError \('x'\)$"),
        ("raise SystemExit(1)", r"raises SystemExit \(1\)$"),
        ("return None", "returns NoneType; return the signal"),
        ("return signal[:3]", r"returns shape \(3, 20\); return the signal's, \(16, 20\)"),
        ("return signal * np.nan", "returns pixels that are NaN or infinite"),
        ("return signal + 1j", "returns complex64 pixels"),
    ],
)
def test_an_effect_that_fails_when_it_is_applied(tmp_path, apply, pattern):
    with pytest.raises(InputError, match=r"^--effects .*own\.py: mine\.apply: " + pattern):
        frame(own(tmp_path, apply))


def test_an_effect_that_fails_at_its_first_guess(tmp_path):
    with pytest.raises(InputError, match=r"mine\.guess: raises ZeroDivisionError"):
        own(tmp_path, guess="1 / 0").guess(None)


def test_an_effect_that_works_is_left_as_it_is(tmp_path):
    kind = own(tmp_path, "return signal + np.float32(self.sigma)")
    assert np.all(frame(kind) == 65.0)
    assert kind.guess(None) == []


@pytest.mark.parametrize(
    ("old", "new", "pattern"),
    [
        ("Stage.LINE_READ", "'late'", "stage 'late' is none of"),
        ('parameter(1.0, "DN", 0.0, 10.0, "amplitude")', "1.0", r"mine\.sigma: declare it with"),
    ],
)
def test_a_class_that_cannot_be_an_effect(tmp_path, old, new, pattern):
    text = OWN.format(apply="return signal", guess="return []").replace(old, new)
    (tmp_path / "own.py").write_text(text)
    with pytest.raises(InputError, match=pattern):
        catalogue((tmp_path / "own.py",))
