import pytest

from dnanalyze.fitting.simulated import Job


@pytest.fixture
def taken(monkeypatch):
    """Parts of simulations that this process takes."""
    parts, whole = [], Job.statistics

    def counted(self, share, *more):
        parts.extend(share)
        return whole(self, share, *more)

    monkeypatch.setattr(Job, "statistics", counted)
    return parts
