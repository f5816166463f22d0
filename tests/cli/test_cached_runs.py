"""Commands that follow one another on the same captures."""

from dnanalyze_cli.main import main

import dnanalyze.comparator.compare  # noqa: F401  (before other tests put fakes in its place)
from dnanalyze.loaders.recording import FrameReader


def test_compare_after_analyze_reads_no_frame_of_the_captures(tmp_path, monkeypatch, capsys):
    model = tmp_path / "m.yaml"
    model.write_text(
        "schema: dnanalyze/model/1\npedestal: 64\neffects: [read_noise, quantization]\n"
    )
    folder = str(tmp_path / "darks")
    drawn = ("--shape", "64x96", "--temperatures", "25,45", "--frames", "3", "-q")
    assert main(["simulate", folder, "--model", str(model), *drawn]) == 0
    assert main(["analyze", folder, "-q"]) == 0

    read = FrameReader.__call__

    def refuse(reader, window=None):
        if window is None or window.shape[0] > 8:  # the strips that loading looks at are narrower
            raise AssertionError("a frame was read")
        return read(reader, window)

    monkeypatch.setattr(FrameReader, "__call__", refuse)
    assert main(["compare", folder, "--model", str(model), "-q"]) == 0
    assert main(["compare", folder, "--model", str(model), "-q", "--no-cache"]) == 3
    assert "a frame was read" in capsys.readouterr().err
