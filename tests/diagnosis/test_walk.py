"""From one addition to the next."""

import numpy as np
import pytest

from dnanalyze.diagnosis import walk as module
from dnanalyze.diagnosis.path import Path, Step
from dnanalyze.diagnosis.trial import error_of
from dnanalyze.diagnosis.walk import Walk


@pytest.mark.parametrize("poor", [True, False])
def test_before_it_gives_up_on_a_poor_model_it_asks_once_more_with_true_derivatives(
    ordinary, known, monkeypatch, poor
):
    asked, real = [], module.trials

    def blind(held, state, *more):
        """Sees nothing at first."""
        asked.append(state)
        return real(held, state, *more) if len(asked) > 1 else []

    monkeypatch.setattr(module, "trials", blind)
    monkeypatch.setattr(module, "POOR", 1.0 if poor else 1e3)
    begun = Path(ordinary.state, (Step(None, error_of(ordinary.bench, ordinary.state)),))
    found = Walk(ordinary.bench, known).to_end(begun)
    assert (found.state.model.get("row_fpn") is not None) == poor
    if poor:
        assert not np.array_equal(asked[0].jacobian, asked[1].jacobian)
    else:
        assert len(asked) == 1


@pytest.mark.parametrize(
    ("evidence", "gain", "forks"), [(800.0, 800.0, 1), (700.0, 700.0, 0), (800.0, -10.0, 0)]
)
def test_a_rival_that_explains_nearly_as_much_and_would_do_is_a_fork(evidence, gain, forks):
    best = module.Trial("a", None, 1000.0, 1000.0, 1.0)
    other = module.Trial("b", None, gain, 2 * evidence - gain, 1.1)
    begun = Path(None, (Step(None, 2.0),))
    found = module._forked(begun, best, [best, other], 2.0)
    assert [f.other.effect for f in found.forks] == ["b"] * forks
    assert all(f.nearness == evidence / 1000.0 and f.before is begun for f in found.forks)
