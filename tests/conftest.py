"""Shared by all tests: where the sample captures lie, when they are there."""

from pathlib import Path

import pytest

CAPTURES = Path(__file__).resolve().parents[2] / "shared" / "captures"


@pytest.fixture(scope="session")
def captures_root() -> Path:
    """Folder of the sample captures; skips where it is absent."""
    if not CAPTURES.is_dir():
        pytest.skip("the sample captures are not on this machine")
    return CAPTURES
