"""Finds the mission to fly, by value or name: a stepped mission, or a planned one such as a lawn-mower survey."""

from __future__ import annotations

import importlib
import inspect
import sys
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, cast

from uwsim.base.named import did_you_mean
from uwsim.flight.field_flight import FieldFlight
from uwsim.flight.flyable_lanes import (
    LEAST_SHARE,
    SurveyAreaWarning,
    flyable_plan,
    required_plan,
    required_survey,
    survey_plan,
)
from uwsim.flight.mission_file import FUNCTION, load_mission, mission_name, with_arguments
from uwsim.missions import COVERED, AdaptiveLawnMower, LawnMowerPlan, Mission, StoppedError
from uwsim.missions.field import is_mission_file
from uwsim.missions.own_vehicle import OwnVehicle
from uwsim.missions.run import MissionFunction, R_co, SteppedMission, first_parameter, made, steps_of
from uwsim.missions.steps import Steps, drive
from uwsim.missions.unrun_steps import require_steps_run
from uwsim.navigation.control.protocols import Clock, SurveyVehicle
from uwsim.simulator.simulator import Simulator

MakeMission = Callable[[SurveyVehicle, Clock, LawnMowerPlan], Mission]
AnyMission = MissionFunction[R_co] | MakeMission | str | Path | None
SURVEY = "survey"


@dataclass(frozen=True)
class Begun:
    """A mission bound to its vehicles, ready to run.

    parts: one mission for all vehicles, or one per vehicle. run: flies to the end and returns the mission's result;
    raises StoppedError if the mission ends early.
    """

    parts: Sequence[Steps[Any] | SteppedMission | Mission]
    run: Callable[[], Any]

    @property
    def progress(self) -> float | None:
        """The fraction flown so far, 0..1; None if unknown."""
        return getattr(self.parts[0], "progress", None)


@dataclass(frozen=True)
class FlownMission:
    """A mission to fly.

    title: its name in reports. steps: its function or class; None for a planned mission. make: creates a planned
    mission. file: the file that contains it, if any. name: the MODULE:NAME of a mission that is not in a
    file. field: a flight by a file of the field, which has steps once it is bound.
    """

    title: str
    steps: MissionFunction | None = None
    make: MakeMission | None = None
    file: Path | None = None
    name: str | None = None
    field: FieldFlight | None = None

    def bound(self, sim: Simulator, names: tuple[str, ...], out: Path | None) -> FlownMission:
        """Return the mission with the steps that depend on the simulator, if any. Raises MissionError."""
        return self if self.field is None else replace(self, steps=self.field.bound(sim, names, out))

    @property
    def flies_all(self) -> bool:
        """Whether the mission flies all vehicles at once."""
        return self.steps is not None and first_parameter(self.steps) == "vehicles"

    def planned(self, sim: Simulator, least_share: float = LEAST_SHARE) -> tuple[LawnMowerPlan | None, str | None]:
        """Return the plan for a planned mission, and a sentence about lanes left out; both may be None.

        Raises ScenarioError if the scenario has no survey, too little of it can be flown, or its first vehicle cannot
        fly lanes.
        """
        if self.make is None:
            return None, None
        if inspect.isclass(self.make) and issubclass(self.make, AdaptiveLawnMower):
            return required_plan(sim, least_share)
        return flyable_plan(sim, survey_plan(required_survey(sim.scenario)), least_share)

    def begun(self, vehicles: Mapping[str, OwnVehicle], clock: Clock, plan: LawnMowerPlan | None) -> Begun:
        """Return the mission bound to its vehicles, ready to run."""
        if self.steps is not None:
            parts = made(self.steps, vehicles)
            return Begun(parts, lambda: drive(steps_of(parts), clock))
        assert self.make is not None and plan is not None
        planned = self.make(next(iter(vehicles.values())), clock, plan)
        return Begun([planned], lambda: _completed(planned))


def _completed(mission: Mission) -> str:
    """Run a planned mission; return the reason it ended. Raises StoppedError, stating it, if lanes remain unflown."""
    ended = mission.run()
    if ended != COVERED:
        raise StoppedError(ended)
    return ended


def found_mission(
    mission: AnyMission, function: str = FUNCTION, arguments: Mapping[str, Any] | None = None
) -> FlownMission:
    """Return a mission that can be flown. Raises ValueError if it is not a mission, OSError if its file cannot be read.

    mission: a generator function, or a class with `steps`, that takes one vehicle or `vehicles`; a class or other
    callable that takes (vehicle, clock, plan), see uwsim.missions.Mission; the `package.module:name` of one of these;
    the path of a Python file, whose `function` is flown, or of a file of the field (uwsim.missions.field); or None for
    the adaptive lawn-mower over the scenario's survey. arguments: values for the other parameters of a function or of a
    class with `steps`, or the settings of a flight by a file of the field.
    """
    if mission is None:
        return FlownMission(SURVEY, make=AdaptiveLawnMower)
    if isinstance(mission, str) and not Path(mission).exists() and ":" not in mission and not mission.endswith(".py"):
        raise ValueError(f"mission '{mission}': must be MODULE:NAME, such as my_missions:Spiral, or a file")
    if isinstance(mission, str | Path) and not _is_name(mission):
        if is_mission_file(Path(mission)):
            field = FieldFlight.of(Path(mission), arguments or {})
            return FlownMission(Path(mission).name, file=Path(mission), field=field)
        steps = with_arguments(load_mission(mission, function), arguments or {})
        return FlownMission(Path(mission).name, steps=steps, file=Path(mission))
    found = imported(str(mission)) if isinstance(mission, str | Path) else mission
    if not callable(found):
        rule = "must be a function, a class, MODULE:NAME or a Python file"
        hint = "; one of all vehicles takes `vehicles`" if isinstance(found, Mapping) else ""
        raise ValueError(f"mission = {found!r:.60}: {rule}{hint}")
    name = mission if isinstance(mission, str) else _name_of(found)
    if _takes(found, 3) and not _takes(found, 1) and not inspect.isgeneratorfunction(inspect.unwrap(found)):
        return FlownMission(_title(found), make=cast("MakeMission", found), name=name)
    if not inspect.signature(found).parameters:
        rule = "must take (vehicle, clock, plan) and make a uwsim.missions.Mission, or be a generator of (vehicle)"
        raise ValueError(f"mission {_title(found)}: {rule}")
    steps = with_arguments(cast("MissionFunction", found), arguments or {})
    first_parameter(steps)  # raises ValueError, as does the next
    require_steps_run(steps)
    return FlownMission(mission_name(steps, None), steps=steps, name=mission if isinstance(mission, str) else None)


def warn_of_left_out(sentence: str | None) -> None:
    """Warn about the lanes left out, if there is a sentence about them."""
    if sentence is not None:
        warnings.warn(sentence, SurveyAreaWarning, stacklevel=3)


def _is_name(mission: str | Path) -> bool:
    return isinstance(mission, str) and ":" in mission and not Path(mission).exists()


def _title(found: Callable[..., Any]) -> str:
    return SURVEY if found is AdaptiveLawnMower else str(getattr(found, "__name__", type(found).__name__))


def _name_of(found: Callable[..., Any]) -> str | None:
    """Return the `module:name` under which a mission can be imported again; None if it has no such name."""
    module, name = getattr(found, "__module__", None), getattr(found, "__qualname__", None)
    return f"{module}:{name}" if module not in (None, "__main__") and name and "<" not in name else None


def _takes(found: Callable[..., Any], count: int) -> bool:
    """Return whether `found` can be called with `count` positional arguments."""
    try:
        inspect.signature(found).bind(*[None] * count)
    except TypeError:
        return False
    return True


def imported(name: str) -> Callable[..., Any]:
    """Import `package.module:name`, also from the working directory.

    Raises ValueError if it cannot be imported or called.
    """
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
