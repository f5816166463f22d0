"""A Dask cluster gives what one process gives, whatever dies or is interrupted."""

import os
import signal

import numpy as np
import pytest
from dark_frames import dark_frames

from dnanalyze.analyzers.analyze import analyze
from dnanalyze.analyzers.streaming import distributed as dist
from dnanalyze.errors import InputError
from dnanalyze.loaders import load
from dnanalyze.loaders.captures import OperatingPoint, Sensor, Window
from dnanalyze.loaders.recording import FrameReader
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import built_in
from dnanalyze.model.simulate import simulate

pytestmark = pytest.mark.filterwarnings("default")  # Dask's own

SHAPE = (48, 64)


@pytest.fixture(scope="module")
def dask():
    return pytest.importorskip("distributed", reason="Dask is not installed")


@pytest.fixture(scope="module")
def cluster(dask):
    with dask.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0") as made:
        yield made


@pytest.fixture
def folder(tmp_path):
    for t in (25, 45):
        root = tmp_path / "captures" / f"{t}C"
        root.mkdir(parents=True)
        for n, frame in enumerate(dark_frames(t, 11, SHAPE, drift=0.3)):
            np.save(root / f"dark_{n:02d}.npy", frame)
    return tmp_path / "captures"


def assert_like(ours, theirs):
    for a, b in zip(ours.settings, theirs.settings, strict=True):
        assert a.values.keys() == b.values.keys()
        assert a.missing == b.missing
        for name, value in a.values.items():
            other = b.values[name]
            assert value.value == pytest.approx(other.value, rel=1e-12, abs=1e-12 * other.se), name
            assert value.se == pytest.approx(other.se, rel=1e-9), name


@pytest.fixture
def in_this_process(monkeypatch):
    """A stand-in for the cluster, whose runs are done at once: what is read can be counted."""
    from contextlib import contextmanager

    class Done:
        def __init__(self, value):
            self.result = lambda: value

    class Client:
        def nthreads(self):
            return {"one": 1}

        def submit(self, call, *args, pure):
            return Done(call(*args))

    @contextmanager
    def cluster(scheduler):
        yield Client()

    monkeypatch.setattr(dist, "cluster", cluster)
    monkeypatch.setattr(dist, "RUN", 3)
    monkeypatch.setattr(dist, "AHEAD", 1)


@pytest.mark.long
def test_workers_give_what_one_process_gives(folder, cluster):
    assert_like(analyze(load(folder), scheduler=cluster.scheduler_address), analyze(load(folder)))


def test_merged_runs_are_one_pass_to_1e_12(folder, in_this_process):
    assert_like(analyze(load(folder), scheduler="any"), analyze(load(folder)))


def test_planes_and_windows_too(folder, in_this_process):
    from dataclasses import replace

    mosaic = load(folder)
    mosaic = replace(mosaic, sensor=replace(mosaic.sensor, cfa=(("R", "G"), ("G", "B"))))
    window = Window(4, 44, 2, 60)
    ours = analyze(mosaic, window=window, scheduler="any")
    assert_like(ours, analyze(mosaic, window=window))


def test_the_same_pixels_from_a_worker(cluster, dask):
    known = built_in()
    effects = tuple(known[n]() for n in ("convolved_lognormal", "rts", "crosstalk", "quantization"))
    model = NoiseModel(effects, 100.0)
    made = simulate(model, SHAPE, [(OperatingPoint(45.0, 0.1), 3)], sensor=Sensor(SHAPE))
    frame = made.settings[0].frames[2]
    frame.read()
    with dask.Client(cluster) as client:
        there = client.submit(lambda: frame.read(), pure=False).result()
    np.testing.assert_array_equal(there, frame.read())


def test_a_worker_that_dies_loses_nothing(folder, cluster, dask):
    killed = []
    with dask.Client(cluster) as client:
        pids = list(client.run(os.getpid).values())

    def kill(done, total):
        if not killed:
            killed.append(pids[0])
            os.kill(pids[0], getattr(signal, "SIGKILL", signal.SIGTERM))

    ours = analyze(load(folder), scheduler=cluster.scheduler_address, progress=kill)
    assert killed
    assert_like(ours, analyze(load(folder)))


def test_an_interrupted_run_goes_on_and_reads_no_merged_frame_again(
    folder, tmp_path, in_this_process, monkeypatch
):
    expected = analyze(load(folder))
    captures = load(folder).cached(str(tmp_path / "store"))
    read = []
    own = FrameReader.__call__

    def counted(self, window=None):
        read.append(self.name)
        return own(self, window)

    monkeypatch.setattr(FrameReader, "__call__", counted)

    def stop(done, total):
        if done >= 17:  # in the second setting
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        analyze(captures, scheduler="any", progress=stop)
    before, read[:] = set(read), []
    assert len(before) < 22
    seen = []
    ours = analyze(captures, scheduler="any", progress=lambda done, total: seen.append(done))
    assert_like(ours, expected)
    assert seen[0] == 11
    assert not before & set(read)
    assert len(before | set(read)) == 22
    assert not list((tmp_path / "store").glob("*.run"))


def test_no_scheduler_is_one_line(folder, dask, monkeypatch):
    monkeypatch.setattr(dist, "TIMEOUT", 0.5)
    with pytest.raises(InputError, match="no Dask scheduler answers there"):
        analyze(load(folder), scheduler="tcp://127.0.0.1:1")


def test_workers_open_the_url_where_the_copy_is_not(cluster, folder):
    """The copy that the client made is away, as it is for a worker on another machine."""
    import shutil

    pytest.importorskip("fsspec", reason="fsspec is not installed")
    here = analyze(load(folder))
    captures = load(f"file://{folder}")
    copies = {p for f in captures.frames() for p in [f.load.read.path]}
    (root,) = {p.parents[1] for p in copies}
    assert not root.is_relative_to(folder)
    shutil.rmtree(root.parent)
    assert_like(analyze(captures, scheduler=cluster.scheduler_address), here)
    shutil.rmtree(folder / "25C")
    shutil.rmtree(root.parent)
    with pytest.raises(InputError, match=r"file://.*cannot be fetched .*check address and access"):
        next(captures.frames()).read()
