"""A survey's mission of one's own: a class, or a function with steps, or the name of either."""

from __future__ import annotations

import importlib
import inspect
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, cast

from uwsim.control.protocols import Clock, SurveyVehicle
from uwsim.did_you_mean import did_you_mean
from uwsim.missions import COVERED, AdaptiveLawnMower, LawnMowerPlan
from uwsim.missions.own_vehicle import OwnVehicle
from uwsim.missions.run import first_parameter
from uwsim.missions.steps import Steps, drive
from uwsim.survey.fly import MakeMission

OwnMission = MakeMission | Callable[..., Any]


class SteppedMission:
    """A generator function of one vehicle as a survey's mission. It tells no progress and cannot be resumed."""

    progress = 0.0

    def __init__(self, function: Callable[..., Any], vehicle: Any, clock: Clock) -> None:
        own = vehicle if isinstance(vehicle, OwnVehicle) else OwnVehicle(vehicle, clock)
        self._steps, self._clock = function(own), clock

    def steps(self) -> Steps[Any]:
        """Return the function's steps."""
        steps: Steps[Any] = self._steps
        return steps

    def run(self) -> str:
        """Fly to the end; return the mission's own text, if it returns one, else that all is flown."""
        result = drive(self._steps, self._clock)
        return result if isinstance(result, str) else COVERED


def maker(mission: OwnMission | str | None) -> MakeMission:
    """Return what makes the mission of a survey. Raises ValueError for what is neither.

    mission: a class, or another callable, of (vehicle, clock, plan) with `progress` and `run()`, as
    uwsim.missions.Mission says; a generator function of one vehicle; or `package.module:name` of one of these. None:
    the adaptive lawn-mower.
    """
    if mission is None:
        return AdaptiveLawnMower
    found: Callable[..., Any] = imported(mission) if isinstance(mission, str) else mission
    if inspect.isgeneratorfunction(inspect.unwrap(found)):
        if first_parameter(found) == "vehicles":
            raise ValueError(
                f"mission {name_of(found)}: flies several vehicles; a survey has one: `def mission(vehicle)`"
            )
        return lambda vehicle, clock, plan: SteppedMission(found, vehicle, clock)
    try:
        inspect.signature(found).bind(None, None, None)
    except TypeError:
        rule = "must take (vehicle, clock, plan) and make a uwsim.missions.Mission, or be a generator of (vehicle)"
        raise ValueError(f"mission {name_of(found)}: {rule}") from None
    return cast("Callable[[SurveyVehicle, Clock, LawnMowerPlan], Any]", found)


def name_of(mission: OwnMission | str | None) -> str | None:
    """Return `module:name` of a mission; None for the lawn-mower."""
    if mission is None or isinstance(mission, str):
        return mission
    return f"{getattr(mission, '__module__', '?')}:{getattr(mission, '__qualname__', type(mission).__name__)}"


def imported(name: str) -> Callable[..., Any]:
    """Import `package.module:name`, also from the working folder. Raises ValueError."""
    module_name, colon, attribute = name.partition(":")
    if not colon or not module_name or not attribute:
        raise ValueError(f"mission '{name}': must be MODULE:NAME, such as my_package.missions:Spiral")
    sys.path.insert(0, str(Path.cwd()))
    try:
        module = importlib.import_module(module_name)
    except ImportError as error:
        raise ValueError(f"mission '{name}': cannot be imported: {error}") from None
    except Exception as error:
        raise ValueError(f"mission '{name}': its module raised {type(error).__name__}: {error}") from error
    finally:
        sys.path.remove(str(Path.cwd()))
    found: Any = module
    for part in attribute.split("."):
        if not hasattr(found, part):
            raise ValueError(
                f"mission '{name}': {module_name} has no '{attribute}'{did_you_mean(attribute, dir(module))}"
            )
        found = getattr(found, part)
    if not callable(found):
        raise ValueError(f"mission '{name}': is a {type(found).__name__}, must be a class or a function")
    return cast("Callable[..., Any]", found)
