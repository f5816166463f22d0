"""Model, targets and combination files that cannot be: one line that names the file."""

import os

import pytest

from dnanalyze.checking.targets import load_targets
from dnanalyze.errors import InputError
from dnanalyze.model.export.table import read_table
from dnanalyze.model.hdr_file import load_combination
from dnanalyze.model.noise_model import load_model

READERS = (load_model, load_targets, load_combination)
HEAD = "schema: dnanalyze/model/1\n"
LOGNORMAL = "effects: [{convolved_lognormal: {mu: {value: 2, at_c: %s, ea_ev: %s}}}]\n"


@pytest.mark.parametrize("read", READERS)
@pytest.mark.parametrize(
    ("text", "pattern"),
    [
        ("[" * 40 + "]" * 40, "nested more than 32 deep"),
        ("[" * 100_000, "nested more than 32 deep"),
        ("a: &x [1]\nb: *x\n", "aliases"),
        ("seed: 2001-99-99\n", "is not YAML: month must be in"),
        ("a: \x07\n", "is not YAML"),
    ],
)
def test_yaml_that_cannot_be(tmp_path, read, text, pattern):
    (tmp_path / "a.yaml").write_text(text)
    with pytest.raises(InputError, match=rf"a\.yaml: .*{pattern}"):
        read(tmp_path / "a.yaml")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no named pipes on this system")
@pytest.mark.parametrize("read", [*READERS, read_table])
def test_a_pipe_is_never_waited_for(tmp_path, read):
    os.mkfifo(tmp_path / "a.yaml")
    with pytest.raises(InputError, match="is a pipe, socket or device"):
        read(tmp_path / "a.yaml")


@pytest.mark.parametrize(
    ("text", "pattern"),
    [
        ("seed: .inf\neffects: []\n", "seed 'inf' is no whole number"),
        ("seed: -1\neffects: []\n", "seed '-1' is no whole number"),
        ("pedestal: 1" + "0" * 400 + "\neffects: []\n", "pedestal: .* is no law"),
        ("reference: {temperature_c: abc}\neffects: []\n", "reference: temperature_c 'abc' is no"),
        ("reference: {temperature_c: -273.15}\neffects: []\n", "temperature_c -273.15 is out of"),
        ("reference: {gain: 0}\neffects: []\n", "reference: gain 0 is out of range"),
        ("reference: {channel: 1}\neffects: []\n", "channel '1' is no text; quote it"),
        (LOGNORMAL % (-273.15, 0.6), "at_c: temperature_c -273.15 is out of range"),
        (LOGNORMAL % (25, ".nan"), "is no law"),
        (LOGNORMAL % (25, 1000), "is no law"),
        ("effects: [{flicker_noise: {overhead: abc}}]\n", "'abc' is no whole number of 0 to"),
    ],
)
def test_models_that_cannot_be(tmp_path, text, pattern):
    (tmp_path / "m.yaml").write_text(HEAD + text)
    with pytest.raises(InputError, match=rf"m\.yaml: .*{pattern}"):
        load_model(tmp_path / "m.yaml")


@pytest.mark.parametrize("text", ["effect,parameter\rx,y\n", "effect\n\r\n" + "x" * 200_000])
def test_tables_that_are_no_csv(tmp_path, text):
    (tmp_path / "a.csv").write_text(text, newline="")
    with pytest.raises(InputError, match=r"a\.csv: (is no CSV table|not a table of parameters)"):
        read_table(tmp_path / "a.csv")


def test_targets_at_what_cannot_be(tmp_path):
    (tmp_path / "t.yaml").write_text("targets: [{statistic: mean, max: 1, at: {gain: 0}}]\n")
    with pytest.raises(InputError, match=r"t\.yaml: target 1 \(mean\): at: gain 0 is out of range"):
        load_targets(tmp_path / "t.yaml")


@pytest.mark.parametrize(
    ("old", "new", "pattern"),
    [
        ("black: 64,", "black: ~,", "channel hcg: black 'None'; valid: a number of"),
        ("sensitivity: 1.0", "sensitivity: 0", "sensitivity '0'; valid"),
        ("channel: hcg", "channel: 1", "channel '1' is no text"),
        ("bits: 12", "bits: 400", "bits '400'; valid: a number of 1 to 24"),
        ("[0, 64]", "[.nan, 64]", "companding knees must be below 1e[+]12 DN"),
        ("4095]", ".inf]", "companding knees must be below 1e[+]12 DN"),
        ("[0, 64]", "[1" + "0" * 400 + ", 64]", "companding is"),
    ],
)
def test_combinations_that_cannot_be(tmp_path, old, new, pattern):
    text = (
        "channels:\n- {channel: hcg, black: 64, sensitivity: 1.0, knee: 3000}\n"
        "- {channel: lcg, black: 64, sensitivity: 0.1, knee: 3000}\n"
        "companding: [[0, 64], [4000, 4095]]\nbits: 12\n"
    )
    (tmp_path / "h.yaml").write_text(text)
    load_combination(tmp_path / "h.yaml")
    (tmp_path / "h.yaml").write_text(text.replace(old, new, 1))
    with pytest.raises(InputError, match=rf"h\.yaml: .*{pattern}"):
        load_combination(tmp_path / "h.yaml")
