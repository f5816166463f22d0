"""What is imported when: `import dnanalyze` and `--help` pay for nothing that they do not use."""

import subprocess
import sys

import pytest

HEAVY = ("numpy", "scipy", "matplotlib", "pandas", "numba", "astropy", "skimage", "h5py", "rawpy")


def loaded(code):
    done = subprocess.run(
        [sys.executable, "-c", f"{code}\nimport sys; print(*sys.modules, file=sys.stderr)"],
        capture_output=True, text=True, check=True, timeout=120,
    )  # fmt: skip
    return set(done.stderr.split())


@pytest.mark.parametrize(
    "code",
    ["import dnanalyze", "from dnanalyze_cli.main import main; main(['--help'])"],
)
def test_heavy_packages_stay_out(code):
    assert loaded(code).isdisjoint(HEAVY)


def test_every_public_name_is_there():
    import dnanalyze

    for name in dnanalyze.__all__:
        assert getattr(dnanalyze, name) is not None
    assert set(dir(dnanalyze)) == set(dnanalyze.__all__)
    with pytest.raises(AttributeError, match="nothing"):
        _ = dnanalyze.nothing
