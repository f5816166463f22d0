"""A model's frames, one at a time: the signal's walk along the chain of effects."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from dnanalyze.loaders.captures import OperatingPoint, Window
from dnanalyze.model.effect import Effect, Site, Stage
from dnanalyze.model.effects.read_noise import ReadNoise
from dnanalyze.model.laws import value_at
from dnanalyze.model.memo import Memo
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.row_bands import band_rows, bands
from dnanalyze.model.streams import Stream

MAPS = 4  # fixed fields that an effect may keep


def _ends_charge(count: int, chain: Sequence[Effect]) -> bool:
    """Whether what follows ``count`` effects is read out, from charge that others may share."""
    if count == len(chain):
        return False
    return chain[count - 1].stage <= Stage.ARRIVAL < chain[count].stage <= Stage.PEDESTAL


@dataclass(frozen=True)
class Simulator:
    """Draws frames of one model.

    Parameters
    ----------
    model : NoiseModel
    shape : tuple of int
        Full frame, (rows, columns).
    memo : Memo
        Fields kept between calls; may be shared by simulators of like models (common random
        numbers make their differences smooth in the parameters).

    Notes
    -----
    ``_maps`` keeps what belongs to a window, ``_shared`` what belongs to the whole field; without
    the latter ``_maps`` keeps both.
    """

    model: NoiseModel
    shape: tuple[int, int]
    memo: Memo = field(default_factory=Memo)
    _maps: Memo = field(default_factory=Memo)
    _shared: Memo | None = None

    def frame(self, point: OperatingPoint, number: int, window: Window | None = None) -> np.ndarray:
        """Pixels of a frame, DN, float32; a pure function of its arguments and the model."""
        window = window or Window.whole(self.shape)
        return self._after(len(self._chain), self._chain, point, number, window)

    @cached_property
    def _chain(self) -> list[Effect]:
        return self.model.chain

    @cached_property
    def _shot(self) -> Effect | None:
        return next((e for e in self.model.effects if e.name == "dark_shot_noise"), None)

    @cached_property
    def _shared_pixels(self) -> tuple[int, int]:
        """Rows and columns of the pixels that share an amplifier."""
        read = next((e for e in self.model.effects if isinstance(e, ReadNoise)), None)
        return (1, 1) if read is None else read.shared_pixels

    @cached_property
    def _roots(self) -> dict[str, Stream]:
        """Random numbers of every effect, by its name."""
        root = Stream.from_seed(self.model.seed)
        return {effect.name: root.child(effect.name) for effect in self.model.effects}

    def _after(
        self, count: int, chain: list[Effect], point: OperatingPoint, number: int, window: Window
    ) -> np.ndarray:
        """Signal of ``window`` after the first ``count`` effects."""
        if count == 0:
            level = (
                np.float32(self._pedestal(point))
                if not chain or chain[0].stage > Stage.PEDESTAL
                else 0
            )
            return self._level(window, float(level))
        memo = self.memo.charge
        if memo is None or not _ends_charge(count, chain):
            return self._applied(count, chain, point, number, window)
        at = self.shape, self.model.seed, self.model.reference_of(point.channel), point, number
        key = (*at, window, self._shared_pixels, *chain[:count])
        made = memo.get(key, lambda: self._applied(count, chain, point, number, window))
        return np.array(made)  # what follows may write into it

    def _applied(
        self, count: int, chain: list[Effect], point: OperatingPoint, number: int, window: Window
    ) -> np.ndarray:
        """The last of ``count`` effects, put on the signal of those before it."""
        effect = chain[count - 1]
        grown = window.grown(effect.margin(), self.shape)
        if effect.memory:
            first = -effect.warm_up(point)
            signal = np.stack(
                [
                    self._remembered(count - 1, chain, point, max(first, n), grown)
                    for n in range(number - effect.memory, number + 1)
                ]
            )
        else:
            signal = self._after(count - 1, chain, point, number, grown)

        def calibration(n: int, warmer: float = 0.0) -> np.ndarray:
            there = self.model.reference_of(point.channel).warmer(warmer)
            return self._whole(count - 1, chain, there, n)

        signal = effect.apply(signal, self._site(effect, point, number, grown, calibration))
        if grown != window:
            signal = signal[window.within(grown)]
        last_before = count == len(chain) or chain[count].stage > Stage.PEDESTAL
        if effect.stage < Stage.PEDESTAL and last_before:
            signal = signal + np.float32(self._pedestal(point))
        return signal

    def _whole(
        self, count: int, chain: list[Effect], point: OperatingPoint, number: int
    ) -> np.ndarray:
        """`_after` of the whole field, band by band: of a large one none of its fields is kept."""
        found, own = np.empty(self.shape, np.float32), replace(self, memo=Memo(0), _maps=Memo(0))
        for band in bands(Window.whole(self.shape), band_rows(self.model, self.shape[1])):
            found[band.slices] = own._after(count, chain, point, number, band)
        return found

    def _level(self, window: Window, level: float) -> np.ndarray:
        """The signal before the first effect."""
        return np.full(window.shape, level, np.float32)

    def _remembered(
        self, count: int, chain: list[Effect], point: OperatingPoint, number: int, window: Window
    ) -> np.ndarray:
        """`_after`, kept for the frames that follow: they look back at it."""
        return self._maps.get(
            ("past", count, point, number, window),
            lambda: self._after(count, chain, point, number, window),
        )

    def _pedestal(self, point: OperatingPoint) -> float:
        return value_at(self.model.pedestal, point)

    def _site(
        self,
        effect: Effect,
        point: OperatingPoint,
        number: int,
        window: Window,
        calibration: Callable[[int, float], np.ndarray],
    ) -> Site:
        root, reference = self._roots[effect.name], self.model.reference_of(point.channel)
        frame_stream = root.child("moment", repr(point), number)

        def draw(stream: Stream, kind: str) -> np.ndarray:
            make = getattr(stream, kind)
            return self.memo.get((stream.key, kind, window), lambda: make(window, self.shape[1]))

        def keep(name: str, make: Callable[[], Any]) -> Any:
            return self._maps.get((effect.name, point, window, name), make)

        def share(name: str, make: Callable[[], Any]) -> Any:
            shared = self._maps if self._shared is None else self._shared
            return shared.once((effect.name, point, name), make)

        return Site(
            self.shape, window, point, reference, number, root.child("silicon"), frame_stream, keep,
            draw, calibration, share, self._dn_per_e(point, reference), self._shared_pixels,
        )  # fmt: skip

    def _dn_per_e(self, point: OperatingPoint, reference: OperatingPoint) -> float | None:
        """Conversion gain by which the model counts its charge."""
        if self._shot is None:
            return None
        return self._shot.value("dn_per_e", point) * point.gain_over(reference)


def room(model: NoiseModel, shape: tuple[int, int]) -> int:
    """Bytes for the fixed fields of a setting: to forget one would mean to make it every frame."""
    return MAPS * 4 * shape[0] * shape[1] * max(1, len(model.effects))
