"""Parts of Stonefish's robots: a body's mass and drag, as stated or by its geometry, and acoustic devices.

Source: Stonefish 1.6, ScenarioParser::ParseSolid, SolidEntity::SetArbitraryPhysicalProperties,
ComputeFluidDynamicsApprox, ComputeHydrodynamicForcesSubmerged and CorrectHydrodynamicForces. On each face of area A,
with the normal n, that moves with v, the drag is rho / 2 Cd |v| (v . n) A v where it meets the water, and
rho Cf A times the tangential part of v. Cd and Cf are three numbers each, for the axes of the part.

Devices: ScenarioParser::ParseComm, USBLSimple and AcousticModem. A device states its number and that of the one to
which it is connected; the range between the two is the same from either end, and the bearing opposite.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from uwsim.exchange.robots import shapes
from uwsim.exchange.robots.robot import SENSES, Description, Lump, Mesh, Robot, plain_name
from uwsim.exchange.robots.sensors import put_sensor
from uwsim.exchange.robots.xml_file import HERE, Element, Floats, Pose

FACES_ALONG = 16
"""Faces along a part's longest edge, on which the velocities of a rotation are taken."""
SKIN_SHARE = 0.1
"""Stonefish's Cf, in parts of its Cd, where a file does not state it."""
DIAGONAL = 1e-6
"""Products of inertia below this share of the smallest moment leave the axes as they are, as in Stonefish."""
USBL, MODEM = ("usbl", "usbl2"), "acoustic_modem"
PING_HZ, TONE_HZ, RANGE_MAX_M = 1.0, 25_000.0, (1.0, 10_000.0)
"""Assumed: the rate of a USBL that states none, and the tone of a beacon."""


class WetPart(NamedTuple):
    """A part that the water drags at. mesh: in the body's frame. turn: rotation of its axes to the body's."""

    mesh: Mesh
    turn: Floats
    quadratic: Floats
    viscous: Floats


def body_lump(part: Element, mesh: Mesh, wall_m: float, density_kg_m3: float | None) -> Lump:
    """Return a part's mass in its own frame: as stated, and by its material where nothing is.

    A mass alone scales the inertia of the material. Beside an inertia or a centre of gravity it does not: a moment that
    is not stated stays that of the material, about the axes of the centre of gravity. density_kg_m3: None if unknown.
    """
    stated = part.numbers("mass", 1, "value")
    moments = part.numbers("inertia", 3, "xyz")
    moments = None if moments is None or not moments.any() else moments
    place = part.find("cg")
    given_kg = None if stated is None or not stated[0] > 0.0 else float(stated[0])
    volume, _ = shapes.volume_and_centre(mesh)
    own_kg = given_kg if density_kg_m3 is None else density_kg_m3 * (shapes.area_m2(mesh) * wall_m or volume)
    if own_kg is None or not own_kg > 0.0:
        raise part.error("has no mass: it must have a <mass>, or a material of the file and a volume")
    own = (shapes.shell_lump if wall_m > 0.0 else shapes.solid_lump)(mesh, own_kg)
    mass_kg = own_kg if given_kg is None else given_kg
    if moments is None and place is None:
        return Lump(mass_kg, own.centre_m, own.inertia_kg_m2 * (mass_kg / own_kg))
    axes = own_axes(part, own)
    if moments is None:
        if density_kg_m3 is None:
            raise part.error("its inertia is that of its material, which the file does not have: must state <inertia>")
        moments = np.diagonal(axes.T @ own.inertia_kg_m2 @ axes)
    if not (moments > 0.0).all():
        raise part.error(f"inertia: {' '.join(f'{value:g}' for value in moments)} kg m2: must be positive")
    centre = Pose(own.centre_m, axes) if place is None else part.origin("cg")
    return Lump(mass_kg, centre.position_m, centre.turn @ np.diag(moments) @ centre.turn.T)


def lump_alone(part: Element, to_body: Pose, error: Exception) -> Lump:
    """Return, in the body's frame, the mass and inertia that a part without a usable shape states. Raises error."""
    mass = part.numbers("mass", 1, "value")
    if mass is None or not mass[0] > 0.0:
        raise error
    moments = part.numbers("inertia", 3, "xyz")
    at = to_body.then(part.origin("cg") if part.find("cg") else (part.find("physical") or part).origin())
    moments = np.zeros(3) if moments is None or (moments < 0.0).any() else moments
    return Lump(float(mass[0]), at.position_m, at.turn @ np.diag(moments) @ at.turn.T)


def own_axes(part: Element, own: Lump) -> Floats:
    """Return the axes about which Stonefish takes the moments of a part: its origin's, or of a mesh its principal ones.

    Principal axes are in the order of their moments, from the smallest.
    """
    if part.attribute("type") != "model":
        return part.origin().turn
    turn = (part.find("physical") or part).origin().turn
    inertia = turn.T @ own.inertia_kg_m2 @ turn
    moments = np.diagonal(inertia)
    if np.abs(inertia - np.diag(moments)).max() < DIAGONAL * moments.min():
        return turn
    return np.asarray(turn @ np.linalg.eigh(inertia)[1])


def wet_part(part: Element, mesh: Mesh, own: Lump, to_body: Pose) -> tuple[WetPart, bool]:
    """Return a part as the water drags at it, and whether its file states all of its coefficients.

    mesh: in the part's frame. to_body: the part's pose in the body's. Raises ValueError.
    """
    stated = [part.numbers("hydrodynamics", 3, f"{name}_drag") for name in ("quadratic", "viscous")]
    stated = [None if each is None or (each < 0.0).any() else each for each in stated]
    assumed = _by_shape(part, mesh, own)
    quadratic, viscous = (
        share * assumed if each is None else each for each, share in zip(stated, (1.0, SKIN_SHARE), strict=True)
    )
    wet = WetPart(shapes.placed(mesh, to_body), to_body.turn, quadratic, viscous)
    return wet, all(each is not None for each in stated)


def _by_shape(part: Element, mesh: Mesh, own: Lump) -> Floats:
    """Return Stonefish's own Cd (3,): of a sphere, a cylinder, or the ellipsoid around a box or a mesh."""
    kind = part.attribute("type")
    if kind == "sphere":
        return np.ones(3)
    axes = own_axes(part, own)
    if kind == "cylinder":
        return np.asarray(np.abs(axes @ np.array([0.5, 0.5, 1.0])))
    half = np.abs((mesh[0] - own.centre_m) @ axes).max(axis=0)
    return np.asarray(np.abs(axes @ (half.min() / half)))


def drag_about(parts: list[WetPart], density_kg_m3: float, origin_m: Floats) -> tuple[Floats, Floats]:
    """Return linear and quadratic damping (6,) of motions along and about each axis of the body through a point."""
    linear, quadratic = np.zeros(6), np.zeros(6)
    for part in parts:
        corners = _fine(part.mesh)
        across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        twice = np.linalg.norm(across, axis=1)
        keep = twice > 0.0
        normal, area = across[keep] / twice[keep, None], 0.5 * twice[keep]
        arm = corners[keep].mean(axis=1) - origin_m
        for axis in range(6):
            unit = np.eye(3)[axis % 3]
            velocity = np.tile(unit, (len(arm), 1)) if axis < 3 else np.cross(unit, arm)
            into = np.einsum("fi,fi->f", velocity, normal)
            tangential = (velocity - into[:, None] * normal) * area[:, None]
            linear[axis] += density_kg_m3 * _along(part, part.viscous, tangential, arm, axis)
            speed = np.linalg.norm(velocity, axis=1)
            for ahead in (1.0, -1.0):  # the mean of both directions
                met = velocity * (speed * np.maximum(ahead * into, 0.0) * area)[:, None]
                quadratic[axis] += 0.25 * density_kg_m3 * _along(part, part.quadratic, met, arm, axis)
    return linear, quadratic


def _along(part: WetPart, coefficients: Floats, forces: Floats, arm: Floats, axis: int) -> float:
    """Return the sum of forces on faces, or of their torques, along the motion, with the coefficient of its direction.

    That of a direction is the sum of those of the part's axes, weighted by the direction's components.
    """
    total = (forces if axis < 3 else np.cross(arm, forces)).sum(axis=0)
    size = float(np.linalg.norm(total))
    weight = float(np.abs(part.turn.T @ total) @ coefficients) / size if size > 0.0 else 0.0
    return weight * float(total[axis % 3])


def _fine(mesh: Mesh) -> Floats:
    """Return the corners (n, 3, 3) of a mesh's faces, subdivided."""
    from uwsim.base.whole_trimesh import trimesh

    longest = float(np.ptp(mesh[0], axis=0).max()) / FACES_ALONG
    vertices, faces = trimesh.remesh.subdivide_to_size(  # type: ignore[no-untyped-call]
        mesh[0], mesh[1], longest, max_iter=20
    )
    return np.asarray(np.asarray(vertices)[np.asarray(faces)])


FLIP = Pose(HERE.position_m, np.diag([1.0, -1.0, -1.0]))
"""Stonefish's axes of a body, forward, starboard, down, in uwsim's."""


class Fixed(NamedTuple):
    """A device that does not move. position_m: in the world."""

    element: Element
    position_m: Floats
    connected: str | None


def fixed_device(element: Element, position_m: Floats, found: Description) -> Fixed:
    """Return a device of the world or of a static body; a modem is a pinger, if it is under water."""
    kind = element.needed("type")
    to = element.find("connect")
    if kind == MODEM and position_m[2] < 0.0:
        name = plain_name(element.name, [each["name"] for each in found.pingers])
        found.pingers.append({"name": name, "position_m": position_m.tolist(), "frequency_hz": TONE_HZ})
        found.assumed(f"{element.path}: a pinger of {TONE_HZ:g} Hz, once in 2 s: Stonefish's has no tone", SENSES)
    elif kind not in (*USBL, MODEM):
        found.dropped(element, f", of type {kind}")
    return Fixed(element, position_m, None if to is None else to.attribute("device_id"))


def put_comm(robot: Robot, comm: Element, at: Pose, devices: list[Fixed], found: Description) -> None:
    """Add the USBL by which a robot and a fixed device range each other, or note the device.

    at: its pose on the robot. Here, the station is at the fixed end, and the sensor is the robot's.
    """
    kind, number, to = comm.needed("type"), comm.attribute("device_id"), comm.find("connect")
    connected = None if to is None else to.attribute("device_id")
    ends = {each.element.attribute("device_id"): each for each in devices}
    if kind in USBL:
        usbl, other = comm, ends.get(connected)
    else:
        other = next((e for e in devices if e.element.attribute("type") in USBL and e.connected == number), None)
        if kind != MODEM or other is None:
            hint = ": `--link ideal_acoustic` has its delays" if kind == MODEM else ""
            found.dropped(comm, f", of type {kind}{hint}")
            return
        usbl = other.element
    if other is None:
        found.assumed(f"{comm.path}: from the station, since device {connected} is not a fixed one", SENSES)
    else:
        found.station = [float(other.position_m[0]), float(other.position_m[1]), 0.0]
        found.assumed(f"{comm.path}: from the station, which is above {other.element.path}", SENSES)
    noise, steps = usbl.find("noise"), usbl.find("resolution")
    errors: dict[str, dict[str, float]] = {}
    for channel, keys, of, unit in (
        ("range", ("range",), "range", 1.0),
        ("bearing", ("horizontal_angle", "vertical_angle"), "angle", np.pi / 180.0),
    ):
        std = 0.0 if noise is None else max(noise.number(None, 0.0, key) for key in keys)
        step = 0.0 if steps is None else steps.number(None, 0.0, of)
        stated = {"std": std * unit, "quantum": step * unit}
        if any(stated.values()):
            errors[channel] = {key: float(value) for key, value in stated.items() if value > 0.0}
    more: dict[str, Any] = {"channels": errors} if errors else {}
    reach = usbl.numbers("specs", 1, "range")
    if reach is not None:
        more["range_max_m"] = float(np.clip(reach[0], *RANGE_MAX_M))
    rate = usbl.number("autoping", PING_HZ, "rate")
    put_sensor(robot, found, comm.path, comm.name, "usbl", Pose(at.position_m, np.eye(3)), rate, more)
