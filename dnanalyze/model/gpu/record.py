"""A frame recorded: the simulator's own walk along the signal chain, with a signal on a tape."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from dnanalyze.loaders.captures import OperatingPoint, Window
from dnanalyze.model.effect import Effect, Site
from dnanalyze.model.gpu.tape import Recorded, Tape, Unrecordable
from dnanalyze.model.simulator import Simulator
from dnanalyze.model.streams import Stream


@dataclass(frozen=True)
class RecordedSite(Site):
    """A site whose fields of this frame are drawn by the kernel."""

    tape: Tape = field(kw_only=True)

    def normal(self, name: str = "") -> Any:
        """Standard normal field of this frame; on the host where its values are asked for."""
        return self._drawn(self.frame_stream.child(name), "normal")

    def uniform(self, name: str = "") -> Any:
        """Uniform field of this frame; on the host where its values are asked for."""
        return self._drawn(self.frame_stream.child(name), "uniform")

    def _drawn(self, stream: Stream, kind: str) -> Recorded:
        step = self.tape.step(kind, self.tape.number(stream.key))
        return Recorded(self.tape, step, lambda: self.field(stream, kind))


@dataclass(frozen=True)
class Recorder(Simulator):
    """Records a whole frame instead of drawing it: effects run their own code on the tape.

    What an effect does may have no step: it and all before it are then drawn on the host, and the
    recording goes on from there.

    Parameters
    ----------
    tape : Tape
        Of this frame.
    on_host : set of int
        How many effects from the first were drawn on the host, as found so far.
    """

    tape: Tape = field(kw_only=True)
    on_host: set[int] = field(kw_only=True)

    def _after(
        self, count: int, chain: list[Effect], point: OperatingPoint, number: int, window: Window
    ) -> Any:
        tape, begun = self.tape, (len(self.tape.steps), len(self.tape.numbers))
        if count not in self.on_host:
            try:
                return super()._after(count, chain, point, number, window)
            except Exception:  # an effect is any code; what is wrong with it shows on the host
                self.on_host.add(count)
                del tape.steps[begun[0] :], tape.numbers[begun[1] :]
        host = Simulator(self.model, self.shape, self.memo, self._maps)
        drawn = host._after(count, chain, point, number, window)
        return Recorded(tape, tape.operand(np.asarray(drawn, np.float32)))

    def _remembered(self, *arguments: Any) -> Any:
        raise Unrecordable("frames before this one")

    def _level(self, window: Window, level: float) -> Any:
        return Recorded(self.tape, self.tape.scalar(level))

    def _site(self, *arguments: Any) -> Site:
        return RecordedSite(**vars(super()._site(*arguments)), tape=self.tape)
