"""For errors in a single key, the JSON Schemas accept and refuse the same files as the program."""

import json
from functools import cache
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import TypeAdapter, ValidationError

from uwsim import _core
from uwsim.scenario.read.assets import assets_folder
from uwsim.scenario.read.spec_file import read_yaml
from uwsim.scenario.schema import FILES, PARTS, schema, schema_file
from uwsim.scenario.spec.imaging_sonar import imaging_kinds
from uwsim.scenario.spec.sensor_kind import sensor_kinds

FOLDERS = {"scenario": "scenarios", "vehicle": "vehicles", "thruster": "thrusters", "sonar": "sonars",
           "sensors": "sensors", "modem": "modems", "battery": "batteries", "prop": "props"}  # fmt: skip


@cache
def validator(part: str) -> jsonschema.Draft7Validator:
    jsonschema.Draft7Validator.check_schema(schema(part))
    return jsonschema.Draft7Validator(schema(part))


@cache
def values(path: Path) -> Any:
    return read_yaml(path, path.name).values


@pytest.mark.parametrize("part", FILES)
def test_every_packaged_file_is_accepted(part: str) -> None:
    for path in sorted((assets_folder() / FOLDERS[part]).glob("*.yaml")):
        assert [error.message for error in validator(part).iter_errors(values(path))] == [], path


@pytest.mark.parametrize("part", FILES)
def test_the_packaged_schema_is_that_of_the_models(part: str) -> None:
    assert json.loads(schema_file(part).read_text()) == json.loads(json.dumps(schema(part))), "python tools/schema.py"


@pytest.mark.parametrize("part", PARTS)
def test_every_key_is_described(part: str) -> None:
    def visit(node: Any, where: str) -> None:
        for key, below in node.get("properties", {}).items():
            assert below.get("description") or key == "kind", f"{where}.{key}"
        for name in ("definitions", "oneOf"):
            items = node.get(name, ())
            for key in items if isinstance(items, dict) else range(len(items)):
                visit(items[key], f"{where}.{key}")

    visit(schema(part), part)


Bounded = tuple[str, str, str, float, float]

WHOLE: dict[str, dict[str, Any]] = {
    "survey": {"area_m": [[0, 0], [9, 0], [9, 9]], "altitude_m": 5, "line_spacing_m": 5, "speed_m_s": 1},
    "failsafe": {"silence_s": 10},
    "camera": {"position_m": [0, 0, 0]},
    "optics": {},
    "control": {},
    "water": {},
    "sensor": {"kind": "dvl"},
    "imaging_sonar": {"kind": "forward_looking"},
}


def bounded() -> list[Bounded]:
    cases = []
    for part, whole in WHOLE.items():
        properties = schema(part).get("properties") or next(
            arm["properties"] for arm in schema(part)["oneOf"] if arm["properties"]["kind"]["const"] == whole["kind"]
        )
        for key, below in properties.items():
            if "minimum" in below and "maximum" in below:
                cases.append((part, key, below["type"], below["minimum"], below["maximum"]))
    return cases


@given(case=st.sampled_from(bounded()), at=st.floats(-0.5, 1.5))
def test_a_number_is_refused_by_the_schema_exactly_if_it_is_by_the_program(case: Bounded, at: float) -> None:
    part, key, kind, low, high = case
    value = low + at * (high - low)
    value = round(value) if kind == "integer" else value
    file = {**WHOLE[part], key: value}
    refused = bool(list(validator(part).iter_errors(file)))
    try:
        TypeAdapter(PARTS[part]).validate_python(file)
    except ValidationError as error:
        assert refused or not any(key in e["loc"] for e in error.errors()), (file, error)  # or a rule on several keys
    else:
        assert not refused, file


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("bed_depth_m: 5", "bed_dept_m: 5"),
        ("spacing_m: 0.5", "spacing_m: half"),
        ("size_m: [20, 20]", "size_m: [20]"),
        ("source: noise", "source: nois"),
        ("kind: box", "kind: bx"),
        ("model: 2", "model: 5"),
        ("start: station", "start: dock"),
        ("name: pool", "name: a pool"),
        ("mission_time_s: 600", "mission_time_s: -1"),
    ],
)
def test_what_the_program_refuses_editors_refuse(old: str, new: str, tmp_path: Path) -> None:
    text = (assets_folder() / "scenarios" / "pool.yaml").read_text()
    assert old in text
    (tmp_path / "pool.yaml").write_text(text.replace(old, new, 1))
    assert list(validator("scenario").iter_errors(values(tmp_path / "pool.yaml")))


def test_an_unknown_part_is_named() -> None:
    with pytest.raises(ValueError, match=r"part = 'sonr': must be one of .*did you mean 'sonar'\?"):
        schema("sonr")


def test_the_cores_kinds_of_sensors_and_sonars_are_registered() -> None:
    assert sensor_kinds() == [*_core.sensor_kinds(), "bearing"], "pyproject.toml, uwsim.kinds.sensor"
    assert imaging_kinds() == list(_core.imaging_kinds()), "pyproject.toml, uwsim.kinds.imaging_sonar"


def test_no_schema_has_two_names_for_a_field_of_view_a_frequency_or_a_range() -> None:
    """Those of all instruments: the alarm `warnings.range_m` is none."""
    found = {key for part in PARTS for key in _keys(schema(part), exclude="WarningLimits")}
    assert {"field_of_view_deg", "frequency_hz", "range_max_m"} <= found
    of_instruments = {"fov", "field_of_view", "frequency"}
    assert {key for key in found if any(part in key for part in of_instruments) and key != "frequencies"} == {
        "field_of_view_deg", "frequency_hz",
    }  # fmt: skip
    assert {key for key in found if key.startswith("range_m")} == {"range_max_m", "range_min_m"}


def _keys(part: Any, exclude: str) -> set[str]:
    if isinstance(part, list):
        return {key for item in part for key in _keys(item, exclude)}
    if not isinstance(part, dict):
        return set()
    own = set(part["properties"]) if isinstance(part.get("properties"), dict) else set()
    return own.union(*(_keys(item, exclude) for name, item in part.items() if name != exclude))
