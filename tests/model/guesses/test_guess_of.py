"""Where an effect's first guesses are made."""

from dataclasses import dataclass
from typing import ClassVar

from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.row_fpn import RowFpn
from dnanalyze.model.effects.row_noise import RowNoise
from dnanalyze.model.guesses import guess_of, white_lines
from dnanalyze.model.registry import built_in


def test_every_effect_of_the_catalogue_has_first_guesses():
    assert [name for name, effect in built_in().items() if guess_of(effect) is None] == []


def test_an_effect_from_elsewhere_is_guessed_as_it_is_declared():
    assert guess_of(Effect) is None
    assert Effect.guess(None) == [Effect()]


def test_an_effect_derived_from_one_of_the_catalogue_is_guessed_like_it():
    @dataclass(frozen=True)
    class Own(RowFpn):
        name: ClassVar[str] = "own"

    assert guess_of(Own) is white_lines.guess


def test_a_guess_of_its_own_comes_first():
    @dataclass(frozen=True)
    class Own(RowNoise):
        @classmethod
        def guess(cls, clues):
            return [cls(2.0)]

    assert Own.guess(None) == [Own(2.0)]
