"""One session a folder, whatever pages show it."""

from __future__ import annotations

import asyncio
import shutil
from contextlib import closing
from multiprocessing.connection import wait

import pytest

from dnanalyze.errors import InputError
from dnanalyze.workbench.server import Sessions, named, unless_closed
from dnanalyze.workbench.source import CaptureSource
from dnanalyze.workbench.worker import Task


@pytest.fixture
def sources(folder, tmp_path):
    shutil.copytree(folder, tmp_path / "second")
    return [CaptureSource(folder), CaptureSource(tmp_path / "second")]


def test_pages_of_a_folder_share_its_session_and_folders_do_not(sources, fitted):
    sessions = Sessions(sources, fitted, sources[0].captures())
    first, second = sessions.get("0")[1], sessions.get("1")[1]
    assert sessions.get("0")[1] is sessions.get("")[1] is first
    assert second is not first
    assert second.source is sources[1]
    sessions.close()


def test_only_the_folders_of_the_command_line_are_shown(sources, fitted):
    sessions = Sessions(sources, fitted, sources[0].captures())
    for asked in ("2", "-1", "/etc", "one"):
        assert sessions.get(asked)[0] == 0
    sessions.close()


def test_a_folder_that_cannot_be_read_is_an_error_of_its_page_alone(sources, fitted, tmp_path):
    (tmp_path / "empty").mkdir()
    given = [sources[0], CaptureSource(tmp_path / "empty")]
    sessions = Sessions(given, fitted, given[0].captures())
    with pytest.raises(InputError):
        sessions.get("1")
    assert sessions.get("0")[0] == 0
    sessions.close()


def test_folders_of_one_name_are_told_apart_by_their_paths(tmp_path):
    given = [CaptureSource(tmp_path / p) for p in ("a/dark", "b/dark", "c")]
    assert [named(s, given) for s in given[:2]] == [str(s.folder) for s in given[:2]]
    assert named(given[2], given) == "c"


def test_a_worker_without_a_task_ends_and_the_last_page_ends_it_at_once(
    folder, fitted, monkeypatch
):
    from dnanalyze.workbench import jobs
    from dnanalyze.workbench.session import WorkbenchSession

    def begun() -> int:
        job = session.worker.start(Task("open", fitted.to_plain()), lambda _: None, failed.append)
        process = session.worker._process
        assert job.over.wait(300)
        return process.sentinel

    # not join() or is_alive(): of two threads that ask for one exit status, one is told "alive"
    session, failed = WorkbenchSession(CaptureSource(folder), fitted), []
    monkeypatch.setattr(jobs, "IDLE_S", 0.2)
    assert wait([begun()], 60)
    monkeypatch.setattr(jobs, "IDLE_S", 600.0)
    sentinel = begun()
    session.left()
    assert wait([sentinel], 60)
    assert failed == []
    session.close()


def test_news_for_a_closed_page_is_no_error_and_anything_else_is_one(caplog):
    websocket = pytest.importorskip("tornado.websocket")
    with closing(asyncio.new_event_loop()) as loop:
        loop.set_exception_handler(unless_closed)
        loop.call_exception_handler(
            {"message": "of a closed page", "exception": websocket.WebSocketClosedError()}
        )
        loop.call_exception_handler({"message": "of the server", "exception": ValueError()})
    assert [record.getMessage() for record in caplog.records] == ["of the server"]
