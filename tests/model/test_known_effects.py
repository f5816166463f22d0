"""Which effects a model may be given: the catalogue, a user's files, or those named."""

import re
from pathlib import Path

import pytest

from dnanalyze.errors import InputError
from dnanalyze.model.effects.read_noise import ReadNoise
from dnanalyze.model.registry import built_in, find, known_effects

OWN = Path(__file__).resolve().parents[2] / "sample_configs" / "own_effect.py"


def test_a_users_file_stands_beside_the_catalogue():
    assert known_effects() == built_in()
    more = known_effects([str(OWN)])
    assert set(more) > set(built_in())


def test_a_mapping_stands_for_all_effects():
    only = {"read_noise": ReadNoise}
    assert known_effects(only) == only


@pytest.mark.parametrize(
    ("wrong", "meant"),
    [("glow", "did you mean amp_glow? "), ("colum_fpn", "did you mean column_fpn? "), ("zzz", "")],
)
def test_a_wrong_name_is_refused_with_those_like_it(wrong, meant):
    with pytest.raises(
        InputError, match=f"unknown effect '{wrong}'; {re.escape(meant)}valid names"
    ):
        find(wrong, built_in())
