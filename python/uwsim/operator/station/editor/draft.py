"""The scenario being edited: its text, which is valid after every change, and the texts before and after it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import accumulate
from pathlib import Path, PurePath
from typing import Any

from uwsim.base.texts.yaml_document import Key, YamlDocument, dotted, yaml_document
from uwsim.channels.guest import Values
from uwsim.operator.station.editor.forms import SECTIONS, Section, flattened, forms, start_values, unflattened
from uwsim.operator.station.editor.ground_plan import GroundPlan
from uwsim.operator.station.editor.vehicle_parts import is_inherited, raw_parts
from uwsim.operator.station.editor.yaml_change import flow, with_value, without
from uwsim.scenario import Scenario, ScenarioError
from uwsim.scenario.read.source_file import SourceFile
from uwsim.scenario.read.validated import validated

MAX_BYTES = 64_000
"""The largest text that is edited: each change reads it twice, which takes 14 to 30 ms per 1000 bytes."""
STEPS_MAX = 200
TEXT_MAX = 4000
NAMED = ("obstacles", "objects", "props", "cover", "life", "vehicles")
"""Sections whose parts have names, which are unique among them."""
DEPTH_MAX = 20
"""Brackets within brackets in a value: the parser's time rises with their square, to 7 s for TEXT_MAX of them."""
Place = tuple[Key, ...]


class Draft:
    """A scenario's text and its history. name: of the file, for messages. folder: of the files that it names.

    Every change is checked as a file would be, and raises ValueError, changing nothing, if the scenario would be wrong.
    scenario, values, plan: of the present text; they must not be modified. edition: increases with its every change.
    """

    def __init__(self, text: str, name: str, folder: Path) -> None:
        self.name, self.folder, self.edition = name, folder, 0
        self._texts = [_limited(text, name)]
        self._at = 0
        self.plan = GroundPlan()
        self._show(self.checked(text))

    @property
    def text(self) -> str:
        """The YAML text as it is now."""
        return self._texts[self._at]

    @property
    def can_undo(self) -> bool:
        """True if there is a change to undo."""
        return self._at > 0

    @property
    def can_redo(self) -> bool:
        """True if an undone change can be repeated."""
        return self._at + 1 < len(self._texts)

    def _show(self, scenario: Scenario) -> None:
        """Hold what belongs to the present text. Raises ScenarioError if an obstacle cannot be built."""
        self.plan.draw(scenario)
        self.scenario, self.values = scenario, self._document(self.text).values
        self._raw: dict[Place, dict[str, Any]] = {}

    def checked(self, text: str, folder: Path | None = None) -> Scenario:
        """Return the scenario of a text, as if it were in a file in a folder. Raises ScenarioError."""
        document, place = self._document(text), folder or self.folder
        return validated(Scenario, document.values, document, folder=place).read_from(SourceFile(document))

    def undo(self, steps: int = 1) -> None:
        """Undo changes, or repeat undone ones if negative. Raises ValueError if there are none."""
        if not 0 <= self._at - steps < len(self._texts):
            raise ValueError("there is nothing to undo" if steps > 0 else "there is nothing to redo")
        self._at -= steps
        self._show(self.checked(self.text))
        self.edition += 1

    def rename(self, name: str) -> None:
        """Change the scenario's name. Raises ValueError."""
        self._take(with_value(self.text, self.name, ("name",), name))

    def replace(self, text: str) -> None:
        """Replace the whole text, as one change. Raises ValueError."""
        self._take(text)

    def set(self, section: str, place: Place, values: Mapping[str, Any]) -> None:
        """Set fields of a part; None removes a field. Raises ValueError."""
        own, model = self.part(section, place), self._form(section, place)
        text = self.text
        if section == "starts" or is_inherited(self.values, place):  # written as a whole for the first time
            whole = {**own, **{key: _given(model[key], value) for key, value in self._known(model, values)}}
            whole = {key: value for key, value in whole.items() if value is not None}
            self._take(self._with_part(text, place, whole))
            return
        for key, value in self._known(model, values):
            at = (*place, *key.split("."))
            if value is not None:
                text = with_value(text, self.name, at, _given(model[key], value))
            elif key in SECTIONS[section].flat(own):
                text = without(text, self.name, at)
        self._take(text)

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
        given = {key: _given(model[key], value) for key, value in self._known(model, own or {})}
        values = start_values(section, kind, (x, y)) | given
        above = found.below(vehicle)
        self._require_vehicle(above)
        if found.holds == "names":
            name = self._free(kind or section.removesuffix("s"), self.names(above))
            place: Place = (*above, name)
            self._take(self._with_part(self.text, place, values))
            return place
        if found.holds == "one":
            present = _at(self.values, above)
            if present is not None and (not kind or present.get(found.key) == kind):
                raise ValueError(f"{dotted(above)}: exists already")
            values |= {key: present[key] for key in found.without if present and key in present}
            self._take(with_value(self.text, self.name, above, values))  # in place of one of another kind
            return above
        items = _at(self.values, above) or []
        text = self.text
        if isinstance(items, Mapping):  # one current, written without a list
            text, items = with_value(without(text, self.name, above), self.name, above, [dict(items)]), [items]
        if section in NAMED:
            taken = [
                SECTIONS[key].flat(each).get(SECTIONS[key].field("name"))
                for key in NAMED
                for each in self.values.get(key, [])
            ]
            taken += [body.name for body in self.scenario.objects]
            named = values.get(found.inner, values)
            first = {"kind": kind} if kind else {}
            named = {**first, "name": self._free(kind or str(values["model"]), taken), **named}
            values = values | {found.inner: named} if found.inner else named
        place = (*above, len(items))
        self._take(with_value(text, self.name, place, values))
        return place

    def remove(self, section: str, place: Place) -> None:
        """Remove a part. Raises ValueError."""
        self.part(section, place)
        if section == "starts":
            raise ValueError(f"{dotted(place)}: a vehicle has a start")
        if not SECTIONS[section].of_vehicle:
            self._take(without(self.text, self.name, place))
            return
        text = self.text
        if _at(self.values, place) is not None:
            text = without(text, self.name, place)
        base = yaml_document(text, self.name).values
        if place[-1] in raw_parts(base, place[:-1], self.folder):  # of the vehicle on which this one builds
            text = self._with_part(text, place, None)
        self._take(text)

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

    def _with_part(self, text: str, place: Place, value: Any) -> str:
        """Return a text with a vehicle's part, in a model that builds on the vehicle's own."""
        if place[-1] == "start":
            return with_value(text, self.name, place, value)
        values = yaml_document(text, self.name).values
        vehicle, key, name = place[:3], place[3], place[-1]
        model = _at(values, vehicle)
        if isinstance(model, str):
            return with_value(text, self.name, vehicle, {"builds_on": model, key: {name: value}})
        if isinstance(model.get(key), str):  # a set of sensors in a file of its own
            return with_value(text, self.name, place[:-1], {**raw_parts(values, place[:-1], self.folder), name: value})
        return with_value(text, self.name, place, value)

    def _take(self, text: str) -> None:
        """Take a changed text, if it is valid. Raises ValueError."""
        scenario = self.checked(_limited(text, self.name))
        if text == self.text:
            return
        self.plan.draw(scenario)
        kept = self._texts[max(0, self._at + 1 - STEPS_MAX) : self._at + 1]
        self._texts, self._at = [*kept, text], len(kept)
        self._show(scenario)
        self.edition += 1

    def _section(self, section: str) -> Section:
        if section not in SECTIONS:
            raise ValueError(f"section = {section[:40]!r}: must be one of {', '.join(SECTIONS)}")
        return SECTIONS[section]

    def _require_vehicle(self, place: Place) -> None:
        if place[0] == "vehicles" and len(place) > 1 and not 0 <= int(place[1]) < len(self.values["vehicles"]):
            raise ValueError(f"vehicle = {place[1]}: there are {len(self.values['vehicles'])}")

    def _free(self, base: str, taken: Any) -> str:
        names = (base if k == 1 else f"{base}_{k}" for k in range(1, len(taken) + 3))
        return next(name for name in names if name not in taken)

    def _document(self, text: str) -> YamlDocument:
        try:
            return yaml_document(text, self.name)
        except ValueError as error:
            raise ScenarioError(str(error)) from None


def _at(values: Any, place: Place) -> Any:
    for key in place:
        if isinstance(values, dict):
            values = values.get(key)
        elif isinstance(values, list) and isinstance(key, int) and 0 <= key < len(values):
            values = values[key]
        else:
            return None
    return values


def _limited(text: str, name: str) -> str:
    size = len(text.encode())
    if size > MAX_BYTES:
        raise ScenarioError(f"{name}: has {size} bytes: at most {MAX_BYTES} can be edited here")
    return text


def _given(field: Mapping[str, Any], value: Any) -> Any:
    """Return a value from a form as it is written into the file. Raises ValueError."""
    if field["type"] == "yaml" and isinstance(value, str):
        if len(value) > TEXT_MAX:
            raise ValueError(f"{field['name']}: has {len(value)} characters: at most {TEXT_MAX}")
        if _depth(value) > DEPTH_MAX:
            raise ValueError(f"{field['name']}: is nested more than {DEPTH_MAX} deep")
        value = yaml_document(f"value: {value}", field["name"]).values.get("value")
        if len(flow(value)) > TEXT_MAX:
            raise ValueError(f"{field['name']}: its aliases written out, must have at most {TEXT_MAX} characters")
    _require_near(field["name"], value)
    return unflattened(dict(field), value) if field["columns"] else value


def _depth(text: str) -> int:
    """Return how deeply brackets are nested in a text."""
    steps = ((each in "[{") - (each in "]}") for each in text)
    return max(accumulate(steps, lambda depth, step: max(depth + step, 0), initial=0))


def _require_near(name: str, value: Any) -> None:
    """Raise ValueError for a file elsewhere, since the page's user may not be allowed to read this machine's files."""
    if isinstance(value, str):
        path = PurePath(value)
        if path.is_absolute() or ".." in path.parts or value.startswith("~"):
            raise ValueError(f"{name} = {value[:80]!r}: must be a packaged file, or one below the scenario's folder")
    for item in value.values() if isinstance(value, Mapping) else value if isinstance(value, list) else ():
        _require_near(name, item)
