"""SceneFiles: the texts of an edited scene, its scenario's file and an exercise's beside it, and parts in others."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from uwsim.base.texts.yaml_document import Key, YamlDocument, yaml_document
from uwsim.exercises import Exercise
from uwsim.operator.station.editor.yaml_change import block, with_value, without
from uwsim.scenario import Scenario, ScenarioError
from uwsim.scenario.read.assets import shown_name
from uwsim.scenario.read.spec_file import SourceFile, read_yaml, spec_path
from uwsim.scenario.read.validated import validated

EXERCISE = "exercise"
SUFFIX = ".exercise.yaml"
MAX_BYTES = 64_000
"""The largest text that is edited."""
BASES_MAX = 6
"""Files of vehicles that build on each other."""
Place = tuple[Key, ...]


def exercise_file(name: str) -> str:
    """Return the name of the exercise's file beside a scenario's; it is no name of a scenario that is saved."""
    return name.removesuffix(".yaml") + SUFFIX


@dataclass(frozen=True)
class SceneFiles:
    """The texts of a scene. name: of the scenario's file, for messages. exercise: "" without one.

    A place is in the exercise's text if its first key is EXERCISE, else in the scenario's. Raises ScenarioError for a
    text that is too large.
    """

    name: str
    scenario: str
    exercise: str = ""

    def __post_init__(self) -> None:
        for name, text in ((self.name, self.scenario), (self.exercise_name, self.exercise)):
            if (size := len(text.encode())) > MAX_BYTES:
                raise ScenarioError(f"{name}: has {size} bytes: at most {MAX_BYTES} can be edited here")

    @classmethod
    def of(cls, path: Path, scenario: str) -> SceneFiles:
        """Return the text of a scenario's file and that of the exercise beside it. Raises OSError or ValueError."""
        beside = path.with_name(exercise_file(path.name))
        return cls(path.name, scenario, beside.read_text(encoding="utf-8") if beside.is_file() else "")

    @property
    def exercise_name(self) -> str:
        """The name of the exercise's file."""
        return exercise_file(self.name)

    @property
    def shown(self) -> str:
        """Both texts, as documents of one stream."""
        return f"{self.scenario}---\n{self.exercise}" if self.exercise else self.scenario

    @property
    def values(self) -> dict[str, Any]:
        """The content of both. Raises ScenarioError."""
        values = _document(self.scenario, self.name).values
        return {**values, EXERCISE: _document(self.exercise, self.exercise_name).values} if self.exercise else values

    def read(self, folder: Path) -> tuple[Scenario, Exercise | None]:
        """Return the scenario and the exercise, as if they were files in a folder. Raises ScenarioError."""
        document = _document(self.scenario, self.name)
        scenario = validated(Scenario, document.values, document, folder=folder).read_from(SourceFile(document))
        if not self.exercise:
            return scenario, None
        document = _document(self.exercise, self.exercise_name)
        return scenario, validated(Exercise, document.values, document, folder=folder)

    def with_value(self, place: Place, value: Any) -> SceneFiles:
        """Return the texts with this value at its place. Raises ValueError."""
        if place[0] != EXERCISE:
            return replace(self, scenario=with_value(self.scenario, self.name, place, value))
        if len(place) == 1:
            return replace(self, exercise=f"{block(value, 0)}\n")
        return replace(self, exercise=with_value(self.exercise, self.exercise_name, place[1:], value))

    def without(self, place: Place) -> SceneFiles:
        """Return the texts without the value at a place. Raises ValueError."""
        if place[0] != EXERCISE:
            return replace(self, scenario=without(self.scenario, self.name, place))
        own = "" if len(place) == 1 else without(self.exercise, self.exercise_name, place[1:])
        return replace(self, exercise=own)

    def renamed(self, name: str) -> SceneFiles:
        """Return the texts for files of this name, without its suffix. Raises ValueError."""
        found = self.with_value(("name",), name)
        return found.with_value((EXERCISE, "scenario"), f"{name}.yaml") if self.exercise else found


def _document(text: str, name: str) -> YamlDocument:
    try:
        return yaml_document(text, name)
    except ValueError as error:
        raise ScenarioError(str(error)) from None


def raw_parts(values: Mapping[str, Any], place: Place, folder: Path) -> dict[str, Any]:
    """Return a vehicle's parts by name, as written. place: vehicles, its number, model, and the key of the parts."""
    return _parts(values["vehicles"][place[1]]["model"], str(place[3]), folder, BASES_MAX)


def is_inherited(values: Mapping[str, Any], place: Place) -> bool:
    """Return whether a part of a vehicle is written in another file than the scenario's."""
    if place[0] != "vehicles" or len(place) < 5:
        return False
    model = values["vehicles"][place[1]]["model"]
    own = model.get(place[3]) if isinstance(model, Mapping) else None
    return not isinstance(own, Mapping) or place[4] not in own


def _parts(model: Any, key: str, folder: Path, bases: int) -> dict[str, Any]:
    if isinstance(model, str) and bases > 0:
        path = spec_path(model, "vehicles", folder)
        return _parts(read_yaml(path, shown_name(path)).values, key, path.resolve().parent, bases - 1)
    if not isinstance(model, Mapping):
        return {}
    own = model.get(key) or {}
    if isinstance(own, str):
        path = spec_path(own, "sensors", folder)
        return dict(read_yaml(path, shown_name(path)).values.get("sensors") or {})
    base = _parts(model["builds_on"], key, folder, bases) if "builds_on" in model else {}
    return {name: part for name, part in {**base, **own}.items() if part is not None}
