"""A vehicle's file with identified values: each new line's comment states the log and the interval."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from uwsim.base.atomic_file import write_atomically
from uwsim.base.texts.yaml_document import YamlDocument, yaml_document
from uwsim.base.texts.yaml_edit import Place, with_values
from uwsim.evidence.identification.solution import Identified, Value
from uwsim.scenario.read.validated import validated
from uwsim.scenario.spec.vehicle import VehicleModel

BUOYANCY = "centre_of_buoyancy_m"


def write_calibrated(found: Identified, log: str, path: Path) -> None:
    """Write the file of the vehicle that was identified, with the values that the log determines, to another path.

    Everything else stays as it is, except that files which the new one would not find are named by their whole path.
    Raises OSError, and ValueError if the vehicle was not read from a file or a value lies outside its range.
    """
    document = found.model.source_file.document
    if document is None:
        raise ValueError(f"vehicle '{found.model.name}': was not read from a file")
    text = calibrated_text(found, document, log, path.parent)
    new = yaml_document(text, str(path))
    validated(VehicleModel, new.values, new, folder=path.resolve().parent)
    write_atomically(path, text.encode())


def calibrated_text(found: Identified, document: YamlDocument, log: str, folder: Path) -> str:
    """Return the text of the new file. folder: where it will be."""
    intervals = {
        place: f"{_label(value, place)} {value.low:.4g} to {value.high:.4g} {value.unit}".strip()
        for value in found.values.values()
        for place in value.places
        if value.is_determined
    }

    def remark(places: list[Place], old: str, keeps_others: bool) -> str:
        new = ", ".join(intervals[place] for place in places if place in intervals)
        text = f"measured in {log}, 95 %: {new}" if new else "scaled with the diagonal"
        return f"{text}; {'the rest' if keeps_others else 'before'}: {old}" if old else text

    numbers = {place: f"{number:.4g}" for place, number in found.numbers.items()}
    centre = [place for place in numbers if place[0] == BUOYANCY]
    if centre and BUOYANCY not in document.values:
        _write_whole(found, centre, numbers, intervals)
    text = with_values(document.text, document.name, numbers, remark)
    return with_values(text, document.name, dict(_moved(document.values, Path(document.name).parent, folder)))


def _write_whole(found: Identified, places: list[Place], numbers: dict[Place, str], said: dict[Place, str]) -> None:
    """Replace the numbers of a centre of buoyancy that the file does not state by all three, under its key."""
    for place in places:
        del numbers[place]
    values = found.model.centre_of_buoyancy_m
    assert values is not None
    numbers[BUOYANCY,] = f"[{', '.join(f'{value:.4g}' for value in values)}]"
    said[BUOYANCY,] = ", ".join(said[place] for place in places if place in said)


def _label(value: Value, place: Place) -> str:
    """Return the part of a line that an interval concerns: an axis, or the key of a thruster."""
    return value.name.partition(".")[2] if isinstance(place[-1], int) else str(place[-1]) if len(place) > 1 else ""


def _moved(part: Any, source: Path, folder: Path, place: Place = ()) -> Iterator[tuple[Place, str]]:
    """Yield the whole paths of the files that are named relative to `source`, unless the new file is there, too."""
    if source.resolve() == folder.resolve():
        return
    if isinstance(part, str) and not Path(part).is_absolute() and (source / part).is_file():
        yield place, json.dumps(str((source / part).resolve()), ensure_ascii=False)
    elif isinstance(part, Mapping | list):
        for key, inner in part.items() if isinstance(part, Mapping) else enumerate(part):
            yield from _moved(inner, source, folder, (*place, key))
