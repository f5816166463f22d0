"""Completing a model on a sensor of the independent generator, step by step."""

import math

import pytest

from dnanalyze.comparator.error import TOLERABLE
from dnanalyze.diagnosis.refine import add_on, refine_on
from dnanalyze.diagnosis.search_path import SearchLimits
from dnanalyze.diagnosis.selection import OUTSIDE
from dnanalyze.errors import InputError
from dnanalyze.model.registry import BASE, BASELINE, WANG

pytestmark = pytest.mark.long


def test_it_names_what_is_hidden_and_goes_on_from_any_model_it_kept(striped, known):
    kept, told = [], []
    whole = refine_on(striped, known=known, on_result=kept.append, on_step=told.append)
    assert whole.effects == [BASE, *sorted(BASELINE, key=whole.effects.index), "row_fpn"]
    assert [s.added for s in told] == [None, *(n for n in BASELINE if n not in WANG), "row_fpn"]
    assert kept[-1].model == whole.model
    assert set(kept[0].model.names) == WANG
    assert set(kept[1].effects) == {BASE, *BASELINE}
    assert not any(k.finished for k in kept)
    assert [s.added for s in kept[-1].steps] == [s.added for s in whole.steps]
    assert all(math.isnan(p.se) for p in kept[-1].parameters)
    rest = refine_on(striped, kept[1].model, known=known, classifier=False)
    assert [s.added for s in rest.steps] == [None, "row_fpn"]
    assert set(rest.effects) == set(whole.effects)
    assert rest.steps[-1].error < TOLERABLE < rest.steps[0].error
    by_hand = add_on(striped, "row_fpn", kept[1].model, known=known)
    for done in (whole, by_hand):  # and say why, how sure that is, and how strong it is
        assert any("with row_fpn" in words for words in done.steps[-1].evidence)
        assert 0.94 < done.steps[-1].confidence <= 1.0 - OUTSIDE
        assert done.unexplained == []
        assert done.steps[-1].error == pytest.approx(done.diagnosis.error)  # of the final model
        (strength,) = (p for p in done.parameters if p.name == "row_fpn.sigma")
        assert 0.0 < strength.se < 0.5 * strength.value
    assert all(s.evidence for s in whole.steps[1:])
    with pytest.raises(InputError, match="row_fpn: it is already in the model"):
        add_on(striped, "row_fpn", whole.model, known=known)
    idle = add_on(striped, "row_noise", whole.model, known=known)
    assert not idle.steps[-1].supported
    assert idle.steps[-1].confidence < 0.5


def test_it_stops_where_it_is_told(striped, known, ordinary):
    first = ordinary
    assert first.verdict == "missing"
    assert "row_fpn" not in first.effects
    without = refine_on(
        striped,
        first.model,
        known=known,
        exclude=["row_fpn"],
        limits=SearchLimits(until_error=0.01),
        classifier=False,
    )
    assert "row_fpn" not in without.effects
    limits = SearchLimits(until_error=1e3)
    enough = refine_on(striped, first.model, known=known, limits=limits, classifier=False)
    assert len(enough.steps) == 1
