"""A scenario's faults: what fails, when, and for how long. uwsim's own kinds are in `scenario/faults.py`.

Kinds are registered in the entry point group `uwsim.kinds.fault`; docs/inside/extend.md adds one from another package.
A kind overrides methods of FaultModel. A fault begins and ends between two steps; meanwhile `apply` changes parameters,
which return to their former values when it ends.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, MutableMapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Protocol

from pydantic import model_validator

from uwsim.base.named import did_you_mean
from uwsim.scenario.spec.fields import InRange, Model, Name, broken
from uwsim.scenario.spec.kinds import Kinds
from uwsim.scenario.spec.vehicle import VehicleModel

Share = Annotated[float, InRange(0, 1)]
Overlay = MutableMapping[str, Any]
"""Parameters by name: reading one returns its value after earlier faults, or else that of the scenario and the user."""


class FaultySensor(Protocol):
    """A sensor as faults change it; see uwsim.instruments.Sensor."""

    @property
    def unit(self) -> str | dict[str, str]:
        """The unit of the value, or those of several quantities by name."""

    def stick(self) -> None:
        """Repeat the current reading from now on."""

    def add_bias(self, bias: float, field: str | None) -> None:
        """Add a constant to each component of a field, or of all fields, from now on."""

    def distort(self, distortion: None) -> None:
        """Return to undistorted readings."""


class FaultyTether(Protocol):
    """A tether as faults change it; see uwsim.simulator.tether.Tether."""

    @property
    def length_m(self) -> float:
        """The length that is out, without load."""

    def cut(self, at_m: float) -> object:
        """Cut it at this length from its anchor."""


@dataclass(frozen=True)
class FaultyVehicle:
    """The vehicle that a fault affects. sensors: by name. sonars: the names of its multibeams.

    tethers: all of the scenario, by the vehicle or object that has them.
    """

    name: str
    model: VehicleModel
    sensors: Mapping[str, FaultySensor]
    sonars: Collection[str]
    tethers: Mapping[str, FaultyTether]

    def parts(self, of: str) -> list[str]:
        """Return the names of its parts of a sort: "sensors", "thrusters", "cameras" and so on."""
        return list(self.sensors if of == "sensors" else getattr(self.model, of))


@dataclass(frozen=True)
class Observer:
    """One that may notice faults, such as the task of a learning environment. name: in messages.

    sensors: those that it reads. watches_sensors: whether a failsafe watches the others. camera: the one whose pictures
    it sees. pings: whether it uses the multibeam. has_link: whether the scenario has a link.
    """

    name: str
    sensors: Collection[str]
    watches_sensors: bool
    camera: str | None
    pings: bool
    has_link: bool


@dataclass(frozen=True)
class PartOf:
    """A field's annotation: its value is the name of one of the vehicle's parts. sort: see FaultyVehicle.parts."""

    sort: str


class FaultModel(Model):
    """The fields common to all faults.

    name: name in the log; by default its kind, or kind_2 and so on if there are several of a kind. vehicle: name of the
    vehicle, by default the first. at_s: when it begins; either this or rate_per_h. rate_per_h: mean number of
    occurrences per hour, at random times (exponential intervals, drawn with the seed). for_s: its duration; by default
    until the end.
    """

    name: Name | None = None
    vehicle: Name | None = None
    at_s: Annotated[float, InRange(0, 1e6, "s")] | None = None
    rate_per_h: Annotated[float, InRange(1e-6, 1e5, "1/h")] | None = None
    for_s: Annotated[float, InRange(0.01, 1e6, "s")] | None = None

    if TYPE_CHECKING:
        kind: str

    cuts_link: ClassVar[bool] = False
    """True for a kind that blocks all messages between station and vehicle while it is active."""

    @model_validator(mode="after")
    def _begins_at_some_time(self) -> FaultModel:
        if (self.at_s is None) == (self.rate_per_h is None):
            raise broken("exactly one of at_s and rate_per_h must be given")
        return self

    @classmethod
    def parts(cls) -> dict[str, str]:
        """Return the fields that name a part of the vehicle, with the sort of part; see FaultyVehicle.parts."""
        rules = ((name, rule) for name, info in cls.model_fields.items() for rule in info.metadata)
        return {name: rule.sort for name, rule in rules if isinstance(rule, PartOf)}

    def check(self, vehicle: FaultyVehicle) -> None:
        """Raise ValueError if the fault names parts that the vehicle lacks."""
        for field, sort in self.parts().items():
            part, known = getattr(self, field), vehicle.parts(sort)
            if part is not None and part not in known:
                rule = f"must be one of {', '.join(known) or 'none'}{did_you_mean(part, known)}"
                raise ValueError(f"{field} = {part!r}: {rule}")

    def begin(self, vehicle: FaultyVehicle) -> None:
        """Change what is not a parameter, at the beginning."""

    def end(self, vehicle: FaultyVehicle) -> None:
        """Undo `begin`."""

    def apply(self, over: Overlay, vehicle: FaultyVehicle, water_kg: float) -> None:
        """Change parameters, on top of earlier faults. water_kg: the mass of water that the fault has let in."""

    def water_kg_after(self, water_kg: float, steps: int, step_s: float) -> float:
        """Return the mass of water [kg] that the fault has let in, some steps after it was water_kg."""
        return water_kg

    def tether_bears_n(self, of: str, vehicle: str) -> float:
        """Return the load at which it lets the tether of a vehicle or object break while it affects `vehicle` [N]."""
        return math.inf

    def unnoticed(self, observer: Observer) -> str:
        """Return why an observer does not notice the fault, or ""."""
        return ""


FAULTS = Kinds("uwsim.kinds.fault", FaultModel)
FaultSpec = Annotated[FaultModel, FAULTS]
