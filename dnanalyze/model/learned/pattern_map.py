"""The fixed pattern of one sensor, as a map that was learned from its frames."""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effect import Effect, Site, Stage, choice, parameter
from dnanalyze.model.learned.field_map import FieldMap

NO_MAP = FieldMap(np.zeros((1, 1), np.float32))


@dataclass(frozen=True)
class PatternMap(Effect):
    """y += A law m, m a map of the frame."""

    name: ClassVar[str] = "pattern_map"
    stage: ClassVar[Stage] = Stage.LINE_READ
    varies: ClassVar[str] = "fixed"
    summary: ClassVar[str] = "Fixed pattern of one sensor, from a map in a file."
    physics: ClassVar[str] = (
        "What is left of the mean frames of this sensor beside the model, in the frequency bands "
        "in which it exceeds what the model's own fixed pattern and the temporal noise leave. The "
        "map is that of one sensor: another sensor of the same design has another. "
        "`dnanalyze describe --map` learns it."
    )
    formula: ClassVar[str] = (
        "y += A m (constant);  y += A m (t / t_ref) exp(-Ea / k (1/T - 1/T_ref)) (thermal)"
    )

    law: str = choice("constant", "dependence on the operating point", "constant", "thermal")
    amplitude: float = parameter(1.0, "1", 1e-3, 1e3, "factor of the map")
    ea_ev: float = parameter(0.6, "eV", -2.0, 2.0, "activation energy of law thermal", "linear")
    map: FieldMap = choice(  # noqa: RUF009
        NO_MAP, "map of the frame, DN at the reference operating point"
    )

    @classmethod
    def from_plain(cls, raw: dict[str, Any]) -> Effect:
        """Build from YAML; the map is read from the file that it names.

        Raises
        ------
        InputError
            No map, an unknown parameter, or a value outside its bounds.
        """
        made = super().from_plain({k: v for k, v in raw.items() if k != "map"})
        assert isinstance(made, PatternMap)
        return replace(made, map=FieldMap.from_plain(raw.get("map")))

    def inactive_parameters(self) -> tuple[str, ...]:
        """The energy of a constant pattern."""
        return () if self.law == "thermal" else ("ea_ev",)

    def to_plain(self) -> dict[str, Any]:
        """As written in YAML, without what the law does not use."""
        return {k: v for k, v in super().to_plain().items() if k not in self.inactive_parameters()}

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Add the map.

        Raises
        ------
        InputError
            The frame has another shape than the map.
        """
        if site.shape != self.map.shape:
            raise InputError(
                f"pattern_map: a map of {self.map.shape[0]} × {self.map.shape[1]} pixels; "
                f"the frame has {site.shape[0]} × {site.shape[1]}"
            )
        size = self.value("amplitude", site.point)
        if self.law == "thermal":
            size *= site.exposure_ratio * site.thermal(self.value("ea_ev", site.point))
        signal += np.float32(size) * self.map.array[site.window.slices]
        return signal

    def variance(self, point: OperatingPoint) -> float | None:
        """A^2 times the variance of the map where the law is constant, DN^2."""
        if self.law != "constant":
            return None
        return self.value("amplitude", point) ** 2 * float(self.map.array.var())


def named(effect: PatternMap, map_file: Path, model_file: Path | None = None) -> PatternMap:
    """The effect with the name of its map's file, as the model file is to state it.

    Parameters
    ----------
    effect : PatternMap
    map_file : Path
        Where the map is written.
    model_file : Path, optional
        Where the model is written; the name of the map is stated from there.
    """
    folder = map_file.absolute().parent if model_file is None else model_file.absolute().parent
    name = os.path.relpath(map_file.absolute(), folder)
    return replace(effect, map=replace(effect.map, file=name))
