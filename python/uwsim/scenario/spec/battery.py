"""A vehicle's battery, whose type has its own file and whose load is the scenario's; and its reactions to failures."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Annotated, Literal

from pydantic import BeforeValidator, Field, model_validator
from pydantic_core.core_schema import ValidationInfo

from uwsim.scenario.read.spec_file import read_spec
from uwsim.scenario.spec.fields import AssetName, InRange, Model, Name, broken

BatteryName = Annotated[str, AssetName("batteries")]
Share = Annotated[float, InRange(0, 1)]
Volts = Annotated[float, InRange(0.1, 1000, "V")]


class BatteryType(Model):
    """A type of battery, as sold.

    capacity_ah: charge of a full battery. open_circuit_v: pairs of a charge, as a fraction of the capacity, and the
    voltage at rest; from 0 to 1, linear between pairs. resistance_ohm: internal resistance, including leads.
    cutoff_v: the voltage under load below which it switches off until it is charged.
    """

    name: Name
    description: str = ""
    capacity_ah: Annotated[float, InRange(0.001, 1e5, "Ah")]
    open_circuit_v: Annotated[tuple[tuple[Share, Volts], ...], Field(min_length=2, max_length=1000)]
    resistance_ohm: Annotated[float, InRange(0, 100, "ohm")]
    cutoff_v: Volts

    @model_validator(mode="after")
    def _has_a_curve(self) -> BatteryType:
        charges, volts = zip(*self.open_circuit_v, strict=True)
        if (charges[0], charges[-1]) != (0.0, 1.0) or any(b <= a for a, b in pairwise(charges)):
            raise broken("charges must increase from 0 to 1", at=("open_circuit_v",))
        if any(b < a for a, b in pairwise(volts)):
            raise broken("voltages must not fall as the charge rises", at=("open_circuit_v",))
        if self.cutoff_v >= volts[-1]:
            rule = f"must be below the voltage of full charge, {volts[-1]:g} V"
            raise broken(rule, at=("cutoff_v",), value=self.cutoff_v, unit="V")
        return self


def load_battery(source: str | Path, folder: Path | None = None) -> BatteryType:
    """Load a type from a packaged name or a path, relative to `folder`. Raises ScenarioError."""
    return read_spec(BatteryType, source, "batteries", folder)


def _battery_type(value: object, info: ValidationInfo) -> object:
    return load_battery(value, (info.context or {}).get("folder")) if isinstance(value, str | Path) else value


class BatterySetup(Model):
    """A vehicle's battery and its load besides the thrusters. The name of a type is sufficient.

    model: the name of a packaged battery or the path of its YAML file, which is read into a BatteryType. hotel_w: power
    of everything but the thrusters, from the release on. initial_charge: charge at the start, as a fraction of the
    capacity; docking charges it fully.
    """

    model: Annotated[BatteryType, BeforeValidator(_battery_type, json_schema_input_type=BatteryName | BatteryType)]
    hotel_w: Annotated[float, InRange(0, 1e6, "W")] = 0.0
    initial_charge: Share = 1.0

    @model_validator(mode="after")
    def _can_supply_the_load(self) -> BatterySetup:
        if self.hotel_w * self.model.resistance_ohm >= self.model.cutoff_v**2:
            most_w = self.model.cutoff_v**2 / self.model.resistance_ohm
            raise broken(
                f"must be less than cutoff_v^2 / resistance_ohm, {most_w:g} W",
                at=("hotel_w",), value=self.hotel_w, unit="W",
            )  # fmt: skip
        return self


def _battery_setup(value: object) -> object:
    return {"model": value} if isinstance(value, str | Path) else value


BatterySpec = Annotated[
    BatterySetup, BeforeValidator(_battery_setup, json_schema_input_type=BatteryName | BatterySetup)
]
"""A battery's name or path, or a setup."""


Behaviour = Literal["hold", "surface", "return", "go_on"]
"""hold: keep depth, heading and position. surface: ascend. return: fly to the place of release. go_on: only report."""
Percent = Annotated[float, InRange(0, 100, "%")]


class Failsafe(Model):
    """The reaction of a released vehicle, in simulated time and by its own controller.

    silence_s: time without a command, or in a scenario with a link without any message from the station, after which it
    does `then`; none: never. The next message ends the reaction. then: the reaction to such silence. battery_percent,
    battery_then: the charge below which it reacts, and how; 0: never. leak_then, thruster_then, sensor_then: the
    reaction when it detects water inside, a thruster that does not respond, a sensor that is silent or stuck; none: not
    monitored. These reactions last until they are overridden; meanwhile commands have no effect. ascent_m_s: rate of
    ascent in `surface` and `return`. surface_m: the depth at which the ascent stops. speed_m_s: speed of the return.
    return_depth_m: depth of the return; none: the depth at release. height_m: minimum height above the bed during
    `return`.
    """

    silence_s: Annotated[float, InRange(0.1, 1e6, "s")] | None = None
    then: Behaviour = "hold"
    battery_percent: Percent = 0.0
    battery_then: Behaviour = "return"
    leak_then: Behaviour | None = None
    thruster_then: Behaviour | None = None
    sensor_then: Behaviour | None = None
    ascent_m_s: Annotated[float, InRange(0.01, 5, "m/s")] = 0.3
    surface_m: Annotated[float, InRange(0, 100, "m")] = 0.5
    speed_m_s: Annotated[float, InRange(0.05, 5, "m/s")] = 0.5
    return_depth_m: Annotated[float, InRange(0, 10_000, "m")] | None = None
    height_m: Annotated[float, InRange(0, 1000, "m")] = 3.0

    @model_validator(mode="after")
    def _watches_something(self) -> Failsafe:
        watched = (self.silence_s, self.leak_then, self.thruster_then, self.sensor_then)
        if self.battery_percent == 0 and all(value is None for value in watched):
            raise broken("monitors nothing: give silence_s, battery_percent, leak_then, thruster_then or sensor_then")
        return self
