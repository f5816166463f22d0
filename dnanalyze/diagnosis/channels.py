"""Refine each readout channel by itself, and say which effects belong to which channel."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

from dnanalyze.diagnosis.refine import Refinement, refine
from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import CaptureSet, OperatingPoint
from dnanalyze.model.effect import Effect
from dnanalyze.model.hdr import merged
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import BASE, EVERYDAY


@dataclass(frozen=True)
class ChannelRefinement:
    """Every channel's completed model, side by side.

    Parameters
    ----------
    captures : str
    channels : dict
        Channel to its refinement.
    shared : list of str
        Effects beyond the everyday ones that all channels have: of the pixel, or of a readout
        that all share.
    own : dict
        Channel to the effects that it has, but not all channels have.
    findings : list of str
        The same in sentences.
    """

    captures: str
    channels: dict[str, Refinement]
    shared: list[str]
    own: dict[str, list[str]]
    findings: list[str]

    @property
    def model(self) -> NoiseModel:
        """One model of all channels; see `dnanalyze.model.hdr.merged`."""
        found = {
            s[0].temperature_c
            for r in self.channels.values()
            for s in r.bench.plan.settings
            if s[0].temperature_c is not None
        }
        return merged({c: r.model for c, r in self.channels.items()}, sorted(found))


def channels_of(captures: CaptureSet) -> list[str]:
    """The readout channels of a capture set, in order.

    Raises
    ------
    InputError
        Fewer than two.
    """
    names = list(dict.fromkeys(s.point.channel for s in captures.settings))
    found = [n for n in names if n is not None]
    if len(found) < 2:
        there = "one channel" if found else "no channels"
        raise InputError(
            f"{captures.name}: {there}; two or more are needed, by the column 'channel' of "
            "manifest.csv"
        )
    return found


def refine_channels(
    captures: CaptureSet,
    *,
    exclude: Sequence[str] = (),
    known: dict[str, type[Effect]] | None = None,
    tell: Callable[[str], None] = lambda _: None,
) -> ChannelRefinement:
    """Complete a model of each channel and compare what they needed.

    Parameters
    ----------
    captures : CaptureSet
        Operating points that carry a channel.
    exclude : sequence of str
        Effects never to add.
    known : dict, optional
        Effects by name; the built-in catalogue by default.
    tell : callable
        Called with a line of progress.

    Raises
    ------
    InputError
        Fewer than two channels.
    """
    made: dict[str, Refinement] = {}
    for channel in channels_of(captures):
        part = captures.select(partial(_of_channel, channel))
        tell(f"channel {channel}")
        made[channel] = refine(
            part,
            exclude=exclude,
            known=known,
            trying=partial(_trying, tell, channel),
        )
    added = {c: [e for e in r.effects if e not in (BASE, *EVERYDAY)] for c, r in made.items()}
    every = list(dict.fromkeys(e for names in added.values() for e in names))
    shared = [e for e in every if all(e in names for names in added.values())]
    own = {c: [e for e in names if e not in shared] for c, names in added.items()}
    return ChannelRefinement(captures.name, made, shared, own, _findings(shared, own))


def _of_channel(channel: str, point: OperatingPoint) -> bool:
    return point.channel == channel


def _trying(tell: Callable[[str], None], channel: str, effect: str) -> None:
    tell(f"channel {channel}: trying {effect}")


def _findings(shared: Sequence[str], own: dict[str, list[str]]) -> list[str]:
    said = []
    if shared:
        said.append(
            f"in every channel, so of the pixel or of what all readouts share: {', '.join(shared)}"
        )
    for effect in dict.fromkeys(e for names in own.values() for e in names):
        where = [c for c, names in own.items() if effect in names]
        only = f"{where[0]} only" if len(where) == 1 else ", ".join(where)
        said.append(f"{effect}: in {only}, so of that readout")
    return said or ["no channel needs more than what every sensor has"]
