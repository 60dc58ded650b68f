"""A vehicle's battery: the type is read from its own file, the load from the scenario."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Annotated

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
