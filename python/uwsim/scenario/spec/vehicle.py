"""A vehicle model, as read from its YAML file. Body frame: x forward, y left, z up; its origin is that of the mesh."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextvars import ContextVar
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import (
    Field,
    GetJsonSchemaHandler,
    ModelWrapValidatorHandler,
    PrivateAttr,
    ValidationError,
    ValidationInfo,
    model_validator,
)
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, ErrorDetails, InitErrorDetails, PydanticCustomError

from uwsim.base.named import did_you_mean
from uwsim.scenario.read.spec_file import SourceFile, read_spec, spec_path
from uwsim.scenario.spec.actuator import Control, FinMount, ThrusterMount
from uwsim.scenario.spec.arm import Link, links_in_order
from uwsim.scenario.spec.battery import Failsafe
from uwsim.scenario.spec.camera import CameraMounts, LampSwitches
from uwsim.scenario.spec.fields import AssetFile, AssetName, Factor, InRange, Model, Name, Point3, broken
from uwsim.scenario.spec.imaging_sonar import ImagingMount
from uwsim.scenario.spec.material import Material, MaterialSpec
from uwsim.scenario.spec.pinger import HydrophoneArray
from uwsim.scenario.spec.sensor import Sensors
from uwsim.scenario.spec.water_parts import Windage

DENSITIES_KG_M3 = (100.0, 10_000.0)
"""Plausible densities of whole vehicles: from an empty pressure hull to a solid lump of metal."""
VOLUMES_M3 = (1e-6, 1e5)
"""Plausible volumes of hulls: from a thimble to twice the largest submarine."""

MASSES = ("mass_kg", "density_kg_m3", "buoyancy")
NEEDED = ("name", "mesh", "centre_of_mass_m")
PARTS = ("thrusters", "fins", "sensors", "cameras", "lamps", "imaging_sonars", "hydrophones")
"""The fields that hold parts by name."""

MOST_BASES = 5
"""Vehicles, one built on another, below the one that is read: a mistake in the last is looked for twice in each."""

VehicleName = Annotated[str, AssetName("vehicles")]

Force = Annotated[float, InRange(0, 1e6, "N")]
Torque = Annotated[float, InRange(0, 1e6, "N m")]
AlongMass = Annotated[float, InRange(0, 1e6, "kg")]
AboutMass = Annotated[float, InRange(0, 1e9, "kg m2")]
AlongLinear = Annotated[float, InRange(0, 1e6, "N s/m")]
AboutLinear = Annotated[float, InRange(0, 1e9, "N m s/rad")]
AlongQuadratic = Annotated[float, InRange(0, 1e6, "N s2/m2")]
AboutQuadratic = Annotated[float, InRange(0, 1e9, "N m s2/rad2")]
Inertia = Annotated[float, InRange(1e-6, 1e9, "kg m2")]
Entry = Annotated[float, InRange(-1e9, 1e9)]
Row = tuple[Entry, Entry, Entry, Entry, Entry, Entry]
Matrix = tuple[Row, Row, Row, Row, Row, Row]


class SonarMount(Model):
    """The mount of the multibeam's head, which faces forward and tilts about the body's y.

    position_m: position in the body frame.
    """

    position_m: Point3


class Trim(Model):
    """Weights that an operator adds or removes to adjust a vehicle's buoyancy in the scenario's water.

    They are a point mass, before ballast_kg and leaks, that displaces no water; negative if weights are removed.
    net_buoyancy_n: buoyancy of the whole hull, in surface water, minus the weight; positive: it rises. position_m:
    position of the weights in the body frame; by default at the centre of mass.
    """

    net_buoyancy_n: Annotated[float, InRange(-1e5, 1e5, "N")]
    position_m: Point3 | None = None


class VehicleModel(Model, defer_build=False):  # a part of Scenario that is also read alone
    """A rigid vehicle, driven by thrusters and fins, or by forces and torques along and about its axes.

    Six-vectors are surge, sway, heave, roll, pitch, yaw; all components are magnitudes and not negative. A full matrix
    about the origin, such as added_mass_matrix, may be given by rows instead. builds_on: another vehicle, a packaged
    name or a file, whose values apply where this one gives none; parts by name are added to its parts, or replace those
    of the same name, and `null` removes a value or a part. mesh: the hull, closed and winding outward. Buoyancy acts on
    its triangles, and collisions use it. It also determines the volume, and the inertia (as a solid of uniform density)
    if inertia_kg_m2 is omitted. mesh_scale: metres per unit of the file. mesh_up: the file's axis that points up; by
    default y for glTF, the declared axis for FBX, z for all others. mesh_forward: the direction of the bow, seen with z
    up; by default x. mass_kg: mass of the vehicle, without ballast and water inside, which standard gravity, 9.80665
    m/s2, pulls down; specify exactly one of this, density_kg_m3 and buoyancy. density_kg_m3: instead, mean density over
    the hull's volume. buoyancy: instead, `neutral`: the mass of the water that the whole hull displaces in the
    scenario's water. centre_of_mass_m: position without ballast, in the hull's bounding box. ballast_kg,
    ballast_position_m: an additional point mass: it adds to mass and inertia and moves the centre of mass, but
    displaces no water. compressibility_1_pa: relative loss of the hull's volume per pascal, 0 for a rigid hull; by
    default it is as compressible as the water around it (assumed). trim: weights for the scenario's water; by default
    the mass and the water determine whether the vehicle floats or sinks. volume_m3, centre_of_buoyancy_m: published
    values, to which the mesh is scaled and moved; it must be close to them. collision: collision shape: the convex
    hull, the bounding box, or convex pieces. collision_pieces: the file with the pieces, which `uwsim vehicle
    decompose` makes from the mesh. linear_damping, quadratic_damping: force or torque that opposes v and v|v|.
    added_mass: mass of the water that moves with the hull; zero by default. coefficients: `afloat` for added mass and
    damping of the hull as it floats without trim and ballast, by default those of the whole hull under water; either
    way they fall with the volume in the water. munk_share: how much of the Munk moment, which added_mass implies in an
    ideal fluid, is left where the flow separates: 1 for a streamlined hull, near 0 for a sharp-edged open frame.
    crossflow_length_m: length along x over which the quadratic drag of sway and heave is spread evenly in strips, each
    with its own speed, so that they couple with yaw and pitch; pure motion along or about an axis keeps its published
    drag, so the strips are shortened where their drag in yaw or pitch would exceed it. 0, the default: the drag acts at
    the origin. inertia_kg_m2: principal moments about the centre of mass along the body axes. max_force_n,
    max_torque_nm: force and torque at full effort along and about x, y, z, for a vehicle without thrusters. control:
    gains and limits of a Controller's loops. thrusters, fins, sensors, cameras, lamps, imaging_sonars, hydrophones:
    parts by name. sonar: the multibeam's mount, if it has one. friction: Coulomb's coefficient; for two bodies in
    contact, the geometric mean applies. restitution: the fraction of the approach speed that is kept; for two
    bodies in contact, the larger value applies. material: material of the hull. failsafe: the reaction to loss of
    contact or to a fault. arm: links by name, whose weight, buoyancy and water are beside the vehicle's own; by
    default none. windage: what it offers the wind; by default nothing.
    """

    builds_on: VehicleName | None = None
    name: Name
    description: str = ""
    mesh: AssetFile
    mesh_scale: Factor = 1.0
    mesh_up: Literal["x", "-x", "y", "-y", "z", "-z"] | None = None
    mesh_forward: Literal["x", "-x", "y", "-y"] | None = None
    collision: Literal["hull", "box", "pieces"] = "hull"
    collision_pieces: AssetFile | None = None

    mass_kg: Annotated[float, InRange(0.01, 1e6, "kg")] | None = None
    density_kg_m3: Annotated[float, InRange(*DENSITIES_KG_M3, "kg/m3")] | None = None
    buoyancy: Literal["neutral"] | None = None
    volume_m3: Annotated[float, InRange(*VOLUMES_M3, "m3")] | None = None
    centre_of_buoyancy_m: Point3 | None = None
    centre_of_mass_m: Point3
    inertia_kg_m2: tuple[Inertia, Inertia, Inertia] | None = None
    trim: Trim | None = None
    compressibility_1_pa: Annotated[float, InRange(0, 1e-7, "1/Pa")] | None = None
    ballast_kg: Annotated[float, InRange(0, 1e6, "kg")] = 0.0
    ballast_position_m: Point3 = (0.0, 0.0, 0.0)

    added_mass: tuple[AlongMass, AlongMass, AlongMass, AboutMass, AboutMass, AboutMass] | None = None
    added_mass_matrix: Matrix | None = None
    linear_damping: tuple[AlongLinear, AlongLinear, AlongLinear, AboutLinear, AboutLinear, AboutLinear] | None = None
    linear_damping_matrix: Matrix | None = None
    quadratic_damping: (
        tuple[AlongQuadratic, AlongQuadratic, AlongQuadratic, AboutQuadratic, AboutQuadratic, AboutQuadratic] | None
    ) = None
    quadratic_damping_matrix: Matrix | None = None
    coefficients: Literal["afloat"] | None = None
    munk_share: Annotated[float, InRange(0, 1)] = 1.0
    crossflow_length_m: Annotated[float, InRange(0, 500, "m")] = 0.0

    max_force_n: tuple[Force, Force, Force] | None = None
    max_torque_nm: tuple[Torque, Torque, Torque] | None = None
    thrusters: dict[Name, ThrusterMount] = Field(default_factory=dict)
    fins: dict[Name, FinMount] = Field(default_factory=dict)

    friction: Annotated[float, InRange(0, 2)] = 0.5
    restitution: Annotated[float, InRange(0, 1)] = 0.1

    sonar: SonarMount | None = None
    sensors: Sensors = Field(default_factory=dict)
    cameras: CameraMounts = Field(default_factory=dict)
    lamps: LampSwitches = Field(default_factory=dict)
    material: MaterialSpec = Material.model_construct(kind="paint")
    control: Control = Control.model_construct()
    imaging_sonars: dict[Name, ImagingMount] = Field(default_factory=dict)
    hydrophones: Annotated[dict[Name, HydrophoneArray], Field(max_length=16)] = Field(default_factory=dict)
    failsafe: Failsafe | None = None
    arm: dict[Name, Link] | None = None
    windage: Windage | None = None

    _source_file: SourceFile = PrivateAttr(default=SourceFile())

    @classmethod
    def __get_pydantic_json_schema__(cls, core: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        schema = super().__get_pydantic_json_schema__(core, handler)
        own = handler.resolve_ref_schema(schema)
        needed = own.pop("required")
        own["anyOf"] = [{"required": needed}, {"required": ["builds_on"]}]
        for key, field in own["properties"].items():  # `null` removes a value or a part of the base
            if key not in needed:
                own["properties"][key] = _or_null(field)
        for key in PARTS:
            for arm in own["properties"][key]["anyOf"]:
                for name, part in arm.get("patternProperties", {}).items():
                    arm["patternProperties"][name] = _or_null(part)
        return schema

    @model_validator(mode="wrap")
    @classmethod
    def _names_all_absent_keys(
        cls, values: Any, handler: ModelWrapValidatorHandler[VehicleModel], info: ValidationInfo
    ) -> VehicleModel:
        """Where nothing but keys is missing, name all of them: pydantic would stop at the first broken rule."""
        values = _on_its_base(values, (info.context or {}).get("folder"))
        try:
            return handler(values)
        except ValidationError as error:
            if not isinstance(values, Mapping) or not all(_is_absence(each) for each in error.errors()):
                raise
            absent = [*_absent(values)]
            raise ValidationError.from_exception_data(error.title, absent) if absent else error from None

    @model_validator(mode="after")
    def _has_collision_pieces_if_needed(self) -> VehicleModel:
        if self.collision == "pieces" and self.collision_pieces is None:
            raise broken("missing: make it with `uwsim vehicle decompose` from the mesh", at=("collision_pieces",))
        if self.collision != "pieces" and self.collision_pieces is not None:
            raise broken("is only for `collision: pieces`", at=("collision_pieces",))
        return self

    @model_validator(mode="after")
    def _has_one_mass(self) -> VehicleModel:
        given = sum(getattr(self, key) is not None for key in MASSES)
        if given != 1:
            raise _not_one_mass(given)
        if self.inertia_kg_m2 is not None:
            smallest, middle, largest = sorted(self.inertia_kg_m2)
            if largest > smallest + middle:
                rule = "the largest must not exceed the sum of the two others, as for any rigid body"
                raise broken(rule, at=("inertia_kg_m2",), value=list(self.inertia_kg_m2), unit="kg m2")
        return self

    @model_validator(mode="after")
    def _has_each_coefficient_once(self) -> VehicleModel:
        for key, is_needed in (("added_mass", False), ("linear_damping", True), ("quadratic_damping", True)):
            diagonal, matrix = getattr(self, key), getattr(self, key + "_matrix")
            if diagonal is not None and matrix is not None:
                raise broken(f"must not be given beside {key}", at=(key + "_matrix",))
            if is_needed and diagonal is None and matrix is None:
                raise broken("missing", at=(key,))
        return self

    @model_validator(mode="after")
    def _has_thrusters_or_forces(self) -> VehicleModel:
        for key in ("max_force_n", "max_torque_nm"):
            if self.thrusters and getattr(self, key) is not None:
                raise broken("must not be given for a vehicle with thrusters", at=(key,))
            if not self.thrusters and getattr(self, key) is None:
                raise broken("missing", at=(key,))
        return self

    @model_validator(mode="after")
    def _has_the_propellers_of_its_rudders(self) -> VehicleModel:
        propellers = [name for name, thruster in self.thrusters.items() if thruster.force is None]
        for name, fin in self.fins.items():
            if fin.slipstream_of is not None and fin.slipstream_of not in propellers:
                rule = f"must be a thruster with a propeller: {', '.join(propellers) or 'it has none'}"
                raise broken(rule, at=("fins", name, "slipstream_of"), value=fin.slipstream_of)
        return self

    @model_validator(mode="after")
    def _has_a_tree_of_links(self) -> VehicleModel:
        if self.arm is not None:
            links_in_order(self.arm)
        return self

    @property
    def source_file(self) -> SourceFile:
        """The file from which the model was read, for messages."""
        return self._source_file

    def matrix(self, key: Literal["added_mass", "linear_damping", "quadratic_damping"]) -> NDArray[np.float64]:
        """Return a matrix (6, 6), specified in full or by its diagonal; zero if unspecified."""
        full, diagonal = getattr(self, key + "_matrix"), getattr(self, key)
        if full is not None:
            return np.array(full, np.float64)
        return np.diag(np.zeros(6) if diagonal is None else np.array(diagonal, np.float64))


def _or_null(schema: JsonSchemaValue) -> JsonSchemaValue:
    """Return a schema that also accepts null; what describes a field stays outside the choice."""
    described: JsonSchemaValue = {key: schema[key] for key in ("default", "description") if key in schema}
    arms = schema.get("anyOf", [{key: value for key, value in schema.items() if key not in described}])
    return {"anyOf": [*arms, *([] if {"type": "null"} in arms else [{"type": "null"}])], **described}


_building: ContextVar[tuple[Path, ...]] = ContextVar("_building", default=())
"""The vehicles' files that are being read as the base of another, innermost last."""


def _on_its_base(values: Any, folder: Path | None) -> Any:
    """Return a vehicle's values together with those of the vehicle that it builds on, if any. Raises ScenarioError."""
    if not isinstance(values, Mapping) or (base := values.get("builds_on")) is None:
        return values
    if not isinstance(base, str | Path):
        raise broken("must be text", at=("builds_on",), value=base)
    path = spec_path(base, "vehicles", folder).resolve()
    above = _building.get()
    if path in above:
        raise broken("must not build on itself", at=("builds_on",), value=str(base))
    if len(above) == MOST_BASES:
        raise broken(f"must build on at most {MOST_BASES} others, one on another", at=("builds_on",), value=str(base))
    token = _building.set((*above, path))
    try:
        merged = load_vehicle(path).given()
    finally:
        _building.reset(token)
    for key, value in values.items():
        if key in PARTS and isinstance(value, Mapping):
            value = _with_parts(merged.get(key, {}), value, key)
        merged[key] = value
    known = VehicleModel.model_fields.keys() - {"builds_on"}
    return {key: value for key, value in merged.items() if key != "builds_on" and not (value is None and key in known)}


def _with_parts(base: Mapping[str, Any], own: Mapping[str, Any], key: str) -> dict[str, Any]:
    """Return parts by name, those of the base without the ones that are `null` here. Raises PydanticCustomError."""
    for name in own:
        if own[name] is None and name not in base:
            raise broken(f"no such part to remove{did_you_mean(str(name), base)}", at=(key, name))
    return {name: part for name, part in {**base, **own}.items() if part is not None}


def _not_one_mass(given: int) -> PydanticCustomError:
    return broken(f"exactly one of {MASSES[0]}, {MASSES[1]} and {MASSES[2]} must be given, not {given}")


def _is_absence(error: ErrorDetails) -> bool:
    rule = str(error.get("ctx", {}).get("rule", ""))
    return len(error["loc"]) <= 1 and (error["type"] == "missing" or rule in ("missing", str(_not_one_mass(0))))


def _absent(values: Mapping[str, Any]) -> Iterator[InitErrorDetails]:
    """Yield an error for each key, or choice of keys, that a vehicle's file lacks."""

    def lacks(*keys: str) -> bool:
        return all(values.get(key) is None for key in keys)

    needed = [key for key in NEEDED if lacks(key)]
    needed += [key for key in ("linear_damping", "quadratic_damping") if lacks(key, f"{key}_matrix")]
    needed += [key for key in ("max_force_n", "max_torque_nm") if lacks(key) and not values.get("thrusters")]
    yield from (InitErrorDetails(type="missing", loc=(key,), input=values) for key in needed)
    if lacks(*MASSES):
        yield InitErrorDetails(type=_not_one_mass(0), loc=(), input=values)


def load_vehicle(source: str | Path, folder: Path | None = None) -> VehicleModel:
    """Load a vehicle from a packaged name ("rov") or a YAML file path, relative to `folder`. Raises ScenarioError."""
    return read_spec(VehicleModel, source, "vehicles", folder)
