"""Writes a scenario as Stonefish's .scn. Its world is NED, its bodies' axes are forward, starboard, down.

Source: Stonefish's documentation of its environment, bodies, robots, actuators and sensors. It computes added mass from
a hull's shape; its drag is that of the shape, too, times coefficients for the axes of the body.
"""

from __future__ import annotations

from typing import Any
from xml.etree import ElementTree as Xml

import numpy as np

from uwsim.evidence.export.from_scenario import Exported, Fan, meshes_of, numbers, obj
from uwsim.evidence.robots import shapes
from uwsim.evidence.robots.robot import Found, Mesh, Robot, Thruster, unlike_zero
from uwsim.evidence.robots.stonefish import ENU_FROM_NED, FLU_FROM_FRD
from uwsim.evidence.robots.stonefish_body import WetPart, drag_about
from uwsim.evidence.robots.xml_file import Floats, Pose, turned, yaw_pitch_roll_deg
from uwsim.scenario import Scenario

HULL, ROCK = "hull", "rock"
ROCK_KG_M3 = 2500.0
BASE = "base_link"
SENSORS = {"imu": "imu", "compass": "compass", "pressure": "pressure", "gps": "gps", "dvl": "dvl"}
"""Stonefish's types by our kinds; another kind is noted as left out."""
NOISE = {
    "imu": {"angular_velocity": "angular_velocity", "linear_acceleration": "linear_acceleration"},
    "pressure": {"pressure": "pressure"},
    "compass": {"heading": "heading"},
    "gps": {"horizontal": "ned_position"},
}
"""Stonefish's names of the noise of our channels."""
OPTICAL = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
"""From the axes of Stonefish's cameras, along z with y down, to forward, starboard, down."""


def stonefish_files(world: Exported, folder: str, scenario: Scenario) -> dict[str, bytes]:
    """Return the scenario's file, under "", and those of its meshes, which it refers to in a folder beside it.

    What Stonefish has no place for is noted in world.found.
    """
    found = world.found
    root = Xml.Element("scenario")
    environment = _put(root, "environment")
    earth = scenario.earth
    place = (0.0, 0.0) if earth is None else (earth.latitude_deg, earth.longitude_deg)
    _put(environment, "ned", latitude=numbers(place[0]), longitude=numbers(place[1]))
    ocean = _put(environment, "ocean")
    _put(ocean, "water", density=numbers(found.density_kg_m3), jerlov="0.2")
    found.assumed("the water's look is Stonefish's for jerlov 0.2")
    _put(ocean, "waves", height="0.0")
    if found.current_m_s is not None and found.current_m_s.any():
        _put(_put(ocean, "current", type="uniform"), "velocity", xyz=numbers(ENU_FROM_NED.T @ found.current_m_s))
    _put(_put(environment, "atmosphere"), "sun", azimuth="20.0", elevation="50.0")
    materials, looks = _put(root, "materials"), _put(root, "looks")
    for name, density in ((HULL, found.density_kg_m3), (ROCK, ROCK_KG_M3)):
        _put(materials, "material", name=name, density=numbers(density), restitution="0.1")
    _put(_put(materials, "friction_table"), "friction", material1=HULL, material2=ROCK, static="0.5", dynamic="0.5")
    _put(looks, "look", name=HULL, rgb="0.9 0.7 0.1", roughness="0.5")
    files: dict[str, bytes] = {}
    for name, (vertices, triangles), colour in meshes_of(world):
        _put(looks, "look", name=name, rgb=numbers(colour), roughness="0.9")
        files[f"{name}.obj"] = obj((vertices @ ENU_FROM_NED, triangles))
        static = _put(root, "static", name=name, type="model")
        _model(static, f"{folder}/{name}.obj", ROCK, name)
        _put(static, "world_transform", xyz="0 0 0", rpy="0 0 0")
    for robot in found.robots:
        _robot(root, robot, world, folder, files)
    Xml.indent(root)
    return {"": b'<?xml version="1.0"?>\n' + Xml.tostring(root) + b"\n", **files}


def _put(parent: Xml.Element, tag: str, **attributes: str) -> Xml.Element:
    return Xml.SubElement(parent, tag, attributes)


def _model(parent: Xml.Element, file: str, material: str, look: str) -> None:
    physical = _put(parent, "physical")
    _put(physical, "mesh", filename=file, scale="1.0")
    _put(physical, "origin", xyz="0 0 0", rpy="0 0 0")
    _put(parent, "material", name=material)
    _put(parent, "look", name=look)


def _transform(parent: Xml.Element, tag: str, position_m: Floats, turn: Floats) -> None:
    yaw, pitch, roll = np.radians(yaw_pitch_roll_deg(turn))
    _put(parent, tag, xyz=numbers(position_m), rpy=numbers([roll, pitch, yaw]))


def _mount(part: Xml.Element, at: Pose) -> None:
    """Put a pose on the body, x forward, y left, z up, as Stonefish has it, and the link."""
    _transform(part, "origin", FLU_FROM_FRD @ at.position_m, at.turn)
    _put(part, "link", name=BASE)


def _robot(root: Xml.Element, robot: Robot, world: Exported, folder: str, files: dict[str, bytes]) -> None:
    found, where = world.found, f"vehicle '{robot.name}'"
    element = _put(root, "robot", name=robot.name, fixed="false", self_collisions="false")
    base = _put(element, "base_link", name=BASE, type="model", physics="submerged")
    vertices, triangles = robot.solids[0]
    files[f"{robot.name}.obj"] = obj((vertices @ FLU_FROM_FRD, triangles))
    _model(base, f"{folder}/{robot.name}.obj", HULL, HULL)
    whole = robot.whole()
    _put(base, "mass", value=f"{whole.mass_kg:.12g}")
    moments = np.diagonal(whole.inertia_kg_m2)
    _put(base, "inertia", xyz=numbers(moments))
    if unlike_zero(whole.inertia_kg_m2):
        found.left_out(f"{where}: its products of inertia")
    _put(base, "cg", xyz=numbers(FLU_FROM_FRD @ whole.centre_m), rpy="0 0 0")
    _drag(base, robot, found, where)
    found.left_out(f"{where}: its added mass: Stonefish computes its own from the hull")
    for name, sensor in robot.sensors.items():
        _sensor(element, name, sensor, found, where)
    for name, camera in robot.cameras.items():
        part = _put(element, "sensor", name=name, rate="10.0", type="camera")
        across = numbers(camera["field_of_view_deg"])
        _put(
            part, "specs", resolution_x=str(camera["width"]), resolution_y=str(camera["height"]), horizontal_fov=across
        )
        _mount(part, Pose(camera["at"].position_m, FLU_FROM_FRD @ camera["at"].turn @ FLU_FROM_FRD @ OPTICAL))
    if (fan := world.fans.get(robot.name)) is not None:
        _multibeam(element, fan)
        found.assumed(f"{where}: its multibeam is one ray a beam: echoes are neither refracted, nor lost, nor in error")
    for thruster in robot.thrusters:
        _thruster(element, thruster, folder)
        if thruster.torque_per_thrust_m or thruster.zero_thrust_advance_ratio:
            found.left_out(f"{where}: its propellers' torque, and their loss of thrust with the inflow")
    if robot.thrusters:
        files["propeller.obj"] = obj(_disc())
    else:
        found.left_out(f"{where}: forces along and about its axes, which move it here: nothing moves it there")
    turn = ENU_FROM_NED.T @ robot.place.turn @ FLU_FROM_FRD
    _transform(element, "world_transform", ENU_FROM_NED.T @ robot.place.position_m, turn)


def _drag(base: Xml.Element, robot: Robot, found: Found, where: str) -> None:
    """Put the coefficients with which the shape's drag along each axis of the body is the vehicle's own."""
    vertices, triangles = robot.solids[0]
    mesh = (vertices @ FLU_FROM_FRD, triangles)
    assert found.density_kg_m3 is not None and robot.linear is not None and robot.quadratic is not None
    by_axis = [
        drag_about([WetPart(mesh, np.eye(3), unit, unit)], found.density_kg_m3, np.zeros(3)) for unit in np.eye(3)
    ]  # the drag along each axis is a sum over the coefficients of all three
    linear, quadratic = (np.column_stack([each[k][:3] for each in by_axis]) for k in (0, 1))
    own = {
        key: np.maximum(np.linalg.solve(shares, np.diagonal(stated)[:3]), 0.0)
        for key, shares, stated in (
            ("quadratic_drag", quadratic, robot.quadratic), ("viscous_drag", linear, robot.linear)
        )
    }  # fmt: skip
    _put(base, "hydrodynamics", **{key: numbers(values) for key, values in own.items()})
    found.left_out(f"{where}: its drag in roll, pitch and yaw: it is that of the hull's shape there")


def _disc() -> Mesh:
    """Return a disc of a diameter of 1 m about x, as which propellers are drawn."""
    vertices, triangles = shapes.cylinder(0.5, 0.1)
    return vertices[:, [2, 0, 1]], triangles


def _thruster(element: Xml.Element, thruster: Thruster, folder: str) -> None:
    """Put a thruster with the stated curve and lag; its setpoint is the command, from -1 to 1.

    Stonefish turns the thrust of a left-handed screw round, and an inverted setpoint back.
    """
    part = _put(element, "actuator", name=thruster.name, type="thruster")
    is_right = "true" if thruster.clockwise else "false"
    _put(part, "specs", max_setpoint="1.0", inverted_setpoint="false" if thruster.clockwise else "true")
    propeller = _put(part, "propeller", diameter=numbers(thruster.diameter_m), right=is_right)
    _put(propeller, "mesh", filename=f"{folder}/propeller.obj", scale=numbers(thruster.diameter_m))
    _put(propeller, "material", name=HULL)
    _put(propeller, "look", name=HULL)
    if thruster.time_constant_s > 0.0:
        rotor = _put(part, "rotor_dynamics", type="first_order")
        _put(rotor, "time_constant", value=numbers(thruster.time_constant_s))
    else:
        _put(part, "rotor_dynamics", type="zero_order")
    curve = np.array(sorted(thruster.thrust_n))
    commands, thrusts = (curve if thruster.clockwise else -curve[::-1]).T
    model = _put(part, "thrust_model", type="linear_interpolation")
    _put(model, "input", value=numbers(commands))
    _put(model, "output", value=numbers(thrusts))
    axis = FLU_FROM_FRD @ thruster.axis
    _mount(part, Pose(thruster.position_m, _along(axis)))


def _along(axis: Floats) -> Floats:
    """Return a rotation whose x is along a unit vector, without roll."""
    return turned(0.0, float(-np.arcsin(np.clip(axis[2], -1.0, 1.0))), float(np.arctan2(axis[1], axis[0])))


def _sensor(element: Xml.Element, name: str, sensor: dict[str, Any], found: Found, where: str) -> None:
    kind = SENSORS.get(sensor["kind"])
    if kind is None:
        found.left_out(f"{where}: sensor '{name}', of kind {sensor['kind']}")
        return
    part = _put(element, "sensor", name=name, rate=numbers(sensor["rate_hz"]), type=kind)
    known = NOISE.get(kind, {})
    noise = {known[key]: numbers(std) for key, std in sensor["std"].items() if std and key in known}
    if noise:
        _put(part, "noise", **noise)
    if any(std and key not in known for key, std in sensor["std"].items()):
        found.left_out(f"{where}: errors of sensor '{name}'" + (" beside its white noise" if noise else ""))
    if kind == "dvl":
        given = {key: values[0] for key, values in sensor["parameters"].items() if len(values) == 1}
        if "beam_slant_deg" in given:
            _put(part, "specs", beam_angle=numbers(given["beam_slant_deg"]))
        if "range_min_m" in given and "range_max_m" in given:
            low, high = numbers(given["range_min_m"]), numbers(given["range_max_m"])
            _put(part, "range", altitude_min=low, altitude_max=high)
    _mount(part, Pose(np.array(sensor["position_m"]), FLU_FROM_FRD @ sensor["turn"] @ FLU_FROM_FRD))


def _multibeam(element: Xml.Element, fan: Fan) -> None:
    part = _put(element, "sensor", name="multibeam", rate=numbers(fan.rate_hz), type="multibeam")
    _put(part, "specs", fov=numbers(fan.width_deg), steps=str(fan.beams))
    _put(part, "range", distance_min="0.1", distance_max=numbers(fan.range_max_m))
    turn: Floats = FLU_FROM_FRD @ turned(0.0, np.radians(fan.tilt_deg), 0.0) @ FLU_FROM_FRD
    _mount(part, Pose(fan.position_m, turn))
