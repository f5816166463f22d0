from __future__ import annotations

import dnanalyze
from dnanalyze.demo import tiny
from dnanalyze.progress import reporter


def test_each_thing_is_a_step_and_text_says_what():
    seen = []
    tell = reporter(lambda *step: seen.append(step))
    tell("row_fpn")
    tell(object())
    reporter(None)("nobody listens")
    assert seen == [(0, None, "row_fpn"), (1, None, "")]


def test_one_callable_serves_every_function():
    captures, seen = tiny(), []

    def progress(done, total, what=""):
        seen.append((done, total, what))

    dnanalyze.analyze(captures, progress=progress)
    assert seen[-1][:2] == (9, 9)
    dnanalyze.fit(captures, replicates=0, progress=progress)
    assert seen[-1][1] is None
