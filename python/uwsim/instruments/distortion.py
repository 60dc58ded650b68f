"""Distortion: alters the readings of a faulty sensor."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Distortion:
    """An error in a faulty sensor's readings.

    stuck: constant values, by quantity, that replace the readings. bias: added to every value of `field`, or of all
    fields if `field` is None.
    """

    stuck: dict[str, list[float]] | None = None
    bias: float = 0.0
    field: str | None = None

    @staticmethod
    def stuck_at(values: Mapping[str, Any]) -> Distortion:
        """Return the distortion for a sensor that keeps repeating these values."""
        return Distortion({name: [float(number) for number in np.ravel(value)] for name, value in values.items()})

    def check(self, fields: Mapping[str, tuple[int, str]]) -> None:
        """Raise ValueError unless the distortion fits readings with these fields, given as width and unit by name."""
        widths = {name: width for name, (width, _) in fields.items()}
        if self.stuck is not None and {name: len(held) for name, held in self.stuck.items()} != widths:
            raise ValueError(f"stuck = {', '.join(self.stuck):.80}: must be values of {', '.join(widths)}")
        if self.field is not None and self.field not in widths:
            raise ValueError(f"field = {self.field!r:.40}: must be one of {', '.join(widths)}")

    def of(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Return the distorted values by quantity. Values are numbers, arrays (width,) or rows (n, width)."""
        return {name: self._distorted(name, value) for name, value in values.items()}

    def of_rows(self, readings: Any, fields: Mapping[str, tuple[int, str]]) -> Any:
        """Return the distorted readings (n, width), in which the columns of all fields lie side by side."""
        starts = np.cumsum([width for width, _ in fields.values()])[:-1]
        columns = dict(zip(fields, np.split(readings, starts, axis=1), strict=True))
        return np.hstack(list(self.of(columns).values()))

    def _distorted(self, name: str, value: Any) -> Any:
        if self.stuck is not None:
            held = self.stuck[name]
            return np.array(np.broadcast_to(held, np.shape(value))) if np.ndim(value) else held[0]
        return value + self.bias if self.field in (None, name) else value
