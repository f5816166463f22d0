"""What was made is kept, bounded in bytes: random fields, fixed maps, frames in electrons."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass, field
from threading import Lock
from typing import Any


@dataclass
class Memo:
    """Least recently used arrays, bounded in bytes: fields are pure, forgetting costs only time.

    ``charge``, if any, keeps frames as they are counted in electrons: models that differ only in
    what is read out share them.
    """

    limit_bytes: int = 256 << 20
    charge: Memo | None = None
    _held: OrderedDict[object, Any] = field(default_factory=OrderedDict)
    _bytes: int = 0
    _lock: Any = field(default_factory=Lock)
    _making: dict[object, Any] = field(default_factory=dict)

    def __reduce__(self) -> tuple[type[Memo], tuple[int]]:
        """Another process begins with an empty one."""
        return Memo, (self.limit_bytes,)

    def once(self, key: object, make: Callable[[], Any]) -> Any:
        """As `get`; a second thread waits for the first one's, for what is dear to make."""
        with self._lock:
            turn = self._making.setdefault(key, Lock())
        with turn:
            value = self.get(key, make)
        with self._lock:
            self._making.pop(key, None)
        return value

    def find(self, key: object) -> Any | None:
        """What is kept by this key; None where nothing is."""
        with self._lock:
            value = self._held.get(key)
            if value is not None:
                self._held.move_to_end(key)
            return value

    def get(self, key: object, make: Callable[[], Any]) -> Any:
        """``make()``, or what it gave last time; threads may at worst make a thing twice."""
        value = self.find(key)
        if value is not None:
            return value
        value = make()
        with self._lock:
            if key not in self._held:
                self._held[key] = value
                self._bytes += _size(value)
            while self._bytes > self.limit_bytes and len(self._held) > 1:
                self._bytes -= _size(self._held.popitem(last=False)[1])
        return value


def _size(value: Any) -> int:
    if isinstance(value, tuple):
        return sum(map(_size, value))
    return int(getattr(value, "nbytes", 64))
