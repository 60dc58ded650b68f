"""The scene being edited: its files, which are valid after every change, and those before and after it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from uwsim.base.texts.yaml_document import dotted
from uwsim.channels.guest import Values
from uwsim.exercises.goal import GoalModel
from uwsim.operator.station.editor.files import EXERCISE, Place, SceneFiles, is_inherited, raw_parts
from uwsim.operator.station.editor.forms import SECTIONS, Section, flattened, forms
from uwsim.operator.station.editor.goal_values import exchanged, first_prop, free_name, goal_values, referring
from uwsim.operator.station.editor.ground_plan import GroundPlan
from uwsim.operator.station.editor.values import alone, given, start_values

STEPS_MAX = 200
NAMED = ("obstacles", "objects", "props", "cover", "life", "vehicles")
"""Sections whose parts have names, which are unique among them."""


class Draft:
    """A scene's files and their history. folder: of the files that they name.

    Every change is checked as a file would be, and raises ValueError, changing nothing, if it would be wrong. scenario,
    exercise, values, plan: of the present files; they must not be modified. edition: increases with every change.
    """

    def __init__(self, files: SceneFiles, folder: Path) -> None:
        self.folder, self.edition = folder, 0
        self._history = [files]
        self._at = 0
        self.plan = GroundPlan()
        self._show()

    @property
    def files(self) -> SceneFiles:
        """The texts as they are now."""
        return self._history[self._at]

    @property
    def goals(self) -> list[GoalModel]:
        """The exercise's goals, none without one."""
        return [] if self.exercise is None else self.exercise.goals

    @property
    def can_undo(self) -> bool:
        """True if there is a change to undo."""
        return self._at > 0

    @property
    def can_redo(self) -> bool:
        """True if an undone change can be repeated."""
        return self._at + 1 < len(self._history)

    def _show(self) -> None:
        """Hold what belongs to the present files. Raises ScenarioError if an obstacle cannot be built."""
        scenario, exercise = self.files.read(self.folder)
        self.plan.draw(scenario)
        self.scenario, self.exercise, self.values = scenario, exercise, self.files.values
        self._raw: dict[Place, dict[str, Any]] = {}

    def undo(self, steps: int = 1) -> None:
        """Undo changes, or repeat undone ones if negative. Raises ValueError if there are none."""
        if not 0 <= self._at - steps < len(self._history):
            raise ValueError("there is nothing to undo" if steps > 0 else "there is nothing to redo")
        self._at -= steps
        self._show()
        self.edition += 1

    def set(self, section: str, place: Place, values: Mapping[str, Any]) -> None:
        """Set fields of a part; None removes a field. Raises ValueError."""
        own, model = self.part(section, place), self._form(section, place)
        files = self.files
        if section == "starts" or is_inherited(self.values, place):  # written as a whole for the first time
            whole = {**own, **{key: given(model[key], value) for key, value in self._known(model, values)}}
            whole = {key: value for key, value in whole.items() if value is not None}
            self.take(self._with_part(files, place, whole))
            return
        for key, value in self._known(model, alone(model, values)):
            at = (*place, *key.split("."))
            if value is not None:
                files = files.with_value(at, given(model[key], value))
            elif key in SECTIONS[section].flat(own):
                files = files.without(at)
        if section == "goals" and isinstance(values.get("name"), str):
            files = referring(files, own["name"], values["name"])
        self.take(files)

    def add(
        self, section: str, kind: str, vehicle: int, at_m: Sequence[float], own: Mapping[str, Any] | None = None
    ) -> Place:
        """Add a part of a kind near a place (x, y) and return its place in the scenario. Raises ValueError.

        own: fields that it has in place of those with which a new part begins.
        """
        found = self._section(section)
        if kind not in forms()[section]:
            raise ValueError(f"kind = {kind[:40]!r}: must be one of {', '.join(forms()[section])}")
        x, y = (0.0 if found.of_vehicle else round(float(each), 3) for each in at_m)  # in the vehicle's frame
        model = {field["name"]: field for field in forms()[section][kind]}
        own = {key: given(model[key], value) for key, value in self._known(model, alone(model, own or {}))}
        values = start_values(section, kind, (x, y), own) | own
        values = {key: value for key, value in values.items() if value is not None}
        above = found.below(vehicle)
        self._require_vehicle(above)
        if above[0] == EXERCISE:
            return self._add_to_exercise(section, above, values, own)
        if found.holds == "names":
            name = free_name(kind or section.removesuffix("s"), list(self.names(above)))
            place: Place = (*above, name)
            self.take(self._with_part(self.files, place, values))
            return place
        if found.holds == "one":
            present = _at(self.values, above)
            if present is not None and (not kind or present.get(found.key) == kind):
                raise ValueError(f"{dotted(above)}: exists already")
            values |= {key: present[key] for key in found.without if present and key in present}
            self.take(self.files.with_value(above, values))  # in place of one of another kind
            return above
        items = _at(self.values, above) or []
        files = self.files
        if isinstance(items, Mapping):  # one current, written without a list
            files, items = files.without(above).with_value(above, [dict(items)]), [items]
        if section in NAMED:
            taken = [
                SECTIONS[key].flat(each).get(SECTIONS[key].field("name"))
                for key in NAMED
                for each in self.values.get(key, [])
            ]
            taken += [body.name for body in self.scenario.objects]
            named = values.get(found.inner, values)
            first = {"kind": kind} if kind else {}
            named = {**first, "name": free_name(kind or str(values["model"]), taken), **named}
            values = values | {found.inner: named} if found.inner else named
        place = (*above, len(items))
        if is_free := section == "props" and "position_m" not in own:
            values["position_m"] = [x, y, self.plan.bed_at_m(x, y, str(values["name"]))]
        files = files.with_value(place, values)
        if is_free:  # on a slope, its height follows from its solids
            prop = files.read(self.folder)[0].placed_props[-1]
            files = files.with_value((*place, "position_m"), [x, y, self.plan.stands_at_m(prop)])
        self.take(files)
        return place

    def _add_to_exercise(self, section: str, above: Place, values: Values, own: Mapping[str, Any]) -> Place:
        """Add a part of the exercise, which begins with its first part, and a goal."""
        files, goals = self.files, self.goals
        if section == "goals":
            values = goal_values(self.scenario, goals, values, own)
        if section == "layout":
            values |= first_prop(self.scenario, _at(self.values, above) or (), own)
        if not goals:
            files = files.with_value((EXERCISE,), start_values("exercise", "", (0, 0)) | {"scenario": files.name})
            first = goal_values(self.scenario, (), start_values("goals", "reach", (0.0, 0.0)), {})
            files = files if section == "goals" else files.with_value((EXERCISE, "goals", 0), first)
        if SECTIONS[section].holds == "one" and _at(self.values, above) is not None:
            raise ValueError(f"{dotted(above)}: exists already")
        if SECTIONS[section].holds == "list":
            above = (*above, len(_at(files.values, above) or ()))
        if section != "exercise":
            files = files.with_value(above, values)
        self.take(files)
        return above

    def move(self, section: str, place: Place, to: int) -> Place:
        """Let a goal and the one at number `to` change places, also in what comes after what; return its place.

        Raises ValueError.
        """
        self.part(section, place)
        if section != "goals" or not 0 <= to < len(self.goals):
            raise ValueError(f"to = {to}: must be the number of a goal, to which a goal is moved")
        self.take(exchanged(self.files, int(place[-1]), to))
        return (*place[:-1], to)

    def remove(self, section: str, place: Place) -> None:
        """Remove a part. Raises ValueError."""
        own, files = self.part(section, place), self.files
        if section == "starts":
            raise ValueError(f"{dotted(place)}: a vehicle has a start")
        if section == "goals":
            before = own.get("after")
            files = referring(files, own["name"], before if isinstance(before, str) else None)
        if not SECTIONS[section].of_vehicle or _at(self.values, place) is not None:
            files = files.without(place)
        if SECTIONS[section].of_vehicle and place[-1] in raw_parts(files.values, place[:-1], self.folder):
            files = self._with_part(files, place, None)  # of the vehicle on which this one builds
        self.take(files)

    def part(self, section: str, place: Place) -> dict[str, Any]:
        """Return a part's own values, without defaults. Raises ValueError if there is none at this place."""
        found = self._section(section)
        at = found.below(int(place[1]) if found.of_vehicle and len(place) > 1 and isinstance(place[1], int) else 0)
        depth = len(at) + (found.holds != "one")
        value: Any = None
        is_there = not found.of_vehicle or _at(self.values, at[:2]) is not None
        if is_there and place[: len(at)] == at and len(place) in (depth, len(at)):
            value = self.names(at).get(str(place[-1])) if found.holds == "names" else _at(self.values, place)
            if section == "starts" and not isinstance(value, Mapping):
                value = {} if _at(self.values, place[:-1]) is not None else None
        if not isinstance(value, Mapping):
            raise ValueError(f"{dotted(place)[:80]}: is no part of {section}")
        return dict(value)

    def names(self, place: Place) -> dict[str, Any]:
        """Return a vehicle's parts by name, as written; see raw_parts."""
        if place not in self._raw:
            self._raw[place] = raw_parts(self.values, place, self.folder)
        return self._raw[place]

    def shown(self, section: str, place: Place) -> dict[str, Any]:
        """Return a part's own values as forms show them: tables by rows of numbers."""
        own, model = self._section(section).flat(self.part(section, place)), self._form(section, place)
        return {
            key: flattened(model[key], value) if key in model and model[key]["columns"] else value
            for key, value in own.items()
        }

    def _form(self, section: str, place: Place) -> dict[str, Values]:
        found = self._section(section)
        kind = str(found.flat(self.part(section, place)).get(found.field(found.key), ""))
        fields = forms()[section].get(kind)
        if fields is None:
            raise ValueError(f"{dotted(place)}: of kind {kind[:40]!r}: cannot be edited here")
        return {field["name"]: field for field in fields}

    def _known(self, model: Mapping[str, Any], values: Mapping[str, Any]) -> list[tuple[str, Any]]:
        for key in values:
            if key not in model:
                raise ValueError(f"{str(key)[:40]}: unknown key: must be one of {', '.join(model)}")
        return list(values.items())

    def _with_part(self, files: SceneFiles, place: Place, value: Any) -> SceneFiles:
        """Return the files with a vehicle's part, in a model that builds on the vehicle's own."""
        if place[-1] == "start":
            return files.with_value(place, value)
        values = files.values
        vehicle, key, name = place[:3], place[3], place[-1]
        model = _at(values, vehicle)
        if isinstance(model, str):
            return files.with_value(vehicle, {"builds_on": model, key: {name: value}})
        if isinstance(model.get(key), str):  # a set of sensors in a file of its own
            return files.with_value(place[:-1], {**raw_parts(values, place[:-1], self.folder), name: value})
        return files.with_value(place, value)

    def take(self, files: SceneFiles) -> None:
        """Take changed files as one change, if they are valid. Raises ValueError."""
        if files == self.files:
            return
        before = self._history, self._at
        kept = self._history[max(0, self._at + 1 - STEPS_MAX) : self._at + 1]
        self._history, self._at = [*kept, files], len(kept)
        try:
            self._show()
        except ValueError:
            self._history, self._at = before
            raise
        self.edition += 1

    def _section(self, section: str) -> Section:
        if section not in SECTIONS:
            raise ValueError(f"section = {section[:40]!r}: must be one of {', '.join(SECTIONS)}")
        return SECTIONS[section]

    def _require_vehicle(self, place: Place) -> None:
        if place[0] == "vehicles" and len(place) > 1 and not 0 <= int(place[1]) < len(self.values["vehicles"]):
            raise ValueError(f"vehicle = {place[1]}: there are {len(self.values['vehicles'])}")


def _at(values: Any, place: Place) -> Any:
    for key in place:
        if isinstance(values, dict):
            values = values.get(key)
        elif isinstance(values, list) and isinstance(key, int) and 0 <= key < len(values):
            values = values[key]
        else:
            return None
    return values
