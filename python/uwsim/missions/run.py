"""run: flies a mission with a clock and one or more vehicles."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Generator, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any, Protocol

from uwsim.missions.own_vehicle import Event, OwnVehicle
from uwsim.missions.steps import Steps, drive, parallel
from uwsim.missions.unrun_steps import require_steps_run
from uwsim.navigation.control.protocols import Clock

if TYPE_CHECKING:
    from typing_extensions import TypeVar

    R_co = TypeVar("R_co", covariant=True, default=Any)
else:
    from typing import TypeVar

    R_co = TypeVar("R_co", covariant=True)


class SteppedMission(Protocol[R_co]):
    """A mission flown by its steps, as a generator function is.

    R_co: the type of its result; by default any.
    """

    def steps(self) -> Steps[R_co]:
        """Return a generator of steps that yields waits and returns the mission's result."""


class Mission(SteppedMission[Any], Protocol):
    """A mission that a survey can fly, such as AdaptiveLawnMower."""

    @property
    def progress(self) -> float:
        """Fraction of the mission flown so far, 0..1."""

    def run(self) -> str:
        """Fly all steps with a clock that can wait; return why the mission ended."""


MissionFunction = Callable[..., Steps[R_co] | SteppedMission[R_co]]
"""A generator function, or a class with `steps`, that takes one vehicle or a dict of several by name."""


def run(
    mission: MissionFunction,
    vehicles: Any,
    clock: Clock,
    *,
    hear: Callable[[Event], object] = lambda event: None,
) -> Any:
    """Fly a mission to its end and return its result.

    mission: see `begin`. vehicles: one vehicle from a Simulator, a LiveSimulator or a rosbridge connection, or a dict
    of several. hear: called with each event that the mission logs.
    """
    hulls = vehicles if isinstance(vehicles, Mapping) else {getattr(vehicles, "name", "vehicle"): vehicles}
    own = {
        name: hull if isinstance(hull, OwnVehicle) else OwnVehicle(hull, clock, hear=hear)
        for name, hull in hulls.items()
    }
    return drive(begin(mission, own), clock)


def begin(mission: MissionFunction, vehicles: Mapping[str, OwnVehicle]) -> Steps[Any]:
    """Return the steps of a mission from its start; see `made` for which missions are accepted."""
    return steps_of(made(mission, vehicles))


def made(mission: MissionFunction, vehicles: Mapping[str, OwnVehicle]) -> list[Steps[Any] | SteppedMission]:
    """Return one mission for all vehicles if its first parameter is named `vehicles`, otherwise one per vehicle.

    Raises ValueError for anything other than a generator function of one argument, or a class of one argument with
    `steps`, and for a step that the mission never runs.
    """
    require_steps_run(mission)
    if first_parameter(mission) == "vehicles":
        return [mission(dict(vehicles))]
    return [mission(vehicle) for vehicle in vehicles.values()]


def steps_of(missions: list[Steps[Any] | SteppedMission]) -> Steps[Any]:
    """Return steps that fly all missions at once."""
    steps = [one if isinstance(one, Generator) else one.steps() for one in missions]
    return steps[0] if len(steps) == 1 else parallel(*steps)


def first_parameter(mission: MissionFunction) -> str:
    """Return the name of a mission's only required parameter. Raises ValueError if the argument is not a mission."""
    name = getattr(mission, "__name__", "mission")
    if not (inspect.isgeneratorfunction(inspect.unwrap(mission)) or _makes_steps(mission)):
        raise ValueError(f"{name}: has no `yield`: a mission is a generator: `yield wait(0.1)` lets time pass")
    given = list(inspect.signature(mission).parameters.values())
    required = [p for p in given if p.default is p.empty and p.kind not in (p.VAR_POSITIONAL, p.VAR_KEYWORD)]
    if not given or len(required) > 1 or (required and required[0] is not given[0]):
        raise ValueError(f"{name}{inspect.signature(mission)}: must take one argument: `vehicle`, or `vehicles`")
    return given[0].name


def _makes_steps(mission: MissionFunction) -> bool:
    made_by = mission.func if isinstance(mission, partial) else mission
    return inspect.isclass(made_by) and callable(getattr(made_by, "steps", None))
