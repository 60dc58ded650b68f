"""An arm of a vehicle, whose links are held by joints, and droppers. Angles in degrees, as everywhere."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated

from pydantic import Field, model_validator

from uwsim.base.named import did_you_mean
from uwsim.scenario.spec.fields import InRange, Model, Name, Point3, YawPitchRoll, broken
from uwsim.scenario.spec.obstacle import ObstacleSpec
from uwsim.scenario.spec.sensor import STATEFUL, Noise

SHAPES = ("box", "cylinder", "mesh", "sphere")

Mass = Annotated[float, InRange(1e-3, 1e5, "kg")]
Inertia = Annotated[float, InRange(1e-9, 1e6, "kg m2")]
Product = Annotated[float, InRange(-1e6, 1e6, "kg m2")]
Added = Annotated[float, InRange(0, 1e6)]
Drag = Annotated[float, InRange(0, 1e6)]
Six = tuple[Added, Added, Added, Added, Added, Added]
Angle = Annotated[float, InRange(-36_000, 36_000, "deg")]
Travel = Annotated[float, InRange(-100, 100, "m")]
Turn = Annotated[float, InRange(-360, 360, "deg")]
Response = Annotated[float, InRange(1e-3, 100, "s")]
RotorInertia = Annotated[float, InRange(0, 100, "kg m2")]


class HingeMotor(Model):
    """A hinge's motor with its gear and controller. Torques are at the joint.

    fastest_deg_s: the speed that the controller asks for at most. response_s: time constant with which it approaches a
    position. gear_ratio: turns of the rotor per turn of the joint, whose square times rotor_inertia_kg_m2 the joint
    feels. torque_per_ampere_nm_a: for its current; by default unknown.
    """

    strongest_nm: Annotated[float, InRange(1e-4, 1e6, "N m")]
    fastest_deg_s: Annotated[float, InRange(1e-3, 1e5, "deg/s")]
    response_s: Response = 0.1
    gear_ratio: Annotated[float, InRange(1e-3, 1e5)] = 1.0
    rotor_inertia_kg_m2: RotorInertia = 0.0
    torque_per_ampere_nm_a: Annotated[float, InRange(1e-6, 1e6, "N m/A")] | None = None


class SlideMotor(Model):
    """A slide's motor with its gear and controller. Forces are at the joint.

    fastest_m_s: the speed that the controller asks for at most. response_s: time constant with which it approaches a
    position. gear_rad_m: how far the rotor turns per metre. force_per_ampere_n_a: for its current; by default unknown.
    """

    strongest_n: Annotated[float, InRange(1e-4, 1e7, "N")]
    fastest_m_s: Annotated[float, InRange(1e-6, 100, "m/s")]
    response_s: Response = 0.1
    gear_rad_m: Annotated[float, InRange(1e-3, 1e6, "rad/m")] = 1.0
    rotor_inertia_kg_m2: RotorInertia = 0.0
    force_per_ampere_n_a: Annotated[float, InRange(1e-6, 1e7, "N/A")] | None = None


class JointErrors(Model):
    """Errors of what is measured at a joint, for which only those without memory can be given.

    position [rad or m], speed [rad/s or m/s]: of its encoder. current [A]: of its motor.
    """

    position: Noise = Noise()
    speed: Noise = Noise()
    current: Noise = Noise()

    @model_validator(mode="after")
    def _has_no_memory(self) -> JointErrors:
        for name in ("position", "speed", "current"):
            for key in STATEFUL:
                if value := getattr(getattr(self, name), key):
                    raise broken("must be 0 for a joint, whose errors have no memory", at=(name, key), value=value)
        return self


class Hinge(Model):
    """A joint that turns about an axis through the link's origin, right-handed. Without a motor it swings freely.

    axis: along the link's axes. start_deg: where it is at first. limits_deg: its stops; by default none. viscous and
    Coulomb friction: the latter is the same at any speed, and at most this at rest. motor: what drives it, if anything.
    errors: of what is measured at it; by default none.
    """

    axis: Point3 = (0.0, 0.0, 1.0)
    start_deg: Angle = 0.0
    limits_deg: tuple[Angle, Angle] | None = None
    viscous_nm_s_rad: Annotated[float, InRange(0, 1e6, "N m s/rad")] = 0.0
    coulomb_nm: Annotated[float, InRange(0, 1e6, "N m")] = 0.0
    motor: HingeMotor | None = None
    errors: JointErrors | None = None

    @model_validator(mode="after")
    def _starts_within(self) -> Hinge:
        _within(self.start_deg, self.limits_deg, "deg")
        return self


class Slide(Model):
    """A joint that moves along an axis. Without a motor it slides freely. Fields as for a hinge.

    motor: what drives it, if anything. errors: of what is measured at it; by default none.
    """

    axis: Point3 = (1.0, 0.0, 0.0)
    start_m: Travel = 0.0
    limits_m: tuple[Travel, Travel] | None = None
    viscous_n_s_m: Annotated[float, InRange(0, 1e6, "N s/m")] = 0.0
    coulomb_n: Annotated[float, InRange(0, 1e7, "N")] = 0.0
    motor: SlideMotor | None = None
    errors: JointErrors | None = None

    @model_validator(mode="after")
    def _starts_within(self) -> Slide:
        _within(self.start_m, self.limits_m, "m")
        return self


class Link(Model):
    """A rigid link. Its frame's origin is on the joint's axis.

    on: the link that holds it; by default the vehicle. position_m, yaw_pitch_roll_deg: its frame in that of what holds
    it, while the joint is at zero. hinge, slide: its joint; without either it is fixed. inertia_kg_m2: xx, yy, zz
    about its centre of mass along its axes, and inertia_products_kg_m2: xy, xz, yz, as in URDF. volume_m3,
    centre_of_buoyancy_m: of the water that it displaces; by default none, at the centre of mass. added_mass,
    linear_drag, quadratic_drag: surge to yaw along its axes, at the centre of buoyancy; by default none. shape: what
    light, sound and other bodies meet, a box, cylinder, mesh or sphere as under `obstacles`, placed in the link's
    frame; its name follows the vehicle's in labels. Contacts take its convex hull. By default, nothing perceives or
    touches the link. friction: its coefficient in contacts; by default the vehicle's.
    """

    on: Name | None = None
    position_m: Point3 = (0.0, 0.0, 0.0)
    yaw_pitch_roll_deg: tuple[Turn, Turn, Turn] = (0.0, 0.0, 0.0)
    hinge: Hinge | None = None
    slide: Slide | None = None
    mass_kg: Mass
    centre_of_mass_m: Point3 = (0.0, 0.0, 0.0)
    inertia_kg_m2: tuple[Inertia, Inertia, Inertia]
    inertia_products_kg_m2: tuple[Product, Product, Product] = (0.0, 0.0, 0.0)
    volume_m3: Annotated[float, InRange(0, 1e3, "m3")] = 0.0
    centre_of_buoyancy_m: Point3 | None = None
    added_mass: Six | None = None
    linear_drag: tuple[Drag, Drag, Drag, Drag, Drag, Drag] | None = None
    quadratic_drag: tuple[Drag, Drag, Drag, Drag, Drag, Drag] | None = None
    shape: ObstacleSpec | None = None
    friction: Annotated[float, InRange(0, 10)] | None = None

    @model_validator(mode="after")
    def _has_own_shape(self) -> Link:
        if self.shape is None:
            return self
        if self.shape.kind not in SHAPES:
            raise broken(f"must be one of {', '.join(SHAPES)}", at=("shape", "kind"), value=self.shape.kind)
        if self.shape.on_bed:
            raise broken("a link's shape is placed in the link's frame", at=("shape", "on_bed"), value=True)
        if self.shape.growth is not None:
            raise broken("must be left out for a link", at=("shape", "growth"))
        return self

    @model_validator(mode="after")
    def _has_one_joint(self) -> Link:
        if self.hinge is not None and self.slide is not None:
            raise broken("must not be given beside hinge", at=("slide",))
        return self


def _within(start: float, limits: tuple[float, float] | None, unit: str) -> None:
    if limits is None:
        return
    if limits[0] >= limits[1]:
        raise broken("the lower limit must come first", at=(f"limits_{unit}",), value=list(limits), unit=unit)
    if not limits[0] <= start <= limits[1]:
        rule = f"must be within limits_{unit}, [{limits[0]:g}, {limits[1]:g}] {unit}"
        raise broken(rule, at=(f"start_{unit}",), value=start, unit=unit)


def links_in_order(arm: Mapping[str, Link], field: str = "arm") -> list[str]:
    """Return the links' names, each after the one that holds it. field: theirs. Raises PydanticCustomError."""
    for name, link in arm.items():
        if link.on is not None and link.on not in arm:
            raise broken(f"no such link{did_you_mean(link.on, arm)}", at=(field, name, "on"), value=link.on)
    shapes = [link.shape.name for link in arm.values() if link.shape is not None]
    for name, link in arm.items():
        if link.shape is not None and shapes.count(link.shape.name) > 1:
            raise broken("must be unique", at=(field, name, "shape", "name"), value=link.shape.name)
    found: list[str] = []
    while len(found) < len(arm):
        ready = [name for name, link in arm.items() if name not in found and (link.on is None or link.on in found)]
        if not ready:
            name = next(name for name in arm if name not in found)
            raise broken("the links hold each other in a circle", at=(field, name, "on"), value=arm[name].on)
        found += ready
    return found


class Dropper(Model):
    """A dropper of markers, or a launcher of torpedoes, with a magazine.

    position_m, yaw_pitch_roll_deg: its frame in the body; bodies leave along its x, turned in it as their shapes
    are in the world. holds: names of the scenario's objects that it carries, in the order in which it lets go of
    them; their own places in the scenario do not count. spacing_m: from each to the next one, in its frame.
    spring_j: energy of the spring that pushes a body out; 0: it is dropped. jet_n, jet_s: thrust of the body's own
    jet along its x, and how long it lasts.
    """

    position_m: Point3
    yaw_pitch_roll_deg: YawPitchRoll = (0.0, 0.0, 0.0)
    holds: Annotated[tuple[Name, ...], Field(min_length=1, max_length=20)]
    spacing_m: Point3 = (0.0, 0.0, 0.0)
    spring_j: Annotated[float, InRange(0, 1e5, "J")] = 0.0
    jet_n: Annotated[float, InRange(0, 1e5, "N")] = 0.0
    jet_s: Annotated[float, InRange(0, 1000, "s")] = 0.0

    @model_validator(mode="after")
    def _jet_has_a_duration(self) -> Dropper:
        if (self.jet_n > 0) != (self.jet_s > 0):
            raise broken("give both jet_n and jet_s, or none", at=("jet_s",), value=self.jet_s, unit="s")
        return self
