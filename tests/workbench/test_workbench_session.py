import json
import shutil
import subprocess
import sys
import time

import numpy as np
import pytest

import dnanalyze
from dnanalyze.comparator.compare import compare
from dnanalyze.errors import InputError
from dnanalyze.model.noise_model import model_from_plain
from dnanalyze.report.words import add_headline
from dnanalyze.workbench.session import WorkbenchSession
from dnanalyze.workbench.source import CaptureSource

RUN = "from dnanalyze_cli.main import run; run()"


@pytest.fixture
def session(folder, fitted):
    made = WorkbenchSession(CaptureSource(folder), fitted)
    made.prepare()
    assert made.settle()
    yield made
    made.close()


def set_value(session, name, value):
    """As the page does when a slider rests."""
    session.adopt(session.with_value(name, value), f"set {name}")


def until(holds):
    end = time.monotonic() + 300.0
    while not holds():
        assert time.monotonic() < end
        time.sleep(0.02)


def test_what_could_not_be_opened_is_tried_again_and_an_opening_is_not_cancelled(
    folder, fitted, tmp_path
):
    own = shutil.copytree(folder, tmp_path / "sensor")
    made = WorkbenchSession(CaptureSource(own), fitted)
    frame = sorted(own.rglob("*.tif"))[-1]
    whole = frame.read_bytes()
    frame.write_bytes(b"no image")
    made.begin()
    until(lambda: made.message and not made._begun)
    assert frame.name in made.message
    frame.write_bytes(whole)
    made.begin()
    until(lambda: made.worker.job)
    made.cancel()
    until(lambda: made.problem is not None)
    made.begin()
    assert made.worker.job is None  # once is enough
    made.close()


@pytest.mark.long
def test_without_a_model_the_wang_2025_model_is_fitted(folder, fitted):
    made = WorkbenchSession(CaptureSource(folder))
    made.prepare()
    assert made.worker.job.over.wait(120)
    assert made.settle()
    assert made.present.model == fitted
    assert made.present.error == made.baseline.error
    made.close()


@pytest.mark.long
def test_the_error_is_that_of_compare(session, folder):
    session.add("row_noise").over.wait(300)
    assert session.settle()
    own = compare(dnanalyze.load(str(folder)), session.present.model).error
    assert session.present.error == pytest.approx(own, rel=1e-6)


@pytest.mark.slow  # .ci/run runs it
def test_the_error_is_that_of_compare_and_of_the_copied_commands(
    session, folder, tmp_path, monkeypatch
):
    session.diagnose().over.wait(300)
    names = [c["effect"] for c in session.diagnosis["candidates"]]
    assert names[0] == "column_fpn"
    session.add("column_fpn").over.wait(300)
    assert session.settle()
    errors = [node.error for node in session.history.path()]
    assert errors[-1] < errors[0] / 2
    own = compare(dnanalyze.load(str(folder)), session.present.model).error
    assert session.present.error == pytest.approx(own, rel=1e-6)

    script = session.commands().replace("dnanalyze ", f'{sys.executable} -c "{RUN}" ')
    (tmp_path / "script.sh").write_text(script.rstrip() + " --json out.json\n")
    subprocess.run(["sh", "script.sh"], cwd=tmp_path, check=True, capture_output=True)
    again = json.loads((tmp_path / "out.json").read_text())["error"]
    assert again == pytest.approx(own, rel=1e-6)

    copied: dict = {}
    monkeypatch.chdir(tmp_path)
    exec(session.python().replace("print(", "error = ("), copied)
    assert copied["error"] == pytest.approx(own, rel=1e-6)


def test_a_fit_that_is_no_closer_is_not_taken_and_a_closer_one_is(session, fitted):
    base = session.present
    far = session.with_value("convolved_lognormal.delta[1]", 0.9)
    fit = "fit", "--replicates", "0"
    session._grow(base, "fit", far.to_plain(), fit)
    until(lambda: "model was kept" in session.message)
    worse = session.history.nodes[1]
    assert session.present.number == 0
    assert worse.before < worse.error
    session.go(1)  # the user may look at it all the same
    assert session.present.number == 1
    session._grow(session.present, "fit", fitted.to_plain(), fit)
    assert session.settle()
    assert session.present.model == fitted


def test_the_errors_before_and_after_a_fit_are_by_one_yardstick(session):
    far = session.with_value("convolved_lognormal.delta[1]", 0.9)
    session.adopt(far, "set delta")
    assert session.settle()
    before = session.present
    session.fit().over.wait(300)
    assert session.settle()
    after = session.present
    assert after.parent == before.number
    assert after.before > after.error
    assert after.before != before.error


def test_a_preview_is_near_the_full_error_and_says_so(session):
    name = "convolved_lognormal.delta[1]"
    value = next(s.value for s in session.sliders() if s.parameter.name == name)
    model = session.with_value(name, 1.5 * value)
    quick = session.preview(model)
    assert quick.preview
    session.adopt(model, "set delta")
    assert quick.error == pytest.approx(session.present.error, rel=0.35)


def test_a_preview_of_the_present_model_is_its_error(session):
    assert session.preview(session.present.model).error == pytest.approx(session.present.error)


def test_a_slider_s_error_is_told_before_its_step_in_the_history(session):
    told = []
    session.listeners.append(told.append)
    set_value(session, "convolved_lognormal.delta[1]", 1.1)
    assert told.index("evaluation") < told.index("history")


def test_an_error_is_stated_at_once_and_is_exact_by_the_model_s_own_yardstick(session, folder):
    """At once by the model before's: that of the same differences until its own is known."""
    told = []
    before = session.evaluation
    session.listeners.append(lambda what: told.append((what, session.present.exact)))
    set_value(session, "convolved_lognormal.delta[1]", 1.0)
    assert not session.present.exact
    assert session.evaluation.problem is before.problem
    assert np.isfinite(session.present.error)
    assert session.settle()
    assert ("yardstick", True) in told
    own = compare(dnanalyze.load(str(folder)), session.present.model).error
    assert session.present.error == pytest.approx(own, rel=1e-6)


def test_moves_of_several_sliders_in_a_row_are_one_node(session):
    first = session.present.number
    set_value(session, "pedestal", 80.0)
    set_value(session, "convolved_lognormal.delta[1]", 1.0)
    set_value(session, "pedestal", 81.0)
    assert session.present.action == "set pedestal, convolved_lognormal.delta[1]"
    assert session.present.parent == first
    session.undo()
    assert session.present.number == first


def test_a_model_that_is_left_gives_its_place_to_the_next_yardstick(session):
    set_value(session, "pedestal", 80.0)
    set_value(session, "pedestal", 70.0)
    assert session.settle()
    assert session.present.model.pedestal == 70.0
    session.undo()
    assert session.settle()


def test_a_fit_under_way_shows_its_drafts_and_cancel_takes_them_back(session, monkeypatch):
    full = session.evaluation
    told = []
    session.listeners.append(told.append)
    session._drafted(session.present, session.with_value("pedestal", 64.5))
    assert session.draft.model.pedestal == 64.5
    assert session.draft.preview
    assert session.evaluation is full
    session.cancel()
    assert session.draft is None
    assert told[:2] == ["draft", "evaluation"]


def test_undo_branch_and_names_keep_everything(session):
    first = session.present.number
    set_value(session, "pedestal", 80.0)
    session.undo()
    assert session.present.number == first
    set_value(session, "pedestal", 70.0)
    session.name(session.present.number, "low pedestal")
    assert [n.model.pedestal for n in session.history.nodes][-2:] == [80.0, 70.0]
    assert session.present.title == "low pedestal"
    assert session.present.parent == first


def test_an_effect_is_taken_out_and_restored_with_its_numbers(session):
    model = model_from_plain(
        session.present.model.to_plain() | {"effects": [
            *session.present.model.to_plain()["effects"], {"read_noise": {"sigma": 2.5}}]},
        "model",
    )  # fmt: skip
    session.adopt(model, "with read noise")
    session.remove("read_noise")
    assert session.removed == ["read_noise"]
    session.restore("read_noise")
    assert session.present.model.get("read_noise").sigma == 2.5


@pytest.mark.long
def test_pinned_parameters_keep_their_values_in_a_fit(session):
    value = session.present.model.pedestal
    set_value(session, "pedestal", value + 0.5)
    session.pin("pedestal", True)
    session.fit().over.wait(120)
    assert session.present.model.pedestal == value + 0.5
    assert "--frozen pedestal" in session.commands()


@pytest.mark.long
def test_a_running_task_is_cancelled_within_a_second_and_the_next_one_runs(session):
    job = session.refine()
    time.sleep(0.5)
    with pytest.raises(InputError, match="refine is under way; cancel it first"):
        session.diagnose()
    begun = time.monotonic()
    session.cancel()
    assert time.monotonic() - begun < 1.0
    assert job.over.wait(60)
    assert session.fit().over.wait(120)
    assert session.message != "internal error"


@pytest.mark.long
def test_an_addition_says_what_the_command_says_of_it(session, folder, fitted):
    session.add("row_noise").over.wait(300)
    found = dnanalyze.add(dnanalyze.load(str(folder)), "row_noise", fitted)
    assert session.answers[session.present.number]["headline"] == add_headline(found)


def test_a_message_that_fades_is_taken_back(session):
    session.tell("stays")
    session.fade()
    assert session.message == "stays"
    session.tell("fades", 0.0)
    session.fade()
    assert session.message == ""


@pytest.mark.slow  # .ci/run runs it
def test_candidates_are_told_as_they_are_found_and_the_limits_give_way(session):
    """A task that is begun while detection limits are computed ends them, not the process."""
    told = []
    session.listeners.append(
        lambda what: told.append(session.diagnosis) if what == "diagnosis" else None
    )
    job = session.diagnose()
    while not job.background:
        assert not job.over.wait(0.01)
    assert any(not found["finished"] for found in told)
    assert told[-1]["finished"]
    assert not told[-1]["detection_limits"]
    process = session.worker._process.pid
    session.add("column_fpn").over.wait(300)
    assert session.worker._process.pid == process
    assert session.present.action == "add column_fpn"


@pytest.mark.long
def test_a_worker_that_dies_is_a_message_and_nothing_is_lost(session):
    nodes = session.history.nodes
    job = session.refine()
    time.sleep(0.5)
    session.worker._process.kill()
    assert job.over.wait(60)
    assert "ended unexpectedly" in session.message
    assert session.history.nodes[: len(nodes)] == nodes
    session.fit().over.wait(120)
    assert session.present.action == "fit"


def test_what_is_wrong_is_told_in_one_line(session):
    with pytest.raises(InputError, match="no parameter 'nothing' in the model; valid: pedestal"):
        session.with_value("nothing", 1.0)
    with pytest.raises(InputError, match="it is already in the model"):
        session.add("convolved_lognormal")
    with pytest.raises(InputError, match="no effect 'rts' in the model"):
        session.remove("rts")


def test_an_effect_that_raises_leaves_the_session_as_it_was(folder, fitted, tmp_path):
    own = tmp_path / "own.py"
    own.write_text(
        "from dataclasses import dataclass\n"
        "from dnanalyze import Effect, Stage, parameter\n"
        "@dataclass(frozen=True)\n"
        "class Broken(Effect):\n"
        "    name = 'broken'\n"
        "    stage = Stage.LINE_READ\n"
        "    size: float = parameter(1.0, 'DN', 0.0, 9.0, 'raises above 2')\n"
        "    def apply(self, signal, site):\n"
        "        if self.size > 2:\n"
        "            raise ValueError('above 2')\n"
        "        return signal\n"
    )
    made = WorkbenchSession(CaptureSource(folder, effects=(own,)), fitted)
    made.prepare()
    made.restore("broken")
    before = made.present
    with pytest.raises(ValueError, match="above 2"):
        made.preview(made.with_value("broken.size", 3.0))
    assert made.present == before
    assert np.isfinite(made.preview(made.with_value("broken.size", 1.5)).error)
    made.close()
