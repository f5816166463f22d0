"""What is missing in a model, and in one that has nothing of what every sensor has."""

from dataclasses import replace

import numpy as np
import pytest

from dnanalyze.demo import draw_sensor, generate
from dnanalyze.diagnosis.adequacy import Adequacy, farthest
from dnanalyze.diagnosis.diagnose import beside_everyday, diagnose, judge
from dnanalyze.diagnosis.leftover import Leftover
from dnanalyze.diagnosis.refine import refine
from dnanalyze.diagnosis.residual import Residual
from dnanalyze.diagnosis.trial import judged
from dnanalyze.fitting.design import design
from dnanalyze.fitting.fit import paper_start
from dnanalyze.fitting.knobs import knobs_of
from dnanalyze.fitting.least_squares import minimise, start
from dnanalyze.fitting.predictor import bench
from dnanalyze.model.registry import BASE, EVERYDAY, built_in

FEW = (BASE, *EVERYDAY, "row_fpn", "row_noise", "column_fpn")
KNOWN = {name: effect for name, effect in built_in().items() if name in FEW}
SENSOR = draw_sensor(np.random.default_rng(11))


def of(hidden):
    captures = generate(SENSOR, hidden, (128, 128), frames=4, seed=3)
    return captures, bench(design(captures))


@pytest.fixture(scope="module")
def rows():
    return of({"row_fpn": {"level": "strong"}})


@pytest.fixture(scope="module")
def found(rows):
    captures, held = rows
    return diagnose(captures, known=KNOWN, held=held)


def test_an_effect_is_found_beside_what_every_sensor_has(rows, found):
    captures, held = rows
    assert found.verdict == "missing"
    assert found.ordinary == list(EVERYDAY)
    assert [c.effect for c in found.candidates[:5]] == ["row_fpn", *EVERYDAY]
    first, *every = found.candidates[:5]
    assert first.confidence > 0.99
    assert first.error_after < every[-1].error_after < found.error
    assert all(c.confidence > 0.99 for c in every)
    before = [found.error, *(c.error_after for c in every)]
    for c, was in zip(every, before, strict=False):  # each beside those before it
        share = (was - c.error_after) / (found.error - 1.0)
        assert c.explained == pytest.approx(min(1.0, max(0.0, share)))
    assert set(EVERYDAY) < set(found.model.names)
    # the model with what every sensor has is asked the same question, and nothing of that is new
    again = diagnose(captures, found.model, known=KNOWN, held=held)
    assert again.ordinary == []
    assert again.candidates[0].effect == "row_fpn"
    assert not {c.effect for c in again.candidates} & set(EVERYDAY)
    assert again.error == pytest.approx(every[-1].error_after, rel=0.1)


def test_what_every_sensor_has_is_judged_beside_what_is_missing(rows, found):
    """A filter hides the noise: without it these four may explain nothing."""
    _, held = rows
    full = start(held, found.model, knobs_of(found.model))
    asked = start(held, model := paper_start(held), knobs_of(model))
    nothing = judged(held, full, "row_fpn", asked)
    for verdict, sure in (("missing", False), ("adequate", True)):
        told = replace(found, verdict=verdict, candidates=found.candidates[:1], trials=[nothing])
        every = beside_everyday(held, asked, [("quantization", full)], told)
        last = next(c for c in every.candidates if c.effect == "quantization")
        assert (last.confidence > 0.99) == sure


def test_the_leader_is_told_at_its_end_and_with_what_it_leaves(rows, found, monkeypatch):
    _, held = rows
    state = start(held, found.model, knobs_of(found.model))
    leader = found.trials[0]
    ended = Leftover(replace(leader, error=0.5), ["temporal_v_first"])
    asked = []
    monkeypatch.setattr(
        "dnanalyze.diagnosis.diagnose.leftover", lambda *a: asked.append(a[-1]) or ended
    )
    told = judge("rows", held, state, [leader], leader, KNOWN, in_full=False)
    assert asked == [{}]  # nothing is followed up
    assert (told.verdict, told.unexplained) == ("missing", ["temporal_v_first"])
    assert told.candidates[0].error_after == 0.5
    assert told.candidates[0].confidence < 0.6
    assert "temporal_v_first" in told.candidates[0].evidence[-1]


def test_of_an_ordinary_sensor_only_what_every_sensor_has_is_missing():
    captures, held = of({})
    told = []
    found = diagnose(captures, known=KNOWN, held=held, tell=told.append)
    assert found.verdict == "missing"
    assert [c.effect for c in found.candidates] == list(EVERYDAY)
    assert "baseline effects" in told
    full = diagnose(captures, found.model, known=KNOWN, held=held)
    assert full.verdict == "adequate"
    assert full.error == pytest.approx(found.candidates[-1].error_after, rel=0.1)


def test_an_error_that_no_single_statistic_makes_is_told_by_the_farthest(rows, monkeypatch):
    _, held = rows
    state = minimise(held, start(held, model := paper_start(held), knobs_of(model)), 1)
    monkeypatch.setattr("dnanalyze.diagnosis.adequacy.adequacy", lambda *_: Adequacy(False, []))
    found = judge("rows", held, state, [], None, {}, in_full=False)
    assert found.verdict == "unexplained"
    assert found.unexplained == farthest(held, state)
    assert len(found.unexplained) == 3


def test_what_the_data_do_not_support_is_no_sure_name_and_of_what_is_adequate_none(
    rows, found, monkeypatch
):
    """One story: the list says what the verdict says."""
    _, held = rows
    state = start(held, found.model, knobs_of(found.model))
    leader = found.trials[0]
    idle = replace(leader, effect="row_noise", state=state)  # as sure, and puts nothing right
    left = ["temporal_noise", *found.candidates[0].leaves]
    puts_right = [n for n in ("row_mean_sd", "pattern_rows_0.1_0.3") if n in held.train.names]
    monkeypatch.setattr("dnanalyze.diagnosis.diagnose.unexplained", lambda *_: [*left, *puts_right])
    told = judge("rows", held, state, [leader, idle], None, KNOWN, in_full=False)
    assert told.verdict == "unexplained"
    sure = [c.confidence for c in told.candidates]
    assert sure == sorted(sure, reverse=True)
    assert max(sure) <= 0.5
    named = {c.effect: c for c in told.candidates}
    assert set(puts_right) & set(named["row_fpn"].leaves) == set()
    assert named["row_noise"].leaves == told.unexplained
    assert all(c.evidence for c in told.candidates)
    monkeypatch.setattr("dnanalyze.diagnosis.diagnose.unexplained", lambda *_: [])
    told = judge("rows", held, state, [leader, idle], None, KNOWN, in_full=False)
    assert (told.verdict, told.candidates) == ("adequate", [])


def test_what_is_excluded_is_not_put_in(rows):
    captures, held = rows
    found = diagnose(captures, known=KNOWN, held=held, exclude=["quantization", "row_fpn"])
    named = {c.effect for c in found.candidates}
    assert not named & {"quantization", "row_fpn"}
    assert found.ordinary == [n for n in EVERYDAY if n != "quantization"]
    assert "quantization" not in found.model.names


def test_where_all_of_it_is_excluded_the_model_is_asked_as_it_is(rows):
    captures, held = rows
    found = diagnose(captures, known=KNOWN, held=held, exclude=EVERYDAY)
    assert found.ordinary == []
    assert found.model.names == [BASE]
    assert not {c.effect for c in found.candidates} & set(EVERYDAY)
    kept = refine(captures, known=KNOWN, held=held, exclude=EVERYDAY, most_effects=0)
    assert kept.effects == [BASE]


def test_a_model_with_some_of_it_is_asked_as_it_is(rows, found):
    captures, held = rows
    some = found.model.without("quantization")
    partly = diagnose(captures, some, known=KNOWN, held=held)
    assert partly.ordinary == []
    assert partly.candidates[0].effect in ("row_fpn", "quantization")


def nearly_all_alike(captures):
    """The captures, the coldest frames of one code but for two pixels in the lower half."""
    first, *others = captures.settings

    def alike(window):
        pixels = np.full(captures.sensor.shape, 100, np.uint16)
        pixels[100, 50], pixels[110, 7] = 130, 101
        return pixels if window is None else np.ascontiguousarray(pixels[window.slices])

    frames = tuple(replace(frame, load=alike) for frame in first.frames)
    return replace(captures, settings=(replace(first, frames=frames), *others))


def test_a_setting_whose_frames_are_nearly_all_alike_is_diagnosed_too():
    """A filter may leave that little; warnings are errors here."""
    held = bench(design(nearly_all_alike(generate(SENSOR, {}, (128, 128), frames=4, seed=3))))
    model = paper_start(held)
    clues = Residual(held, start(held, model, knobs_of(model)))
    for effect in built_in().values():
        assert all(isinstance(guess, effect) for guess in effect.guess(clues))
    found = diagnose(held.plan.captures, model, known=KNOWN, held=held)
    assert found.verdict in ("missing", "unexplained")
    assert np.isfinite(found.error)
