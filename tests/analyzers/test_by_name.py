"""Statistics, EMVA quantities, parameters and limits by their names."""

from __future__ import annotations

import numpy as np
import pytest

import dnanalyze
from dnanalyze import InputError
from dnanalyze.demo import tiny


@pytest.fixture(scope="module")
def statistics():
    return dnanalyze.analyze(tiny(), system_gain=0.5)


def test_a_statistic_is_a_table_over_operating_points_in_its_unit(statistics):
    table = statistics["temporal_noise"]
    assert table["temperature_c"].tolist() == [25.0, 45.0, 65.0]
    assert (table["unit"] == "DN").all()
    frames = np.stack([f.read() for f in tiny().settings[0].frames]).astype(float)
    assert table["value"][0] == pytest.approx(np.sqrt(frames.var(axis=0, ddof=1).mean()), rel=0.02)
    with pytest.raises(KeyError, match="temporal_noise"):
        statistics["temporal_nois"]


def test_the_given_gain_makes_electrons(statistics):
    table = statistics.emva.to_dataframe().set_index("quantity")
    assert table.loc["system_gain_dn_e", "value"] == 0.5
    in_dn = table.loc["temporal_dark_noise_dn", "value"].iloc[0]
    in_e = table.loc["temporal_dark_noise_e", "value"].iloc[0]
    assert in_e == pytest.approx(
        np.sqrt(in_dn**2 - 1 / 12) / 0.5
    )  # less the quantization, EMVA 1288
    with pytest.raises(InputError, match="above 0"):
        dnanalyze.analyze(tiny(), system_gain=0.0)


def test_parameters_by_position_and_by_name():
    found = dnanalyze.fit(tiny(), replicates=0).parameters
    assert found["pedestal"] is found[0]
    assert found[:1] == (found[0],)
    with pytest.raises(KeyError, match="pedestal"):
        found["pedestl"]
