"""Ranges from a sonar and an echo sounder, as part of observations."""

from __future__ import annotations

import numpy as np

from uwsim.batch import Batch
from uwsim.learning.task import Field, Floats

ALTITUDE = Field(
    "altitude", 1, 100.0, "m", "above the bed, by the echo sounder, with its noise; 100: no echo", 0.0, usual=(5.0,)
)


def ranges_field(beams: int, range_max_m: float) -> Field:
    """Return the observation field for the ranges of a ping; their usual size is half of the longest range."""
    about = f"of a ping, starboard to port; {range_max_m:g}: no echo"
    return Field("sonar_ranges", beams, range_max_m, "m", about, 0.0, usual=(0.5 * range_max_m,) * beams)


def seen_by_fan(batch: Batch, vehicle: str, fields: tuple[Field, ...]) -> Floats:
    """Return ranges and altitude, (n, beams + 1). Raises ValueError if the task needs a different number of beams."""
    fan = fields[0]
    ranges = batch.ping(vehicle).ranges_m
    if ranges.shape[1] != fan.width:
        raise ValueError(f"vehicle '{vehicle}': its sonar has {ranges.shape[1]} beams: the task needs {fan.width}")
    altitude = batch.read("altitude", vehicle)
    height_m = np.where(altitude.valid, altitude.fields["altitude_m"], ALTITUDE.limit)
    return np.column_stack([np.where(np.isfinite(ranges), ranges, fan.limit), height_m])
