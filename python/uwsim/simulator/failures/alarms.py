"""The alarms that a vehicle raises from onboard measurements: battery, bilges, motors and sensor readings.

Alarms do not use the truth, so a bias goes undetected: biased readings look like any others.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any, Literal, Protocol, get_args

import numpy as np

from uwsim.scenario.spec.battery import Failsafe
from uwsim.scenario.spec.sensor import SensorMount
from uwsim.scenario.spec.vehicle import VehicleModel

Cause = Literal["battery", "leak", "thruster", "sensor"]
FailsafeCause = Literal["silence"] | Cause
FAILSAFE_CAUSES: tuple[str, ...] = ("silence", *get_args(Cause))
LOOK_S = 0.5  # time between two checks
WET_KG = 0.05  # mass of water that a leak sensor in the bilge detects
WEAK = 0.7  # fraction of the commanded thrust below which a motor counts as failed
WORKING = 0.1  # commands smaller than this are not checked
SILENT_LOOKS = 4  # consecutive checks without a valid sample, or with too little thrust, before an alarm
STUCK_LOOKS = 20  # consecutive checks with bit-identical values of a noisy sensor, before an alarm


class Watched(Protocol):
    """The attributes of a vehicle that its alarms check."""

    @property
    def thrusters(self) -> Mapping[str, Any]:
        """The command and thrust of each thruster."""

    @property
    def sensors(self) -> Mapping[str, Any]:
        """The sensors."""

    @property
    def battery(self) -> Any:
        """The battery's monitor."""

    def telemetry(self) -> Any:
        """Return the values on the vehicle's panel."""


@dataclass
class Alarms:
    """The alarms of one vehicle. lit: active alarms, as text, and their causes. counts, last: state between checks."""

    model: VehicleModel
    figures: Failsafe
    lit: dict[str, Cause] = field(default_factory=dict)
    counts: dict[str, int] = field(default_factory=dict)
    last: dict[str, list[float]] = field(default_factory=dict)

    def look(self, vehicle: Watched, water_kg: float) -> dict[str, Cause]:
        """Run all checks; return the active alarms. water_kg: mass of water inside the hull."""
        lit: dict[str, Cause] = {}
        if vehicle.telemetry().battery_percent < self.figures.battery_percent:
            lit["battery low"] = "battery"
        if self.figures.leak_then is not None and water_kg >= WET_KG:
            lit["water inside"] = "leak"
        if self.figures.thruster_then is not None:
            for name in self._weak_thrusters(vehicle):
                lit[f"thruster {name} does not obey"] = "thruster"
        if self.figures.sensor_then is not None:
            for name, what in self._failing_sensors(vehicle):
                lit[f"sensor {name} is {what}"] = "sensor"
        self.lit = lit
        return lit

    def _weak_thrusters(self, vehicle: Watched) -> list[str]:
        """Compare each thruster's thrust, derived from its motor speed, with the thrust expected from its command."""
        weak = []
        voltage_v = vehicle.battery.voltage_v
        for name, state in vehicle.thrusters.items():
            expected_n = abs(self._expected_n(name, state.command, voltage_v))
            fails = abs(state.command) >= WORKING and abs(state.thrust_n) < WEAK * expected_n
            if self._counted(f"thruster {name}", fails) >= SILENT_LOOKS:
                weak.append(name)
        return weak

    def _expected_n(self, name: str, command: float, voltage_v: float) -> float:
        mount = self.model.thrusters[name]
        if not math.isnan(voltage_v):
            sheets = mount.model.performance(mount.gain)
            return sheets.at(command, min(max(voltage_v, sheets.voltages_v[0]), sheets.voltages_v[-1]))[0]
        commands, thrusts_n = mount.model.curve_points
        return float(mount.gain * np.interp(command, commands, thrusts_n))

    def _failing_sensors(self, vehicle: Watched) -> list[tuple[str, str]]:
        failing = []
        for name, sensor in vehicle.sensors.items():
            mount = self.model.sensors[name]
            sample = sensor.sample()
            values = _numbers(sample.value)
            silent = all(math.isnan(value) for value in values)
            if self._counted(f"silent {name}", silent) >= SILENT_LOOKS:
                failing.append((name, "silent"))
                continue
            same = _never_repeats(mount) and sample.valid and values == self.last.get(name)
            self.last[name] = values
            if self._counted(f"stuck {name}", same) >= STUCK_LOOKS:
                failing.append((name, "stuck"))
        return failing

    def _counted(self, what: str, fails: bool) -> int:
        """Return the number of consecutive checks that have failed, up to and including this one."""
        self.counts[what] = self.counts.get(what, 0) + 1 if fails else 0
        return self.counts[what]


def _never_repeats(mount: SensorMount) -> bool:
    """Return whether successive samples of a sensor always differ, because a channel has noise and no rounding."""
    if mount.noise_std is not None:
        return mount.noise_std > 0
    errors = [mount.noise, *mount.channels.values()]
    return any(noise is not None and (noise.std > 0 or noise.density > 0) and not noise.quantum for noise in errors)


def _numbers(value: Any) -> list[float]:
    parts = [value] if isinstance(value, float) else [getattr(value, each.name) for each in fields(value)]
    return [float(number) for part in parts for number in np.ravel(part)]
