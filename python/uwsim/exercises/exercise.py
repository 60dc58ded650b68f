"""Exercise: the model of an exercise's YAML file, and the scenario in which it is flown."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, PrivateAttr, ValidationInfo, WithJsonSchema, model_validator

from uwsim.base.commands import COMMANDS
from uwsim.base.named import did_you_mean
from uwsim.channels.authority.rights import AidKind
from uwsim.exercises.by_seed import Conditions, PropShift, exchanged
from uwsim.exercises.goal import Goal, Points
from uwsim.exercises.lag import LAG_MAX_S, with_lag
from uwsim.exercises.limits import Limit
from uwsim.scenario.load import load
from uwsim.scenario.read.assets import packaged_names
from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.read.spec_file import read_spec
from uwsim.scenario.read.validated import validated
from uwsim.scenario.spec.fields import InRange, Model, Name, Point3, broken
from uwsim.scenario.spec.obstacle import ObstacleSpec
from uwsim.scenario.spec.prop import PropEntry
from uwsim.scenario.spec.scenario import Scenario
from uwsim.scenario.spec.tether import Tether
from uwsim.scenario.spec.vehicle import VehicleName
from uwsim.scenario.spec.vehicle_entry import StartPose

FOLDER = "exercises"
COURSE = (
    "hover", "slalom", "pool-course", "sea-course", "reef-course", "rov-course", "approach", "docking", "gust",
    "pipeline", "reef-diver", "kelp-seal", "quay", "net-inspection", "cable", "reef-pipeline", "wreck-dive",
    "night-gates", "tether", "depth-gauge", "dvl-loss", "thruster-loss", "pin", "valve", "sample", "wet-mate",
)  # fmt: skip
"""The packaged exercises in the order in which a beginner flies them: steering, inspection, failures, the arm."""
EVENT_COMMANDS = (
    "inject_fault", "end_fault", "set_parameter", "set_parameters", "reset_parameters", "set_optics",
)  # fmt: skip


class Near(Model):
    """A place that triggers an event when the vehicle approaches it.

    position_m: position in the world. within_m: distance at which it triggers.
    """

    position_m: Point3
    within_m: Annotated[float, InRange(0.01, 1000, "m")] = 2.0


class Event(Model):
    """An event that happens once, unannounced.

    at_s: the time since the beginning; near: a place; after: the name of a goal that has been met. Exactly one of these
    three is required. command: a command of the simulator. arguments: its arguments. note: its description in the
    sheet.
    """

    one_of = ("at_s", "near", "after")

    at_s: Annotated[float, InRange(0, 1e5, "s")] | None = Field(None, examples=[30])
    near: Near | None = None
    after: Name | None = None
    command: Annotated[str, WithJsonSchema({"enum": list(EVENT_COMMANDS)})]
    arguments: dict[str, Any] = Field(
        default_factory=dict, examples=[{"kind": "current", "velocity_world_m_s": [0.2, 0, 0]}]
    )
    note: str = ""

    @model_validator(mode="after")
    def _has_one_cause_and_a_known_command(self) -> Event:
        if sum(cause is not None for cause in (self.at_s, self.near, self.after)) != 1:
            raise broken("exactly one of at_s, near and after must be given")
        if self.command not in EVENT_COMMANDS:
            raise broken(f"must be one of {', '.join(EVENT_COMMANDS)}", at=("command",), value=self.command)
        try:
            COMMANDS[self.command].check(self.arguments)
        except ValueError as error:
            raise broken(str(error), at=("arguments",)) from None
        return self


class Aid(Model):
    """An aid that the pilot may use.

    kind: autopilot (a plan on the chart, flown by the station), hold (the vehicle's holds) or program (a program that
    commands the vehicle, over any bridge). cost_per_s: points lost per second of use.
    """

    kind: AidKind
    cost_per_s: Points = 0.0


class Exercise(Model):
    """An exercise for a pilot.

    title: one line. brief: the task in words. scenario: a packaged name, or the path of a YAML file, looked for beside
    the exercise's first. vehicle: a packaged model that replaces the first vehicle's. obstacles, props: added to the
    scenario's. exchanged: sets of props of which the seed draws who stands in whose place. layout: how far props may
    stand from their places, by the seed. conditions: water and light by the seed. hidden: names of obstacles that the
    station's 3D view and chart leave out. start, tether: of the first vehicle, by default as in the scenario. seed:
    seed of all random draws. time_s: time after which it ends. goals, limits, events: see their models. aids: those
    that the pilot may use; all others are refused. pass_points: points needed to pass. lag_s: the time that sound takes
    from the pilot to the vehicle, and as long back, by which commands and sight are late; 0: none, nor a link.
    """

    title: str = Field(min_length=1, max_length=120, examples=["New exercise"])
    brief: str = Field(min_length=1, max_length=2000, examples=["Meet the goals in their order."])
    scenario: str
    vehicle: VehicleName | None = None
    obstacles: list[ObstacleSpec] = Field(default_factory=list)
    props: Annotated[list[PropEntry], Field(max_length=200)] = Field(default_factory=list)
    exchanged: Annotated[list[list[Name]], Field(max_length=20)] = Field(default_factory=list)
    layout: Annotated[list[PropShift], Field(max_length=200)] = Field(default_factory=list)
    conditions: Conditions | None = None
    hidden: list[Name] = Field(default_factory=list)
    start: StartPose | None = None
    tether: Tether | None = None
    seed: Annotated[int, InRange(0, 2**32 - 1)] = 0
    time_s: Annotated[float, InRange(1, 1e5, "s")] = 600.0
    goals: list[Goal] = Field(min_length=1, max_length=200)
    limits: list[Limit] = Field(default_factory=list)
    events: list[Event] = Field(default_factory=list)
    aids: list[Aid] = Field(default_factory=list)
    pass_points: Points = Field(examples=[10])
    lag_s: Annotated[float, InRange(0, LAG_MAX_S, "s")] = 0.0
    _folder: Path = PrivateAttr(Path())

    @property
    def points(self) -> float:
        """The maximum score."""
        return sum(goal.points for goal in self.goals)

    @model_validator(mode="after")
    def _lies_in_a_folder(self, info: ValidationInfo) -> Exercise:
        self._folder = (info.context or {}).get("folder", Path())
        return self

    @model_validator(mode="after")
    def _fits_together(self) -> Exercise:
        names = [goal.name for goal in self.goals]
        for index, name in enumerate(names):
            if name in names[:index]:
                raise broken(f"there is already a goal '{name}'", at=("goals", index, "name"), value=name)
        for index, goal in enumerate(self.goals):
            for name in goal.earlier:
                if name not in names[:index]:
                    raise broken("must be the name of an earlier goal", at=("goals", index, "after"), value=name)
        for index, event in enumerate(self.events):
            if event.after is not None and event.after not in names:
                raise broken("must be the name of a goal", at=("events", index, "after"), value=event.after)
        for index, name in enumerate(self.hidden):
            if name not in [obstacle.name for obstacle in self.obstacles]:
                raise broken("must be the name of one of the exercise's obstacles", at=("hidden", index), value=name)
        kinds = [aid.kind for aid in self.aids]
        for index, kind in enumerate(kinds):
            if kind in kinds[:index]:
                raise broken(f"there is already an aid '{kind}'", at=("aids", index, "kind"), value=kind)
        if self.pass_points > self.points:
            raise broken(f"must be at most {self.points:g}, the points of all goals", at=("pass_points",))
        return self

    def _props(self, found: Scenario) -> dict[str, PropEntry]:
        """Return the scenario's and the exercise's props by name, where the seed puts them. Raises ScenarioError."""
        props = {one.name: one for one in (*found.placed_props, *self.props)}
        for index, names in enumerate(self.exchanged):
            for name in names:
                if name not in props:
                    raise _no_prop(f"exchanged[{index}]", name, props, self.scenario)
            props |= exchanged([props[name] for name in names], self.seed)
        for index, each in enumerate(self.layout):
            if each.prop not in props:
                raise _no_prop(f"layout[{index}].prop", each.prop, props, self.scenario)
            props[each.prop] = each.drawn(props[each.prop], self.seed)
        return props

    def scene(self) -> Scenario:
        """Return the scenario as its file has it. Raises ScenarioError."""
        beside = self._folder / self.scenario
        return load(beside if beside.is_file() else self.scenario)

    def in_world(self, scene: Scenario | None = None) -> Exercise:
        """Return a copy whose goals are all in the world, those of props where the seed puts them.

        scene: the scenario, by default as its file has it. Raises ScenarioError.
        """
        if all(goal.of is None for goal in self.goals):
            return self
        props, goals = self._props(scene or self.scene()), []
        for index, goal in enumerate(self.goals):
            if goal.of is not None and goal.of not in props:
                raise _no_prop(f"goals[{index}].of", goal.of, props, self.scenario)
            goals.append(goal if goal.of is None else goal.in_world(props[goal.of]))
        return self.model_copy(update={"goals": goals})

    def made_scenario(self, scene: Scenario | None = None) -> Scenario:
        """Return the scenario with the exercise's obstacles, start, seed and time.

        scene: see in_world. Raises ScenarioError.
        """
        found = scene or self.scene()
        props = self._props(found)
        if self.vehicle is not None:
            found = found.with_changes(vehicle_model=self.vehicle)
        data = found.given()
        data["seed"] = self.seed
        data["mission_time_s"] = max(found.mission_time_s, 2 * self.time_s)
        data["obstacles"] = [*found.obstacles, *self.obstacles]
        if self.conditions is not None:
            data.update(self.conditions.drawn(found, self.seed))
        if self.layout or self.props or self.exchanged:
            for key in ("obstacles", "objects", "pingers"):  # those of the props are the last
                own = len(getattr(found, key)) - sum(len(getattr(one.model, key)) for one in found.placed_props)
                data[key] = getattr(found, key)[:own]
            data["obstacles"] = [*data["obstacles"], *self.obstacles]
            data["props"] = list(props.values())
        first = {key: value for key in ("start", "tether") if (value := getattr(self, key)) is not None}
        if first:
            data["vehicles"] = [{**found.vehicles[0].given(), **first}, *found.vehicles[1:]]
        made = validated(Scenario, data).read_from(found.source_file)
        return with_lag(made, self.lag_s) if self.lag_s else made


def _no_prop(key: str, name: str, props: Mapping[str, PropEntry], scenario: str) -> ScenarioError:
    names = ", ".join(props) or "it has none"
    return ScenarioError(
        f"exercise: {key} = '{name}': must be a prop of '{scenario}': {names}{did_you_mean(name, props)}"
    )


def load_exercise(source: str | Path) -> Exercise:
    """Return an exercise by packaged name or path. Raises ScenarioError, with one line for each mistake."""
    return read_spec(Exercise, source, FOLDER)


def next_exercise(name: str) -> tuple[str, str]:
    """Return name and title of the packaged exercise after one of them; empty texts after the last or another one."""
    names = exercise_names()
    following = names[names.index(name) + 1 :][:1] if name in names else []
    return next(((each, load_exercise(each).title) for each in following), ("", ""))


def exercise_names() -> list[str]:
    """Return the names of the packaged exercises, in the order of the course; others come last."""
    return sorted(packaged_names(FOLDER), key=lambda name: COURSE.index(name) if name in COURSE else len(COURSE))
