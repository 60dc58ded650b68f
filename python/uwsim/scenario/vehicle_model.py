"""A vehicle's figures, as read from its YAML file. Body frame: x forward, y left, z up; its origin is the mesh's."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import AfterValidator, Field, model_validator

from uwsim import _core
from uwsim.scenario.fields import AssetFile, Factor, InRange, Model, Name, Point3, YawPitchRoll, broken
from uwsim.scenario.paths import did_you_mean

Force = Annotated[float, InRange(0, 1e6, "N")]
Torque = Annotated[float, InRange(0, 1e6, "N m")]
AlongMass = Annotated[float, InRange(0, 1e6, "kg")]
AboutMass = Annotated[float, InRange(0, 1e6, "kg m2")]
AlongLinear = Annotated[float, InRange(0, 1e6, "N s/m")]
AboutLinear = Annotated[float, InRange(0, 1e6, "N m s/rad")]
AlongQuadratic = Annotated[float, InRange(0, 1e6, "N s2/m2")]
AboutQuadratic = Annotated[float, InRange(0, 1e6, "N m s2/rad2")]
Inertia = Annotated[float, InRange(1e-6, 1e6, "kg m2")]


class SonarMount(Model):
    """Where the multibeam's head turns; it looks forward, and tilts about the body's y."""

    position_m: Point3


def _check_kind(kind: str) -> str:
    known = _core.sensor_kinds()
    if kind not in known:
        raise broken(f"must be one of {', '.join(known)}{did_you_mean(kind, known)}")
    return kind


class SensorMount(Model):
    """A sensor of one of the core's kinds. Rays are cast along the sensor's x: yaw 90 looks to port.

    range_max_m: of the kinds that look along a ray. noise_std: white, on every component, in the sensor's own unit.
    """

    kind: Annotated[str, AfterValidator(_check_kind)]
    position_m: Point3 = (0.0, 0.0, 0.0)
    yaw_pitch_roll_deg: YawPitchRoll = (0.0, 0.0, 0.0)
    range_max_m: Annotated[float, InRange(0.1, 1000, "m")] | None = None
    noise_std: Annotated[float, InRange(0, 1e6)] = 0.0


class VehicleModel(Model):
    """A rigid vehicle with forces and torques along and about its axes.

    mesh: the hull, closed and winding outward: buoyancy acts on its triangles, it collides, and it gives what is not
    given: the volume always, the inertia (as of a solid of even density) where inertia_kg_m2 is left out.
    Exactly one of mass_kg, density_kg_m3 (of the hull's volume) and `buoyancy: neutral` (the mass of the water that
    the whole hull displaces in the scenario's water).
    Six-vectors are surge, sway, heave, roll, pitch, yaw; magnitudes, all positive.
    linear_damping, quadratic_damping: force or torque opposing v and v|v|. added_mass: diagonal, none by default.
    inertia_kg_m2: principal moments about the centre of mass along the body's axes.
    max_force_n, max_torque_nm: at full effort along and about x, y, z. sensors: by name.
    """

    name: Name
    description: str = ""
    mesh: AssetFile
    mesh_scale: Factor = 1.0
    mesh_up: Literal["y", "z"] | None = None
    collision: Literal["hull", "box"] = "hull"

    mass_kg: Annotated[float, InRange(0.01, 1e6, "kg")] | None = None
    density_kg_m3: Annotated[float, InRange(1, 20_000, "kg/m3")] | None = None
    buoyancy: Literal["neutral"] | None = None
    centre_of_mass_m: Point3
    inertia_kg_m2: tuple[Inertia, Inertia, Inertia] | None = None

    added_mass: tuple[AlongMass, AlongMass, AlongMass, AboutMass, AboutMass, AboutMass] | None = None
    linear_damping: tuple[AlongLinear, AlongLinear, AlongLinear, AboutLinear, AboutLinear, AboutLinear]
    quadratic_damping: tuple[
        AlongQuadratic, AlongQuadratic, AlongQuadratic, AboutQuadratic, AboutQuadratic, AboutQuadratic
    ]
    max_force_n: tuple[Force, Force, Force]
    max_torque_nm: tuple[Torque, Torque, Torque]

    friction: Annotated[float, InRange(0, 2)] = 0.5
    restitution: Annotated[float, InRange(0, 1)] = 0.1

    sonar: SonarMount
    sensors: dict[Name, SensorMount] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _has_one_mass(self) -> VehicleModel:
        given = [key for key in ("mass_kg", "density_kg_m3", "buoyancy") if getattr(self, key) is not None]
        if len(given) != 1:
            raise broken(f"exactly one of mass_kg, density_kg_m3 and buoyancy must be given, not {len(given)}")
        if self.inertia_kg_m2 is not None:
            smallest, middle, largest = sorted(self.inertia_kg_m2)
            if largest > smallest + middle:
                rule = "the largest must not exceed the sum of the two others, as for any body"
                raise broken(rule, at=("inertia_kg_m2",), value=list(self.inertia_kg_m2), unit="kg m2")
        return self
