"""Sensors in Python: what is measured by one of the core's kinds becomes the quantities of another kind, with noise.

Their errors have no memory (errors.py), so that a derived sensor has no state.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, make_dataclass
from functools import partial
from typing import Any

import numpy as np

from uwsim.base.arrays import Floats
from uwsim.base.sockets import blaming
from uwsim.instruments.acoustics.pinger_sound import Burst, PingerSound
from uwsim.instruments.errors import Errors
from uwsim.instruments.readings import Reading
from uwsim.scenario.spec.sensor import Noise, SensorMount
from uwsim.scenario.spec.sensor_kind import GROUP, DerivedKind, Widths, figures_of


@dataclass(frozen=True)
class Derivation:
    """Computes a sensor's readings. name: "vehicle/sensor", of its random stream. rate_hz: of its samples.

    seed: returns the run's. sound: of the pingers, for a kind that listens to them.
    """

    kind: DerivedKind
    mount: SensorMount
    name: str
    rate_hz: float
    seed: Callable[[], int]
    sound: PingerSound

    def reading(self, values: Mapping[str, Any], stamp_ns: int, *, noise: bool) -> dict[str, Any]:
        """Return the quantities by name, numbers or arrays (n,), from those of the source. Raises ValueError."""
        with blaming(GROUP, self.kind.name, "measure"):
            time_s = 1e-9 * stamp_ns
            heard = (partial(self._ping, time_s),) if self.kind.listens else ()
            given = self.kind.measure(values, figures_of(self.kind, self.mount.parameters), time_s, *heard)
        if set(given) != set(self.kind.fields):
            rule = f"must measure {', '.join(self.kind.fields)}"
            raise ValueError(f"sensor kind '{self.kind.name}': measured {', '.join(given) or 'nothing'}: {rule}")
        found: dict[str, Any] = {}
        for name, (width, _) in self.kind.fields.items():
            value = np.array(given[name], np.float64).reshape(width)
            if noise:
                value = self._with_errors(name, value, stamp_ns)
            found[name] = float(value[0]) if width == 1 else value
        return found

    def rows(self, stamps_ns: Any, readings: Floats, source: Widths) -> Floats:
        """Return readings (n, width), the columns of all fields side by side, from those of the source."""
        starts = np.cumsum([width for width, _ in source.values()])[:-1]
        found = []
        for stamp_ns, row in zip(stamps_ns, readings, strict=True):
            parts = zip(source, np.split(row, starts), strict=True)
            values = {name: float(part[0]) if len(part) == 1 else part for name, part in parts}
            reading = self.reading(values, int(stamp_ns), noise=True)
            found.append(np.hstack([np.ravel(reading[name]) for name in self.kind.fields]))
        return np.array(found, np.float64).reshape(len(found), sum(width for width, _ in self.kind.fields.values()))

    def _ping(self, time_s: float, point_m: Floats, low_hz: float, high_hz: float) -> Burst | None:
        """Return the last burst that has arrived at a place between the sample before and this one, or None."""
        burst = self.sound.in_band(low_hz, high_hz).last_burst(lambda _: point_m, time_s)
        return None if burst is None or burst.arrival_s <= time_s - 1.0 / self.rate_hz else burst

    def _with_errors(self, channel: str, value: Floats, stamp_ns: int) -> Floats:
        noise = self.mount.channels.get(channel) or self.mount.noise or Noise(std=self.mount.noise_std or 0.0)
        return Errors(self.name, self.rate_hz, self.seed).added(noise, channel, value, stamp_ns)


def reading_class(kind: DerivedKind) -> type[Reading] | None:
    """Return a class for readings of several quantities; None if a reading is a single number."""
    if [width for width, _ in kind.fields.values()] == [1]:
        return None
    name = "".join(part.capitalize() for part in kind.name.replace("-", "_").split("_")) + "Reading"
    each = [(field, Any) for field in kind.fields]
    return make_dataclass(name, each, bases=(Reading,), frozen=True, eq=False, repr=False)
