"""A vehicle's URDF, written from its model, and the latched channel /robot_description that publishes it.

http://wiki.ros.org/urdf/XML: lengths in m, angles in rad, mass in kg, inertia in kg m2; rpy are rotations about the
parent's fixed x, y and z axes. URDF has no water: added mass, buoyancy and drag are not in it, of an arm's links
neither.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uwsim.base import quaternions
from uwsim.channels.channel import Channel, Delivery
from uwsim.channels.families.body_frames import BASE, Frame, Joint, body_frames, link_frame
from uwsim.channels.ros import build
from uwsim.channels.source import Source
from uwsim.scenario import Scenario
from uwsim.scenario.build.craft import mass_properties
from uwsim.scenario.build.earth import gravity_m_s2
from uwsim.scenario.build.hull import hull_placement, vehicle_hull
from uwsim.scenario.build.water import surface_density_kg_m3
from uwsim.scenario.obstacles.solids import Box, Cylinder, MeshObstacle, Sphere
from uwsim.scenario.read.mesh_file import Y_UP_SUFFIXES
from uwsim.scenario.spec.arm import Link
from uwsim.scenario.spec.obstacle import LEVEL, ObstacleModel
from uwsim.scenario.spec.vehicle import VehicleModel
from uwsim.scenario.spec.vehicle_entry import VehicleEntry
from uwsim.simulator.simulator import Simulator

NAME = "robot_description"
LOOK_HZ = 10.0  # how often a change of the parameters is noticed
FIN_THICKNESS_M = 0.01
QUARTER_TURNS = {"x": 0, "-y": 1, "-x": 2, "y": -1}  # about z, that turn each direction to x
COLOUR = "0.95 0.75 0.1 1"


class Mesh(NamedTuple):
    """The hull's mesh, and its place in the body frame. uri: file:// or package://."""

    uri: str
    scale: float = 1.0
    position_m: ArrayLike = (0.0, 0.0, 0.0)
    orientation_xyzw: ArrayLike = build.IDENTITY_XYZW


def mesh_file(model: VehicleModel) -> Mesh:
    """Return the model's own mesh file, which viewers on this machine can open."""
    factor, shift_m = hull_placement(model)
    turn = quaternions.about_z(QUARTER_TURNS[model.mesh_forward or "x"] * 0.5 * math.pi)
    turn = quaternions.product(turn, turn_up(model.mesh, model.mesh_up))
    return Mesh(model.mesh.resolve().as_uri(), factor * model.mesh_scale, shift_m, turn)


def turn_up(file: Path, up: str | None) -> NDArray[np.float64]:
    """Return the turn that maps a file's upward axis to z, as TURNS_UP does. Axes that a file declares are not read."""
    up = up or ("y" if file.suffix.lower() in Y_UP_SUFFIXES else "z")
    about = quaternions.about_x if up[-1] == "y" else quaternions.about_y
    quarters = {"y": 1, "-y": -1, "x": -1, "-x": 1}.get(up, 0)
    return quaternions.about_x(math.pi) if up == "-z" else about(0.5 * math.pi * quarters)


def urdf(scenario: Scenario, source: Source, mesh: Mesh | None = None) -> str:
    """Return a vehicle's URDF. Its frames are those of /tf below base_link, its joints those of /joint_states.

    scenario: with the current parameters; its water determines a trimmed vehicle's mass. mesh: the hull's, by default
    the model's own file. Raises ScenarioError.
    """
    entry = next(entry for entry in scenario.vehicles if entry.name == source.name)
    robot = Element("robot", name=entry.name)
    SubElement(SubElement(robot, "material", name="hull"), "color", rgba=COLOUR)
    base = SubElement(robot, "link", name=source.frame(BASE))
    _add_inertial(base, scenario, entry)
    _add_hull(base, entry.model, mesh or mesh_file(entry.model))
    for frame in body_frames(entry.model):
        _add_frame(robot, source, frame, entry.model)
    ElementTree.indent(robot)
    return f'<?xml version="1.0"?>\n{ElementTree.tostring(robot, encoding="unicode")}\n'


def _add_inertial(link: Element, scenario: Scenario, entry: VehicleEntry) -> None:
    density_kg_m3 = surface_density_kg_m3(scenario.water)
    mass_kg, centre_m, inertia = mass_properties(
        entry.model, density_kg_m3, entry.trim or entry.model.trim, gravity_m_s2(scenario.earth)
    )
    inertial = SubElement(link, "inertial")
    _add_origin(inertial, centre_m)
    SubElement(inertial, "mass", value=repr(float(mass_kg)))
    moments = {f"i{a}{b}": inertia["xyz".index(a), "xyz".index(b)] for a, b in ("xx", "xy", "xz", "yy", "yz", "zz")}
    SubElement(inertial, "inertia", {name: repr(float(value)) for name, value in moments.items()})


def _add_hull(link: Element, model: VehicleModel, mesh: Mesh) -> None:
    """Add the mesh as the visual, and as the collision shape unless that is the bounding box."""
    for part in ("visual", "collision"):
        element = SubElement(link, part)
        if part == "collision" and model.collision == "box":
            low, high = (getattr(vehicle_hull(model)[0], end)(axis=0) for end in ("min", "max"))
            _add_origin(element, 0.5 * (low + high))
            SubElement(SubElement(element, "geometry"), "box", size=_numbers(high - low))
            continue
        _add_origin(element, mesh.position_m, mesh.orientation_xyzw)
        scale = _numbers([mesh.scale] * 3)
        SubElement(SubElement(element, "geometry"), "mesh", filename=mesh.uri, scale=scale)
        if part == "visual":
            SubElement(element, "material", name="hull")


def _add_frame(robot: Element, source: Source, frame: Frame, model: VehicleModel) -> None:
    link = SubElement(robot, "link", name=source.frame(frame.name))
    for own, part in (model.arm or {}).items():
        if frame.name == link_frame(own):
            _add_mass(link, part)
            if part.shape is not None:
                _add_shape(link, part.shape)
    turning = frame.joint
    name = source.frame(f"{frame.name}_joint") if turning is None else source.topic(turning.name)
    is_fixed = turning is None or turning.low_rad == turning.high_rad
    joint = SubElement(robot, "joint", name=name, type="fixed" if is_fixed else _type_of(turning))
    _add_origin(joint, frame.position_m, frame.orientation_xyzw)
    SubElement(joint, "parent", link=source.frame(frame.parent))
    SubElement(joint, "child", link=source.frame(frame.name))
    if turning is None:
        return
    if not is_fixed:
        SubElement(joint, "axis", xyz=_numbers(turning.axis))
        limits = turning.low_rad, turning.high_rad, turning.rate_rad_s, turning.effort
        named = dict(zip(("lower", "upper", "velocity", "effort"), limits, strict=True))
        SubElement(joint, "limit", {key: repr(float(value)) for key, value in named.items() if math.isfinite(value)})
    if turning.name in model.fins:
        _add_fin(link, math.sqrt(model.fins[turning.name].area_m2), turning.axis)


def _type_of(joint: Joint | None) -> str:
    if joint is None:
        return "fixed"
    return "prismatic" if joint.is_slide else "revolute" if math.isfinite(joint.low_rad) else "continuous"


def _add_mass(element: Element, link: Link) -> None:
    """Add the mass of an arm's link, without that of the water that it moves."""
    inertial = SubElement(element, "inertial")
    _add_origin(inertial, link.centre_of_mass_m)
    SubElement(inertial, "mass", value=repr(link.mass_kg))
    names = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    values = (*link.inertia_kg_m2, *link.inertia_products_kg_m2)
    SubElement(inertial, "inertia", {name: repr(float(value)) for name, value in zip(names, values, strict=True)})


def _add_shape(element: Element, shape: ObstacleModel) -> None:
    """Add a link's shape as visual and collision: primitives, or its mesh file."""
    turn = quaternions.of_yaw_pitch_roll_deg(getattr(shape, "yaw_pitch_roll_deg", LEVEL))
    for part in ("visual", "collision"):
        added = SubElement(element, part)
        geometry = SubElement(added, "geometry")
        if isinstance(shape, MeshObstacle):
            _add_origin(added, shape.position_m, quaternions.product(turn, turn_up(shape.file, shape.up)))
            scale = _numbers([shape.scale] * 3)
            SubElement(geometry, "mesh", filename=shape.file.resolve().as_uri(), scale=scale)
            continue
        _add_origin(added, shape.position_m, turn)  # type: ignore[attr-defined]  # of all kinds that links have
        if isinstance(shape, Box):
            SubElement(geometry, "box", size=_numbers(shape.size_m))
        elif isinstance(shape, Cylinder):
            SubElement(geometry, "cylinder", radius=repr(shape.radius_m), length=repr(shape.length_m))
        elif isinstance(shape, Sphere):
            SubElement(geometry, "sphere", radius=repr(shape.radius_m))


def _add_fin(link: Element, side_m: float, span: tuple[float, float, float]) -> None:
    """Draw a fin as a square of its area across x, since the model has no more of its outline."""
    across = np.abs([0.0, span[2], span[1]])  # of the plane of x and the span
    visual = SubElement(link, "visual")
    size = np.where(across > 0.5, FIN_THICKNESS_M, side_m)
    _add_origin(visual, (0.0, 0.0, 0.0))
    SubElement(SubElement(visual, "geometry"), "box", size=_numbers(size))
    SubElement(visual, "material", name="hull")


def _add_origin(element: Element, position_m: ArrayLike, orientation_xyzw: ArrayLike = build.IDENTITY_XYZW) -> None:
    SubElement(element, "origin", xyz=_numbers(position_m), rpy=_numbers(_roll_pitch_yaw(orientation_xyzw)))


def _roll_pitch_yaw(orientation_xyzw: ArrayLike) -> tuple[float, float, float]:
    """Return angles [rad] about the fixed axes; of those that are equal at a pitch of 90 degrees, that without yaw."""
    m = quaternions.matrix(orientation_xyzw)
    level = math.hypot(m[0, 0], m[1, 0])
    pitch = math.atan2(-m[2, 0], level)
    if level < 1e-9:
        return math.atan2(-m[1, 2], m[1, 1]), pitch, 0.0
    return math.atan2(m[2, 1], m[2, 2]), pitch, math.atan2(m[1, 0], m[0, 0])


def _numbers(values: ArrayLike) -> str:
    return " ".join(repr(value + 0.0) for value in np.asarray(values, np.float64).tolist())


def description_channel(source: Source) -> Channel:
    """Return the channel of a vehicle's URDF, which is sent again when a parameter has changed it."""
    latest: tuple[Scenario | None, Any] = (None, None)

    def read(sim: Simulator) -> Any:
        """Return the message: the same object as before unless it has changed."""
        nonlocal latest
        scenario = sim.parameters.scenario
        if scenario is not latest[0]:
            text = urdf(scenario, source)
            latest = scenario, latest[1] if latest[0] and latest[1].data == text else build.text(text)
        return latest[1]

    return Channel(
        source.topic(NAME), "std_msgs/msg/String", "out", "the vehicle as URDF", rate_hz=LOOK_HZ,
        delivery=Delivery(latched=True, is_sampled=True, on_request=True), read=read,
    )  # fmt: skip


def descriptions(channels: Iterable[Channel], sim: Simulator) -> dict[str, str]:
    """Return each URDF by the name of its channel, for graphs whose clients read it as a parameter."""
    return {one.name: one.read(sim).data for one in channels if one.name.rpartition("/")[2] == NAME}
