"""Lists of numbers as they are typed; what no sensor can have is refused in one line."""

from __future__ import annotations

import pytest
from dnanalyze_cli.main import main
from dnanalyze_cli.typed_numbers import celsius, numbers

from dnanalyze.errors import InputError


def test_numbers_are_read():
    assert numbers("--gain", "1, 2.5,.3", "gain") == [1.0, 2.5, 0.3]
    assert numbers("--gain", None, "gain") == []
    assert celsius("--at", "-273,25") == [-273.0, 25.0]


@pytest.mark.parametrize("text", ["", "hot", "25,,3", "25;45", "nan", "1,inf"])
def test_what_is_no_list_of_numbers_is_refused(text):
    with pytest.raises(InputError, match=r"^--at .*not numbers with commas between"):
        celsius("--at", text)


@pytest.mark.parametrize(
    "words",
    [
        ("simulate", "OUT", "--model", "M.yaml", "--temperatures=-300"),
        ("simulate", "OUT", "--model", "M.yaml", "--temperatures=1001"),
        ("simulate", "OUT", "--model", "M.yaml", "--exposure=-1"),
        ("simulate", "OUT", "--model", "M.yaml", "--gain=0"),
        ("simulate", "OUT", "--model", "M.yaml", "--shape=1000000x1000000"),
        ("simulate", "OUT", "--model", "M.yaml", "--shape=1x1"),
        ("simulate", "OUT", "--model", "M.yaml", "--frames=1000000000"),
        ("export", "M.yaml", "--format", "csv", "-o", "M.csv", "--temperatures=-300"),
        ("benchmark", "A", "B", "--at=-300"),
    ],
)
def test_impossible_numbers_are_refused_in_one_line(words, tmp_path, capsys, monkeypatch):
    from dnanalyze.model.noise_model import NoiseModel, dump_model
    from dnanalyze.model.registry import built_in

    (tmp_path / "M.yaml").write_text(dump_model(NoiseModel((built_in()["read_noise"](),), 64.0)))
    monkeypatch.chdir(tmp_path)
    assert main(list(words)) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "valid: " in line
    assert sorted(p.name for p in tmp_path.iterdir()) == ["M.yaml"]


def test_hdr_with_a_model_of_one_channel(tmp_path, capsys):
    import numpy as np

    from dnanalyze.model.noise_model import NoiseModel, dump_model
    from dnanalyze.model.registry import built_in

    np.save(tmp_path / "a.npy", np.random.default_rng(0).integers(60, 70, (16, 20)).astype("u2"))
    (tmp_path / "m.yaml").write_text(dump_model(NoiseModel((built_in()["read_noise"](),), 64.0)))
    (tmp_path / "h.yaml").write_text(
        "channels:\n- {channel: hcg, black: 64, sensitivity: 1.0, knee: 3000}\n"
        "- {channel: lcg, black: 64, sensitivity: 0.1, knee: 3000}\n"
    )
    words = ["hdr", str(tmp_path), "--model", str(tmp_path / "m.yaml")]
    assert main([*words, "--combine", str(tmp_path / "h.yaml")]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "m.yaml: has no parameters by channel" in line
