"""Which instruments a hold needs and when they fall silent, and what is saved of a vehicle's holds."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

from pydantic import Field, FiniteFloat, NonNegativeInt

from uwsim.base.commands.holds import HOLDS
from uwsim.base.saved_state import State, Tick
from uwsim.simulator.vehicle import Vehicle

EVERY_HOLD = "imu"
COMPASS = "compass"
HoldName = Literal["heading", "depth", "altitude", "position", "speed"]
Effort = Annotated[float, Field(ge=-1, le=1)]


class Listener:
    """Counts the control periods for which each kind of sensor has had no valid sample.

    It checks only validity, as a real vehicle would: a stuck or biased sensor goes unnoticed. silent: counts by kind.
    """

    def __init__(self, vehicle: Vehicle, period_s: float) -> None:
        self._vehicle = vehicle
        self._period_s = period_s
        self._first: dict[str, Any] = {}
        for sensor in vehicle.sensors.values():
            self._first.setdefault(sensor.kind, sensor)
        self.silent: dict[str, int] = {}

    def kind_for(self, hold: str) -> str:
        """Return the kind of sensor that measures a hold's target; "" if the vehicle has none."""
        return next((kind for kind in HOLDS[hold].sensors if kind in self._first), "")

    def lack(self, hold: str) -> str:
        """Return why the vehicle is not equipped for a hold; "" if it is."""
        if not self.kind_for(hold) or not self.has(EVERY_HOLD):
            needed = dict.fromkeys((" or ".join(HOLDS[hold].sensors), EVERY_HOLD))
            return f"needs sensors of kind {' and '.join(needed)}"
        driven = self._vehicle.controllable  # a vehicle without vertical thrust climbs by pitching
        driven = driven | {"heave"} if "pitch" in driven else driven
        lacking = [axis for axis in HOLDS[hold].axes if axis not in driven]
        return f"the vehicle has no actuator for {' and '.join(lacking)}" if lacking else ""

    def has(self, kind: str) -> bool:
        """Return whether the vehicle has a sensor of this kind."""
        return kind in self._first

    def value(self, kind: str) -> float:
        """Return the latest valid value of a sensor that measures one number; NaN if there is none."""
        return float(self._first[kind].sample().value) if self.is_heard(kind) else math.nan

    def is_heard(self, kind: str) -> bool:
        """Return whether the vehicle has a sensor of this kind whose latest sample is valid."""
        if kind not in self._first:
            return False
        sample = self._first[kind].sample()
        return bool(sample.valid) and not (isinstance(sample.value, float) and not math.isfinite(sample.value))

    def listen(self, kinds: set[str]) -> None:
        """Count one control period for these kinds, and forget the others."""
        self.silent = {kind: self._silent_for(kind) for kind in sorted(kinds)}

    def silence_s(self, kind: str) -> float:
        """Return for how long a kind of sensor has been silent."""
        return self.silent.get(kind, 0) * self._period_s

    def _silent_for(self, kind: str) -> int:
        return 0 if self.is_heard(kind) else self.silent.get(kind, 0) + 1


class HoldsState(State):
    """Saved holds. targets: targets of the active holds; None while the stick steers or the vehicle brakes.

    braking: the tick at which each hold's stick was let go. memory: the Controller's state, once it has started.
    efforts: its last efforts.
    """

    targets: dict[HoldName, list[FiniteFloat] | None]
    braking: dict[HoldName, Tick]
    silent: dict[str, NonNegativeInt]
    stick: Annotated[list[Effort], Field(min_length=6, max_length=6)]
    efforts: Annotated[list[FiniteFloat], Field(min_length=6, max_length=6)]
    memory: Annotated[list[FiniteFloat], Field(min_length=25, max_length=25)] | None
    note: str
    next_control: Tick
