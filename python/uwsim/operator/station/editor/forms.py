"""The editor's forms: the sections of a scenario, their kinds and fields, from the scenario's own JSON Schemas."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

from uwsim.base.texts.yaml_document import Key
from uwsim.channels.guest import Values
from uwsim.exercises.by_seed import PropShift
from uwsim.exercises.exercise import Aid, Event, Exercise
from uwsim.exercises.goal import Goal
from uwsim.exercises.limits import Limit
from uwsim.scenario.schema import schema
from uwsim.scenario.spec.camera import Lamps
from uwsim.scenario.spec.json_schema import ONE_OF, UNIT
from uwsim.scenario.spec.loose_body import LOOSE_KINDS, LooseBody
from uwsim.scenario.spec.prop import PropEntry
from uwsim.scenario.spec.terrain import Stroke
from uwsim.scenario.spec.vehicle_entry import StartPose, VehicleEntry
from uwsim.scenario.spec.water import CurrentSpec, SurfaceSpec
from uwsim.scenario.spec.water_parts import Tide, Wind

Schema = Mapping[str, Any]
NUMBERS = ("number", "integer")
AXES = ("x", "y", "z")
TURNS = ("yaw_deg", "yaw_pitch_roll_deg", "heading_deg")


@dataclass(frozen=True)
class Section:
    """A section of a scenario: its schema, and the place of its parts, below each vehicle if of_vehicle.

    holds: whether the place holds a list of parts, parts by name, or one part. key: of a part's kind. without: fields
    that are sections of their own. inner: the field that holds an obstacle, with the part's kind, name and place: its
    fields are those of the part, as INNER.NAME. title: how it is called, if not by its name.
    """

    schema: str
    place: tuple[Key, ...]
    holds: str
    of_vehicle: bool = False
    key: str = "kind"
    without: tuple[str, ...] = ()
    inner: str = ""
    title: str = ""

    def field(self, name: str) -> str:
        """Return the name of the field that has a part's kind (`key`) or its name (`name`)."""
        return f"{self.inner}.{name}" if self.inner else name

    def flat(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Return a part's values by the names of its fields."""
        own = values.get(self.inner) or {}
        inner = {f"{self.inner}.{name}": value for name, value in own.items()}
        return inner | {name: value for name, value in values.items() if name != self.inner}

    def below(self, vehicle: int) -> tuple[Key, ...]:
        """Return the section's place, of a vehicle if it has one for each."""
        return ("vehicles", vehicle, *self.place) if self.of_vehicle else self.place


OF_EXERCISE = {
    "goals": ("kind", ""), "limits": ("kind", ""), "events": ("", ""), "aids": ("", ""),
    "layout": ("", "Props moved by the seed"),
}  # fmt: skip
"""Sections of the exercise, and the keys of their kinds and the titles."""
SECTIONS = {
    "obstacles": Section("obstacle", ("obstacles",), "list"),
    "props": Section("placed_prop", ("props",), "list"),
    "objects": Section("loose_body", ("objects",), "list", without=("shape",), inner="shape", title="Loose bodies"),
    "currents": Section("current", ("water", "current"), "list"),
    "survey": Section("survey", ("survey",), "one"),
    "terrain": Section("terrain", ("terrain",), "one", key="source", without=("strokes",), title="Bed"),
    "strokes": Section("stroke", ("terrain", "strokes"), "list", title="Drawn on the bed"),
    "water": Section("water", ("water",), "one", without=("surface", "current", "tide")),
    "surface": Section("surface", ("water", "surface"), "one", title="Waves"),
    "tide": Section("tide", ("water", "tide"), "one"),
    "wind": Section("wind", ("wind",), "one"),
    "vehicles": Section("vehicle_entry", ("vehicles",), "list", without=("start",)),
    "optics": Section("optics", ("optics",), "one", title="Light"),
    "cover": Section("cover", ("cover",), "list", title="Cover and growth"),
    "life": Section("life", ("life",), "list", title="Fish"),
    "starts": Section("start", ("start",), "one", of_vehicle=True, title="Start"),
    **{
        name: Section(part, ("model", name), "names", of_vehicle=True)
        for name, part in (
            ("sensors", "sensor"), ("cameras", "camera"), ("lamps", "lamps"), ("imaging_sonars", "imaging_sonar"),
        )
    },
    "exercise": Section("exercise", ("exercise",), "one", without=("scenario", "start", *OF_EXERCISE)),
    "exercise_start": Section("start", ("exercise", "start"), "one", title="Start in the exercise"),
    **{name: Section(name, ("exercise", name), "list", key=key, title=title)
       for name, (key, title) in OF_EXERCISE.items()},
}  # fmt: skip
OTHER_SCHEMAS: Mapping[str, Any] = {
    "surface": SurfaceSpec, "tide": Tide, "wind": Wind, "vehicle_entry": VehicleEntry, "lamps": Lamps,
    "current": CurrentSpec, "start": StartPose, "placed_prop": PropEntry, "stroke": Stroke, "loose_body": LooseBody,
    "exercise": Exercise, "goals": Goal, "limits": Limit, "events": Event, "aids": Aid,
    "layout": PropShift,
}  # fmt: skip


@cache
def forms() -> dict[str, dict[str, list[Values]]]:
    """Return the fields by section and kind ("" if it has no kinds); see wire.editor.FormField."""
    return {name: dict(_kinds(section)) for name, section in SECTIONS.items()}


def described_forms() -> list[Values]:
    """Return the sections as sent to the page; see wire.editor.FormSection."""
    return [
        {
            "name": name, "title": section.title or name.replace("_", " ").capitalize(), "holds": section.holds,
            "of_vehicle": section.of_vehicle,
            "kinds": [{"kind": kind, "fields": fields} for kind, fields in forms()[name].items()],
        }
        for name, section in SECTIONS.items()
    ]  # fmt: skip


def flattened(field: Values, rows: Any) -> Any:
    """Return a table's rows as lists of numbers; rows of another form as they are."""
    if not isinstance(rows, list):
        return rows
    return [_flat_row(field, row) if isinstance(row, Mapping) else row for row in rows]


def _flat_row(field: Values, row: Mapping[str, Any]) -> list[Any]:
    found: list[Any] = []
    for column, by_default in zip(field["columns"], field["by_default"], strict=True):
        name, _, index = column.removesuffix("]").partition("[")
        value = row.get(name)
        found.append(by_default if value is None else value[int(index)] if index else value)
    return found


def unflattened(field: Values, rows: Any) -> Any:
    """Return lists of numbers as a table's rows. Raises ValueError.

    Rows are mappings, without the keys at their default, if the columns are named so.
    """
    if not isinstance(rows, list) or not any("[" in column for column in field["columns"]):
        return rows
    found = []
    for row in rows:
        if not isinstance(row, list) or len(row) != len(field["columns"]):
            raise ValueError(f"{field['name']}: each row must have {len(field['columns'])} values")
        keys: dict[str, Any] = {}
        usual: dict[str, Any] = {}
        for column, value, by_default in zip(field["columns"], row, field["by_default"], strict=True):
            name, _, index = column.partition("[")
            if index:
                keys.setdefault(name, []).append(value)
                usual.setdefault(name, []).append(by_default)
            else:
                keys[name], usual[name] = value, by_default
        found.append({key: value for key, value in keys.items() if value != usual[key]})
    return found


def _kinds(section: Section) -> Iterator[tuple[str, list[Values]]]:
    whole = schema(section.schema, OTHER_SCHEMAS)
    definitions = whole.get("definitions", {})
    for arm in whole.get("oneOf", [whole]):
        model = _resolved(arm, definitions)
        kind = model["properties"].get(section.key, {}).get("const", "")
        fields = [
            _field(name, part, definitions, model)
            for name, part in model["properties"].items()
            if "const" not in part and name not in section.without
        ]
        fields.sort(key=lambda field: (field["name"] != "name", not field["is_required"]))
        if not section.inner:
            yield kind, fields
            continue
        for kind, shape in _kinds(SECTIONS["obstacles"]):
            if kind in LOOSE_KINDS:
                yield kind, [*(field | {"name": section.field(field["name"])} for field in shape), *fields]


def _field(name: str, part: Schema, definitions: Schema, model: Schema) -> Values:
    arms = list(_arms(part, definitions))
    inner = arms[0] if len(arms) == 1 else {}
    items = _resolved(inner.get("items", {}), definitions) if isinstance(inner.get("items"), Mapping) else {}
    kind, width, number = "yaml", 1, inner
    columns: list[tuple[str, float | None]] = []
    if _is_number(inner):
        kind = "number"
    elif _is_number(items) and inner.get("maxItems") == inner.get("minItems"):
        kind, width, number = "number", int(inner["maxItems"]), items
    elif inner.get("type") == "array" and (columns := list(_columns(items, definitions))):
        kind, number = "table", {}
    elif inner.get("type") == "boolean":
        kind = "flag"
    elif "enum" in inner:
        kind = "choice"
    elif inner.get("type") == "string":
        kind = "file" if inner.get("format") in ("path", "mesh") else "text"
    is_line = bool(columns) and columns[0][0] in ("x", "position_m[0]")
    role = "place" if name == "position_m" else "line" if is_line else "mesh" if inner.get("format") == "mesh" else ""
    if name in TURNS and (name != "heading_deg" or "position_m" in model["properties"]):
        role = "turn"
    return {
        "name": name, "meaning": part.get("description", ""), "type": kind, "unit": number.get(UNIT, ""),
        "low": number.get("minimum", number.get("exclusiveMinimum")), "high": number.get("maximum"), "width": width,
        "columns": [column for column, _ in columns],
        "choices": next((list(arm["enum"]) for arm in arms if "enum" in arm), []),
        "by_default": [value for _, value in columns] if columns else part.get("default"),
        "is_required": name in model.get("required", ()), "role": role,
        "start": next(iter(part.get("examples", ())), None), "one_of": part.get(ONE_OF, []),
    }  # fmt: skip


def _arms(part: Schema, definitions: Schema) -> Iterator[Schema]:
    """Yield the schemas of which a field's value fits one, without null."""
    part = _resolved(part, definitions)
    for arm in part.get("anyOf", ()):
        yield from _arms(arm, definitions)
    if "anyOf" not in part and part.get("type") != "null":
        yield part


def _columns(item: Schema, definitions: Schema) -> Iterator[tuple[str, float | None]]:
    """Yield the columns of a table's rows, and their defaults; none if a row has more than numbers."""
    if _is_number(item.get("items", {})) and item.get("maxItems") == item.get("minItems"):
        axes = AXES if item["items"].get(UNIT) == "m" else "123"
        yield from ((axis, None) for axis in axes[: int(item["maxItems"])])
        return
    found: list[tuple[str, float | None]] = []
    for name, part in item.get("properties", {}).items():
        inner = part.get("items", {})
        if _is_number(part):
            found.append((name, part.get("default")))
        elif _is_number(inner) and part.get("maxItems") == part.get("minItems"):
            usual = part.get("default") or [None] * part["maxItems"]
            found += [(f"{name}[{k}]", usual[k]) for k in range(part["maxItems"])]
        else:
            return
    yield from found


def _is_number(part: Any) -> bool:
    found = part.get("type") if isinstance(part, Mapping) else None
    return (found[0] if isinstance(found, list) else found) in NUMBERS


def _resolved(part: Schema, definitions: Schema) -> Schema:
    while "$ref" in part:
        part = definitions[part["$ref"].rpartition("/")[2]]
    return part
