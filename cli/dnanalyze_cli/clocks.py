"""The time that a phase has taken, and what it will take yet where that can be told."""

from __future__ import annotations

from rich.progress import ProgressColumn, Task
from rich.text import Text

LEAST_S, LEAST_SHARE = 3.0, 0.1  # of a phase, before which no estimate is fair


class Elapsed(ProgressColumn):
    """Time since the phase began, and since the command did where that is longer."""

    def render(self, task: Task) -> Text:
        """Such as ``0:12 (total 1:40)``."""
        now, whole = task.get_time(), task.fields.get("begun")
        phase = task.elapsed or 0.0
        text = clock(phase)
        if whole is not None and now - whole > phase + 1.0:
            text += f" (total {clock(now - whole)})"
        return Text(text)


class Remaining(ProgressColumn):
    """What is left of a phase whose steps are counted, by its mean pace; else nothing."""

    def render(self, task: Task) -> Text:
        """Such as ``about 0:30 left``."""
        left = remaining(task.completed, task.total, task.elapsed)
        return Text("" if left is None else f"about {clock(left)} left")


def remaining(done: float, total: float | None, elapsed: float | None) -> float | None:
    """Seconds left at the mean pace so far; None before there is one.

    Parameters
    ----------
    done, total : float
        Steps; a total of None is not known.
    elapsed : float or None
        Seconds.
    """
    if not total or elapsed is None or elapsed < LEAST_S or done < LEAST_SHARE * total:
        return None
    return max(0.0, elapsed * (total - done) / done)


def clock(seconds: float) -> str:
    """``1:05``, ``1:02:03``."""
    whole = int(seconds)
    minutes, rest = divmod(whole, 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{rest:02d}" if hours else f"{minutes}:{rest:02d}"
