from __future__ import annotations

import pytest

pytest.importorskip("panel", reason="the extra workbench is not installed")


def _candidate(effect: str, *evidence: str, confused_with: tuple[str, ...] = ()) -> dict:
    return {"effect": effect, "evidence": list(evidence), "confused_with": list(confused_with)}


def test_evidence_that_candidates_share_is_stated_of_the_first():
    from dnanalyze.workbench.page.missing import evidence

    dark = "the variance is 0.6 times the model's; with {} the difference falls to 1 sigma"
    shown = [
        _candidate("column_fpn", "striped", confused_with=("column_gain",)),
        _candidate("read_noise", dark.format("read_noise")),
        _candidate("pixel_fpn", dark.format("pixel_fpn")),
        _candidate("rts", "it leaves the row means, which row_noise in addition would correct"),
    ]
    assert [text.replace("\N{NO-BREAK SPACE}", " ") for text in evidence(shown)] == [
        "striped · confounded with column gain",
        dark.format("read noise"),
        "evidence as for read noise",
        "it leaves the row means, which row noise in addition would correct",
    ]
