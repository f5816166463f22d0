"""Bad input is one line on stderr and exit 2; nothing is half-written."""

import os
import signal
import subprocess
import sys

import pytest
import report_fakes as fakes
from dnanalyze_cli.main import main

from dnanalyze.loaders import write_captures
from dnanalyze.model.noise_model import dump_model

SIGNALLED = pytest.mark.skipif(
    not hasattr(signal, "pthread_kill"), reason="a process that is ended is not told on this system"
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return write_captures(fakes.captures(), tmp_path_factory.mktemp("captures") / "sensor")


@pytest.fixture
def model(tmp_path):
    path = tmp_path / "m.yaml"
    path.write_text(dump_model(fakes.model()))
    return path


def refused(arguments, capsys):
    """Exit code 2 and one line on stderr; gives the line."""
    assert main([str(a) for a in arguments]) == 2
    shown = capsys.readouterr()
    assert shown.err.startswith("dnanalyze: ")
    assert shown.err.count("\n") == 1
    return shown.err


def test_folders_that_are_none(tmp_path, capsys):
    assert "nowhere" in refused(["inspect", tmp_path / "nowhere"], capsys)
    assert str(tmp_path) in refused(["analyze", tmp_path], capsys)


def test_usage_errors(folder, capsys):
    assert "frobnicate" in refused(["frobnicate"], capsys)
    assert "--wrong" in refused(["inspect", folder, "--wrong"], capsys)
    refused(["inspect"], capsys)
    assert "--tolerance-c" in refused(["inspect", folder, "--tolerance-c", "-1"], capsys)


def test_unknown_effects_name_the_valid_ones(folder, capsys):
    assert "read_noise" in refused(["effects", "nothing"], capsys)
    assert "read_noise" in refused(["add", folder, "nothing"], capsys)
    assert "read_noise" in refused(["refine", folder, "--exclude", "nothing"], capsys)


def test_model_files_that_are_none(folder, tmp_path, capsys):
    broken = tmp_path / "broken.yaml"
    broken.write_text("effects: [nothing]")
    assert str(broken) in refused(["compare", folder, "--model", broken], capsys)
    assert "m2.yaml" in refused(["compare", folder, "--model", tmp_path / "m2.yaml"], capsys)


def test_outputs_are_refused_before_any_work(folder, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("dnanalyze.loaders.load", pytest.fail)
    inside = folder / "out.json"
    assert "never changed" in refused(["inspect", folder, "--json", inside], capsys)
    assert "is a folder" in refused(["analyze", folder, "--csv", tmp_path], capsys)
    there = tmp_path / "no" / "out.json"
    assert "does not exist" in refused(["analyze", folder, "--json", there], capsys)
    both = ["--json", tmp_path / "x", "--csv", tmp_path / "x"]
    assert "two outputs" in refused(["analyze", folder, *both], capsys)


def test_what_simulate_cannot_do(model, folder, tmp_path, capsys):
    out = tmp_path / "frames"
    base = ["simulate", out, "--model", model, "-q"]
    assert "--shape" in refused([*base, "--shape", "32"], capsys)
    assert "--temperatures" in refused([*base, "--temperatures", "warm"], capsys)
    both = ["--like", folder, "--exposure", "1"]
    assert "--like" in refused([*base, *both], capsys)
    assert "valid" in refused([*base, "--shape", "16x16", "--format", "bmp"], capsys)
    assert not out.exists()
    out.mkdir()
    (out / "mine").write_text("")
    assert "exists already" in refused([*base, "--shape", "16x16"], capsys)
    assert os.listdir(out) == ["mine"]


def test_an_interrupt_leaves_nothing_and_exits_130(model, tmp_path, capsys, monkeypatch):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("dnanalyze.loaders.writers.write_captures", interrupted)
    before = sorted(os.listdir(tmp_path))
    assert main(["simulate", str(tmp_path / "frames"), "--model", str(model), "-q"]) == 130
    assert "interrupted" in capsys.readouterr().err
    assert sorted(os.listdir(tmp_path)) == before


def test_reading_leaves_the_captures_as_they_were(folder, tmp_path):
    def state():
        return sorted((p, p.stat().st_mtime_ns, p.stat().st_size) for p in folder.rglob("*"))

    before = state()
    assert main(["analyze", str(folder), "--json", str(tmp_path / "a.json"), "-q"]) == 0
    assert state() == before


def command(*arguments, **options):
    code = "from dnanalyze_cli.main import run; run()"
    return subprocess.run(
        [sys.executable, "-c", code, *map(str, arguments)],
        capture_output=True, text=True, timeout=120, **options,
    )  # fmt: skip


def test_the_command_itself(tmp_path):
    done = command("inspect", tmp_path / "nowhere")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("dnanalyze: ")
    assert "Traceback" not in done.stderr
    done = command("--version")
    assert done.returncode == 0
    assert done.stdout.startswith("dnanalyze ")


def test_help_names_every_command():
    done = command("--help")
    assert done.returncode == 0
    for name in ("inspect", "analyze", "fit", "simulate", "compare", "diagnose", "add", "refine",
                 "detect", "effects", "demo"):  # fmt: skip
        assert name in done.stdout
    assert command().stdout == done.stdout


@SIGNALLED
def test_a_terminated_run_leaves_no_temporary(model, tmp_path):
    out = tmp_path / "frames"
    code = "from dnanalyze_cli.main import run; run()"
    big = ["--shape", "2048x2048", "--frames", "400"]
    process = subprocess.Popen(
        [sys.executable, "-c", code, "simulate", str(out), "--model", str(model), *big],
        stderr=subprocess.PIPE,
    )
    for _ in range(600):
        if any(p.name.startswith(".frames.") for p in tmp_path.iterdir()):
            break
        with pytest.raises(subprocess.TimeoutExpired):
            process.wait(0.1)
    process.send_signal(signal.SIGTERM)
    process.communicate(timeout=60)
    assert process.returncode == 143
    assert os.listdir(tmp_path) == ["m.yaml"]


@SIGNALLED
def test_a_termination_that_python_ignores_is_sent_again():
    code = """
import os, signal, time, weakref
from dnanalyze_cli.termination import end_on_sigterm

class Thing: pass

end_on_sigterm()
thing = Thing()
seen = weakref.ref(thing, lambda _: os.kill(os.getpid(), signal.SIGTERM))
del thing
print("went on", flush=True)
time.sleep(60)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=50)
    assert (done.returncode, done.stdout, done.stderr) == (143, "went on\n", "")


def failing_with(error):
    def fail(*_, **__):
        raise error

    return fail


@pytest.mark.parametrize(
    "error", [KeyError("mu"), RuntimeError("several\nlines of\nit"), SystemExit(1), OSError(5, "x")]
)
def test_an_internal_error_is_3_and_one_line_that_says_how_to_report_it(
    folder, monkeypatch, capsys, error
):
    monkeypatch.setattr("dnanalyze.loaders.inspect", failing_with(error))
    monkeypatch.delenv("DNANALYZE_DEBUG", raising=False)
    assert main(["inspect", str(folder), "-q"]) == 3
    shown = capsys.readouterr().err
    assert shown.count("\n") == 1
    assert shown.startswith(f"dnanalyze: internal error: {type(error).__name__}: ")
    assert "test_exit_codes.py:" in shown
    assert "report" in shown
    monkeypatch.setenv("DNANALYZE_DEBUG", "1")
    assert main(["inspect", str(folder), "-q"]) == 3
    assert "Traceback (most recent call last)" in capsys.readouterr().err


def test_out_of_memory_is_one_line(folder, monkeypatch, capsys):
    monkeypatch.setattr("dnanalyze.loaders.inspect", failing_with(MemoryError()))
    assert "out of memory" in refused(["inspect", folder, "-q"], capsys)


@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_a_reader_that_is_gone_is_no_failed_check(unbuffered):
    """As ``dnanalyze effects | head -0``: written at once, or at the end."""
    code = "from dnanalyze_cli.main import run; run()"
    process = subprocess.Popen(
        [sys.executable, "-c", code, "effects"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        env=os.environ | {"PYTHONUNBUFFERED": unbuffered},
    )  # fmt: skip
    process.stdout.close()
    shown = process.stderr.read().decode()
    process.stderr.close()
    assert (process.wait(60), shown) == (141, "")


def test_a_shell_is_told_how_a_word_goes_on(capsys, monkeypatch):
    monkeypatch.setenv("_DNANALYZE_COMPLETE", "complete_bash")
    monkeypatch.setenv("COMP_WORDS", "dnanalyze ref")
    monkeypatch.setenv("COMP_CWORD", "1")
    assert main([]) == 0
    assert capsys.readouterr().out.split() == ["refine"]


def test_an_exit_without_a_shell_that_asks_is_an_internal_error(monkeypatch, capsys):
    """Whatever it is, `check` did not pass."""
    monkeypatch.setattr("dnanalyze.loaders.load", lambda *_, **__: sys.exit(0))
    assert main(["inspect", "."]) == 3
    assert "internal error" in capsys.readouterr().err


def test_the_short_option_helps_as_the_long_one(capsys):
    assert main(["compare", "-h"]) == 0
    short = capsys.readouterr().out
    assert main(["compare", "--help"]) == 0
    assert short == capsys.readouterr().out != ""
