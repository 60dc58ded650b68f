"""JSON Schemas of scenario files and their parts, generated from the models for editors and other programs.

They contain keys, types, ranges and choices. Rules that combine keys or need a file are enforced only by `check`.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter
from pydantic.json_schema import GenerateJsonSchema, JsonSchemaValue
from pydantic_core import core_schema

from uwsim.base.named import did_you_mean
from uwsim.scenario.read.assets import assets_folder
from uwsim.scenario.spec.actuator import Control, ThrusterType
from uwsim.scenario.spec.battery import BatteryType, Failsafe
from uwsim.scenario.spec.camera import CameraMount
from uwsim.scenario.spec.cover import CoverSpec, LifeSpec
from uwsim.scenario.spec.fault import FaultSpec
from uwsim.scenario.spec.imaging_sonar import ImagingMount
from uwsim.scenario.spec.link import LinkSetup, ModemModel
from uwsim.scenario.spec.obstacle import ObstacleSpec
from uwsim.scenario.spec.optics import Optics
from uwsim.scenario.spec.prop import Prop
from uwsim.scenario.spec.scenario import Scenario
from uwsim.scenario.spec.sensor import SensorMount, SensorSet
from uwsim.scenario.spec.settings import Station
from uwsim.scenario.spec.sonar import SonarModel
from uwsim.scenario.spec.survey import Survey
from uwsim.scenario.spec.terrain import TerrainSpec
from uwsim.scenario.spec.vehicle import VehicleModel
from uwsim.scenario.spec.water import Water

FILES: dict[str, Any] = {
    "scenario": Scenario,
    "vehicle": VehicleModel,
    "thruster": ThrusterType,
    "sonar": SonarModel,
    "sensors": SensorSet,
    "modem": ModemModel,
    "battery": BatteryType,
    "prop": Prop,
}
"""The kinds of files, keyed by the name of their schema."""

PARTS: dict[str, Any] = {
    **FILES,
    "sensor": SensorMount,
    "imaging_sonar": ImagingMount,
    "camera": CameraMount,
    "control": Control,
    "cover": CoverSpec,
    "life": LifeSpec,
    "failsafe": Failsafe,
    "fault": FaultSpec,
    "link": LinkSetup,
    "obstacle": ObstacleSpec,
    "optics": Optics,
    "station": Station,
    "survey": Survey,
    "terrain": TerrainSpec,
    "water": Water,
}


def schema(part: str = "scenario", more: Mapping[str, Any] | None = None) -> JsonSchemaValue:
    """Return the JSON Schema (draft 7) of a part, one of PARTS or `more`. Raises ValueError for an unknown part."""
    parts = {**PARTS, **(more or {})}
    if part not in parts:
        raise ValueError(f"part = '{part}': must be one of {', '.join(parts)}{did_you_mean(part, parts)}")
    made = TypeAdapter(parts[part]).json_schema(schema_generator=_Draft7, ref_template="#/definitions/{model}")
    definitions = made.pop("$defs", {})
    return {
        "$schema": _Draft7.schema_dialect,
        "title": f"uwsim {part}",
        **{key: value for key, value in made.items() if key != "title"},
        **({"definitions": definitions} if definitions else {}),
    }


def schema_file(part: str) -> Path:
    """Return the path of a packaged schema, for use in an editor. part: one of FILES."""
    return assets_folder() / "schema" / f"{part}.json"


class _Draft7(GenerateJsonSchema):
    """pydantic's schema generator, modified to use draft 7's keywords instead of those of 2020-12."""

    schema_dialect = "http://json-schema.org/draft-07/schema#"

    def tuple_schema(self, schema: core_schema.TupleSchema) -> JsonSchemaValue:
        """Return fixed-length lists with one schema per position in `items`, or a single one if all are equal."""
        made = super().tuple_schema(schema)
        places = made.pop("prefixItems", None)
        if places is None:
            return made
        if all(place == places[0] for place in places):
            return made | {"items": places[0]}
        return made | {"items": places, "additionalItems": False}

    def dict_schema(self, schema: core_schema.DictSchema) -> JsonSchemaValue:
        """Return mappings by name that reject keys that are not valid names."""
        made = super().dict_schema(schema)
        return made | {"additionalProperties": False} if "patternProperties" in made else made

    def tagged_union_schema(self, schema: core_schema.TaggedUnionSchema) -> JsonSchemaValue:
        """Return a union without OpenAPI's `discriminator`, which is not part of JSON Schema."""
        made = super().tagged_union_schema(schema)
        made.pop("discriminator", None)
        return made
