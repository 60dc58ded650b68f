"""Writes a scenario as a world in SDF, for gz-sim's systems Buoyancy, Hydrodynamics and Thruster.

Sources: the SDF specification (sdformat.org/spec), and gz-sim's documentation of these systems. Its buoyancy acts at
the origin of a collision's shape, so that a hull's mesh is written about its centre of buoyancy.
"""

from __future__ import annotations

from typing import Any
from xml.etree import ElementTree as Xml

import numpy as np

from uwsim.evidence.export.from_scenario import Exported, Fan, ends_n, meshes_of, numbers, obj, without
from uwsim.evidence.robots.robot import Found, Lump, Robot, Thruster
from uwsim.evidence.robots.systems import COLUMNS, ROWS
from uwsim.evidence.robots.xml_file import Floats, Pose, turned, yaw_pitch_roll_deg

VERSION = "1.9"
BASE = "base_link"
PROPELLER = Lump(1e-3, np.zeros(3), 1e-6 * np.eye(3))
"""Assumed: the mass of a propeller's link, which is taken off the base link's."""
SYSTEMS = (
    ("gz-sim-physics-system", "gz::sim::systems::Physics"),
    ("gz-sim-user-commands-system", "gz::sim::systems::UserCommands"),
    ("gz-sim-scene-broadcaster-system", "gz::sim::systems::SceneBroadcaster"),
    ("gz-sim-imu-system", "gz::sim::systems::Imu"),
    ("gz-sim-magnetometer-system", "gz::sim::systems::Magnetometer"),
    ("gz-sim-air-pressure-system", "gz::sim::systems::AirPressure"),
    ("gz-sim-dvl-system", "gz::sim::systems::DopplerVelocityLogSystem"),
)
SENSORS = {"imu": "imu", "compass": "magnetometer", "pressure": "air_pressure", "gps": "navsat", "dvl": "custom"}
"""Types in SDF by our kinds; another kind is noted as left out."""


def sdf_files(world: Exported, folder: str) -> dict[str, bytes]:
    """Return the world's file, under "", and those of its meshes, which it refers to in a folder beside it.

    What SDF or gz-sim has no place for is noted in world.found.
    """
    root = Xml.Element("sdf", {"version": VERSION, "xmlns:gz": "http://gazebosim.org/schema"})
    top = _put(root, "world", name=world.found.name)
    physics = _put(top, "physics", name="step", type="ignored")
    _put(physics, "max_step_size", numbers(world.step_s))
    _put(physics, "real_time_factor", "1")
    for file, name in SYSTEMS:
        _put(top, "plugin", filename=file, name=name)
    sensors = _put(top, "plugin", filename="gz-sim-sensors-system", name="gz::sim::systems::Sensors")
    _put(sensors, "render_engine", "ogre2")
    buoyancy = _put(top, "plugin", filename="gz-sim-buoyancy-system", name="gz::sim::systems::Buoyancy")
    _put(buoyancy, "uniform_fluid_density", numbers(world.found.density_kg_m3))
    world.found.left_out("the water's surface: gz-sim's uniform buoyancy has none, and its graded one no meshes")
    sun = _put(top, "light", name="sun", type="directional")
    _put(sun, "direction", "0.3 0.2 -0.93")
    files: dict[str, bytes] = {}
    for name, mesh, colour in meshes_of(world):
        files[f"{name}.obj"] = obj(mesh)
        model = _put(top, "model", name=name)
        _put(model, "static", "true")
        _shape(_put(model, "link", name="link"), f"{folder}/{name}.obj", colour)
    for robot in world.found.robots:
        _vehicle(top, robot, world, folder, files)
    Xml.indent(root)
    return {"": b'<?xml version="1.0"?>\n' + Xml.tostring(root) + b"\n", **files}


def _put(parent: Xml.Element, tag: str, text: str | None = None, **attributes: str) -> Xml.Element:
    element = Xml.SubElement(parent, tag, attributes)
    element.text = text
    return element


def _pose(parent: Xml.Element, pose: Pose) -> None:
    yaw, pitch, roll = np.radians(yaw_pitch_roll_deg(pose.turn))
    _put(parent, "pose", numbers([*pose.position_m, roll, pitch, yaw]))


def _shape(link: Xml.Element, uri: str, colour: tuple[float, ...], at: Pose | None = None) -> None:
    for tag in ("collision", "visual"):
        part = _put(link, tag, name=tag)
        if at is not None:
            _pose(part, at)
        _put(_put(_put(part, "geometry"), "mesh"), "uri", uri)
        if tag == "visual":
            material = _put(part, "material")
            for key in ("ambient", "diffuse"):
                _put(material, key, numbers([*colour, 1.0]))


def _inertial(link: Xml.Element, lump: Lump) -> None:
    inertial = _put(link, "inertial")
    _pose(inertial, Pose(lump.centre_m, np.eye(3)))
    _put(inertial, "mass", f"{lump.mass_kg:.12g}")
    inertia = _put(inertial, "inertia")
    for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)):
        _put(inertia, f"i{'xyz'[i]}{'xyz'[j]}", numbers(lump.inertia_kg_m2[i, j]))


def _vehicle(top: Xml.Element, robot: Robot, world: Exported, folder: str, files: dict[str, bytes]) -> None:
    found, where = world.found, f"vehicle '{robot.name}'"
    model = _put(top, "model", name=robot.name)
    _pose(model, robot.place)
    base = _put(model, "link", name=BASE)
    propellers = [Lump(PROPELLER.mass_kg, each.position_m, PROPELLER.inertia_kg_m2) for each in robot.thrusters]
    _inertial(base, without(robot.whole(), propellers))
    centre = robot.centre_of_buoyancy_m
    assert centre is not None
    vertices, triangles = robot.solids[0]
    files[f"{robot.name}.obj"] = obj((vertices - centre, triangles))
    _shape(base, f"{folder}/{robot.name}.obj", (0.9, 0.7, 0.1), Pose(centre, np.eye(3)))
    for name, sensor in robot.sensors.items():
        _sensor(base, name, sensor, found, where)
    for name, camera in robot.cameras.items():
        _camera(base, name, camera)
    if (fan := world.fans.get(robot.name)) is not None:
        _lidar(base, fan)
        found.assumed(f"{where}: its multibeam is a lidar: echoes are neither refracted, nor lost, nor in error")
    for thruster, lump in zip(robot.thrusters, propellers, strict=True):
        _propeller(model, thruster, lump, robot.name, found, where)
    if propellers:
        found.assumed(f"{where}: each propeller is a link of {1e3 * PROPELLER.mass_kg:g} g, taken off the base link's")
    else:
        found.left_out(f"{where}: forces along and about its axes, which move it here: nothing moves it there")
    _hydrodynamics(model, robot, found)


def _hydrodynamics(model: Xml.Element, robot: Robot, found: Found) -> None:
    plugin = _put(model, "plugin", filename="gz-sim-hydrodynamics-system", name="gz::sim::systems::Hydrodynamics")
    _put(plugin, "link_name", BASE)
    _put(plugin, "water_density", numbers(found.density_kg_m3))
    if found.current_m_s is not None and found.current_m_s.any():
        _put(plugin, "default_current", numbers(found.current_m_s))
    for i, row in enumerate(ROWS):
        for j, column in enumerate(COLUMNS):
            keys = (f"{row}Dot{column}", f"{row}{column}", f"{row}{column}abs{column}")
            for key, matrix in zip(keys, (robot.added_mass, robot.linear, robot.quadratic), strict=True):
                assert matrix is not None
                if matrix[i, j] != 0.0:
                    _put(plugin, key, numbers(-matrix[i, j]))


def _propeller(model: Xml.Element, thruster: Thruster, lump: Lump, space: str, found: Found, where: str) -> None:
    """Put a link on a joint, and the system that pushes along its axis."""
    link = _put(model, "link", name=f"{thruster.name}_propeller")
    _pose(link, Pose(thruster.position_m, np.eye(3)))
    _inertial(link, Lump(lump.mass_kg, np.zeros(3), lump.inertia_kg_m2))
    joint = _put(model, "joint", name=f"{thruster.name}_joint", type="revolute")
    _put(joint, "parent", BASE)
    _put(joint, "child", f"{thruster.name}_propeller")
    axis = _put(joint, "axis")
    _put(axis, "xyz", numbers(thruster.axis))
    limit = _put(axis, "limit")
    _put(limit, "lower", "-1e16")
    _put(limit, "upper", "1e16")
    low, high = ends_n(thruster)
    plugin = _put(model, "plugin", filename="gz-sim-thruster-system", name="gz::sim::systems::Thruster")
    hand = 1.0 if thruster.clockwise else -1.0
    coefficient = hand * (thruster.bollard_coefficient or 0.0) / (4.0 * np.pi**2)  # of radians, not of revolutions
    for key, value in (
        ("namespace", space), ("joint_name", f"{thruster.name}_joint"), ("thrust_coefficient", numbers(coefficient)),
        ("fluid_density", numbers(found.density_kg_m3)), ("propeller_diameter", numbers(thruster.diameter_m)),
        ("min_thrust_cmd", numbers(low)), ("max_thrust_cmd", numbers(high)), ("use_angvel_cmd", "false"),
    ):  # fmt: skip
        _put(plugin, key, value)
    found.left_out(f"{where}: curves and lags of its thrusters: commands there are newtons, between the same ends")


def _sensor(link: Xml.Element, name: str, sensor: dict[str, Any], found: Found, where: str) -> None:
    kind = SENSORS.get(sensor["kind"])
    if kind is None:
        found.left_out(f"{where}: sensor '{name}', of kind {sensor['kind']}")
        return
    part = _part(link, name, kind, Pose(np.array(sensor["position_m"]), sensor["turn"]), sensor["rate_hz"])
    if kind == "custom":
        part.set("gz:type", "dvl")
        found.left_out(f"{where}: the beams of sensor '{name}': gz-sim's DVL has its own")
    if sensor["kind"] != "imu":
        if any(sensor["std"].values()):
            found.left_out(f"{where}: errors of sensor '{name}'")
        return
    imu = _put(part, "imu")
    for channel in ("angular_velocity", "linear_acceleration"):
        if std := sensor["std"].get(channel):
            group = _put(imu, channel)
            for axis in "xyz":
                noise = _put(_put(group, axis), "noise", type="gaussian")
                _put(noise, "mean", "0")
                _put(noise, "stddev", numbers(std))


def _part(link: Xml.Element, name: str, kind: str, at: Pose, rate_hz: float) -> Xml.Element:
    part = _put(link, "sensor", name=name, type=kind)
    _pose(part, at)
    _put(part, "always_on", "1")
    _put(part, "update_rate", numbers(rate_hz))
    return part


def _camera(link: Xml.Element, name: str, camera: dict[str, Any]) -> None:
    inner = _put(_part(link, name, "camera", camera["at"], 10.0), "camera")
    _put(inner, "horizontal_fov", numbers(np.radians(camera["field_of_view_deg"])))
    image = _put(inner, "image")
    _put(image, "width", str(camera["width"]))
    _put(image, "height", str(camera["height"]))
    clip = _put(inner, "clip")
    _put(clip, "near", "0.05")
    _put(clip, "far", "100")


def _lidar(link: Xml.Element, fan: Fan) -> None:
    turn: Floats = turned(0.0, np.radians(fan.tilt_deg), 0.0)
    lidar = _put(_part(link, "multibeam", "gpu_lidar", Pose(fan.position_m, turn), fan.rate_hz), "lidar")
    across = _put(_put(lidar, "scan"), "horizontal")
    half = np.radians(fan.width_deg) / 2.0
    for key, value in (("samples", fan.beams), ("min_angle", -half), ("max_angle", half)):
        _put(across, key, numbers(value))
    reach = _put(lidar, "range")
    _put(reach, "min", "0.1")
    _put(reach, "max", numbers(fan.range_max_m))
