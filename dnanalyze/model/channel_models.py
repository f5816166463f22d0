"""One model of all readout channels: what is the pixel's is shared, what is the readout's is not.

A model of one channel has plain numbers; one of several has tables over channels. The silicon
streams carry no channel, so that all channels show the same pixels.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effect import Effect, ParameterInfo, Stage
from dnanalyze.model.laws import ArrheniusLaw, Law, TableLaw, scaled, value_at
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import BASE


def of_pixel(kind: type[Effect]) -> bool:
    """Whether an effect is dark charge, which every channel reads."""
    return kind.stage is Stage.CHARGE


def is_shared(kind: type[Effect], info: ParameterInfo) -> bool:
    """Whether all channels have one value: a property of the charge that no gain multiplies."""
    return of_pixel(kind) and not _is_level(info)


def _is_level(info: ParameterInfo) -> bool:
    """An amount of charge as the readout states it, in DN or its logarithm."""
    return info.unit.startswith("DN") or (info.unit == "ln DN" and info.scale == "linear")


def channels_of(model: NoiseModel) -> list[str]:
    """The channels that a model tells apart, in order."""
    laws = [model.pedestal, *(getattr(e, n) for e in model.effects for n in e.parameters())]
    points = [p for law in laws if isinstance(law, TableLaw) for p in law.points]
    names = dict.fromkeys(p.channel for p in (*points, *model.channel_references))
    return [n for n in names if n is not None]


def require(model: NoiseModel, channels: Sequence[str]) -> None:
    """Refuse frames of channels that a model of several does not know, or of none.

    Raises
    ------
    InputError
        The line gives those that it knows.
    """
    valid = channels_of(model)
    if valid and not channels:
        raise InputError(
            f"the model has parameters by channel ({', '.join(valid)}), and the frames state no "
            "channel; the column 'channel' of manifest.csv states it"
        )
    for name in channels if valid else ():
        if name not in valid:
            raise InputError(f"the model has no channel {name!r}; valid: {', '.join(valid)}")


def channel_model(model: NoiseModel, channel: str) -> NoiseModel:
    """The model of one channel, of those that `merged` put together; its inverse."""
    effects = tuple(
        replace(e, **{n: _own(getattr(e, n), channel) for n in e.parameters()})
        for e in model.effects
    )
    kept = tuple(
        own for e, own in zip(model.effects, effects, strict=True) if own == e or not _absent(own)
    )
    reference = replace(model.reference_of(channel), channel=None)
    return NoiseModel(kept, _own(model.pedestal, channel), reference, model.seed)


def _own(law: Any, channel: str) -> Any:
    """A law, or a word, as one channel has it."""
    if not isinstance(law, TableLaw) or all(p.channel is None for p in law.points):
        return law
    named = any(p.channel == channel for p in law.points)
    rows = [
        (replace(p, channel=None), v)
        for p, v in zip(law.points, law.values, strict=True)
        if p.channel == channel or (not named and p.channel is None)
    ]
    if not rows:  # the table does not know this channel
        return law.at(OperatingPoint(channel=channel))
    if len(rows) == 1 and rows[0][0] == OperatingPoint():
        return rows[0][1]
    return TableLaw(tuple(p for p, _ in rows), tuple(v for _, v in rows))


def _weakest(info: ParameterInfo) -> float:
    return info.lower if info.scale == "log" else min(max(0.0, info.lower), info.upper)


def _absent(effect: Effect) -> bool:
    numbers = [(n, i) for n, i in effect.parameters().items() if i.scale != "choice"]
    return bool(numbers) and all(getattr(effect, n) == _weakest(i) for n, i in numbers)


def merged(models: Mapping[str, NoiseModel], temperatures: Sequence[float] = ()) -> NoiseModel:
    """One model of all channels, from a model each.

    The readout's parameters become tables over channels, at each channel's own reference. What is
    of the pixel is that of the brightest channel, which sees it best: its numbers hold for all,
    its amounts are those of the charge that the others read of it. An effect of the readout
    that a channel lacks stands at its weakest there; where words (a kind) differ, the commonest
    holds.

    Parameters
    ----------
    models : mapping
        Channel to its model.
    temperatures : sequence of float
        C, at which amounts that follow an Arrhenius law are stated.
    """
    bright = max(models, key=lambda c: _level(models[c], models[c].reference))
    best = models[bright]
    kinds = {e.name: type(e) for m in models.values() for e in m.effects}
    effects = []
    for name, kind in kinds.items():
        own = {c: m.get(name) for c, m in models.items()}
        there = best.get(name)
        if of_pixel(kind) and there is not None and name != BASE:
            own = {
                c: e if c == bright or (e is not None and e == there) else _read(there, best, m)
                for (c, e), m in zip(own.items(), models.values(), strict=True)
            }
        effects.append(_merged_effect(kind, own, models, bright, temperatures))
    pedestal = _table([(c, m, m.pedestal) for c, m in models.items()], temperatures)
    home = replace(best.reference, channel=None)
    references = tuple(replace(m.reference, channel=c) for c, m in models.items())
    differ = any(replace(r, channel=None) != home for r in references)
    return NoiseModel(tuple(effects), pedestal, home, best.seed, references if differ else ())


def _level(model: NoiseModel, at: OperatingPoint) -> float:
    """Typical dark signal of a channel at its reference exposure, DN."""
    base = model.get(BASE)
    return math.exp(base.value("mu", at)) if base is not None else 0.0


def _read(effect: Effect, best: NoiseModel, other: NoiseModel) -> Effect:
    """A pixel's effect as another channel reads it: amounts in proportion to the dark signal."""
    at = best.reference
    there = _level(best, at)
    ratio = _level(other, replace(other.reference, temperature_c=at.temperature_c)) / (there or 1.0)
    new = {}
    for name, info in effect.parameters().items():
        law = getattr(effect, name)
        if info.scale == "choice" or not info.unit.startswith("DN"):
            continue
        moved = scaled(law, ratio)
        new[name] = _inside(moved, info)
    return replace(effect, **new)


def _inside(law: Law, info: ParameterInfo) -> Law:
    def clip(value: float) -> float:
        return min(max(value, info.lower), info.upper)

    if isinstance(law, TableLaw):
        return replace(law, values=tuple(map(clip, law.values)))
    if isinstance(law, ArrheniusLaw):
        return replace(law, value=clip(law.value))
    return clip(law)


def _merged_effect(
    kind: type[Effect],
    own: Mapping[str, Effect | None],
    models: Mapping[str, NoiseModel],
    bright: str,
    temperatures: Sequence[float],
) -> Effect:
    values: dict[str, Any] = {}
    first = own.get(bright)
    for key, info in kind.parameters().items():
        if first is not None and is_shared(kind, info):
            values[key] = getattr(first, key)
        elif info.scale == "choice":
            words = Counter(getattr(e, key) for e in own.values() if e is not None)
            values[key] = words.most_common(1)[0][0]
        else:
            laws = [
                (c, models[c], getattr(e, key) if e is not None else _weakest(info))
                for c, e in own.items()
            ]
            values[key] = _table(laws, temperatures)
    return kind(**values)


def _table(laws: Sequence[tuple[str, NoiseModel, Law]], temperatures: Sequence[float]) -> TableLaw:
    """Rows over channels; of each the rows of its own law."""
    rows = [
        (replace(point, channel=channel), value)
        for channel, model, law in laws
        for point, value in _rows(law, model, temperatures)
    ]
    return TableLaw(tuple(p for p, _ in rows), tuple(v for _, v in rows))


def _rows(
    law: Law, model: NoiseModel, temperatures: Sequence[float]
) -> Iterator[tuple[OperatingPoint, float]]:
    if isinstance(law, TableLaw):
        yield from zip(law.points, law.values, strict=True)
    elif isinstance(law, ArrheniusLaw):
        for celsius in temperatures or (law.at_c,):
            at = replace(model.reference, temperature_c=celsius)
            yield OperatingPoint(celsius), value_at(law, at)
    else:
        yield OperatingPoint(), float(law)
