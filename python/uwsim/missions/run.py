"""run: flies a mission with a vehicle, or several, and a clock."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from typing import Any

from uwsim.control.protocols import Clock
from uwsim.missions.own_vehicle import Event, OwnVehicle
from uwsim.missions.steps import Steps, drive, parallel

MissionFunction = Callable[..., Steps[Any]]


def run(
    mission: MissionFunction,
    vehicles: Any,
    clock: Clock,
    *,
    hear: Callable[[Event], object] = lambda event: None,
) -> Any:
    """Fly a mission to its end; return what it returns.

    mission: a generator function of one vehicle, or of `vehicles`, a dict of all by name; see `begin`. vehicles: one,
    or a dict of several, of a Simulator, a LiveSimulator or a rosbridge. hear: called with each event that it logs.
    """
    hulls = vehicles if isinstance(vehicles, Mapping) else {getattr(vehicles, "name", "vehicle"): vehicles}
    own = {
        name: hull if isinstance(hull, OwnVehicle) else OwnVehicle(hull, clock, hear=hear)
        for name, hull in hulls.items()
    }
    return drive(begin(mission, own), clock)


def begin(mission: MissionFunction, vehicles: Mapping[str, OwnVehicle]) -> Steps[Any]:
    """Return the steps of a mission.

    A mission whose first parameter is called `vehicles` gets all of them by name; any other flies each of them, at once
    if there are several. Raises ValueError if it is no generator function of one argument.
    """
    first = first_parameter(mission)
    if first == "vehicles":
        return mission(dict(vehicles))
    if len(vehicles) == 1:
        return mission(next(iter(vehicles.values())))
    return parallel(*(mission(vehicle) for vehicle in vehicles.values()))


def first_parameter(mission: MissionFunction) -> str:
    """Return the name of a mission's only required parameter. Raises ValueError if it is no mission."""
    name = getattr(mission, "__name__", "mission")
    if not inspect.isgeneratorfunction(inspect.unwrap(mission)):
        raise ValueError(f"{name}: has no `yield`: a mission is a generator: `yield wait(0.1)` lets time pass")
    given = list(inspect.signature(mission).parameters.values())
    required = [p for p in given if p.default is p.empty and p.kind not in (p.VAR_POSITIONAL, p.VAR_KEYWORD)]
    if not given or len(required) > 1 or (required and required[0] is not given[0]):
        raise ValueError(f"{name}{inspect.signature(mission)}: must take one argument: `vehicle`, or `vehicles`")
    return given[0].name
