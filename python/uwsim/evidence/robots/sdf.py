"""Vehicles and worlds in SDF, as Gazebo flies them by its systems Buoyancy, Hydrodynamics, Thruster and LiftDrag.

Sources: the SDF specification (sdformat.org/spec), and gz-sim's documentation and sources of these systems. Thrust is
along the joint's axis; hydrodynamic forces act at the link's origin; buoyancy at the centre of the collision shapes.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from uwsim.evidence.robots import shapes
from uwsim.evidence.robots.lift_drag import is_lift_drag, put_surface
from uwsim.evidence.robots.links import Frames, Joint, Links, inertia, summed_volume
from uwsim.evidence.robots.robot import Found, Lump, Mesh, Robot, Thruster, plain_name
from uwsim.evidence.robots.sensors import Errors, put_camera, put_sensor
from uwsim.evidence.robots.uuv_plugins import is_uuv_object, is_uuv_thruster, put_uuv_object, uuv_thruster
from uwsim.evidence.robots.xml_file import HERE, Element, Floats, Pose, read_xml

ROWS, COLUMNS = "xyzkmn", "UVWPQR"
DENSITY_KG_M3, THRUST_N, DIAMETER_M = 1000.0, 1000.0, 0.02
"""gz-sim's defaults: of Buoyancy, and of Thruster's limits and propeller."""
RESOURCE_PATHS = ("GZ_SIM_RESOURCE_PATH", "IGN_GAZEBO_RESOURCE_PATH", "GAZEBO_MODEL_PATH")
SENSORS = {"imu": "imu", "magnetometer": "compass", "air_pressure": "pressure", "altimeter": "depth", "dvl": "dvl"}
LEVELS, ALONE_M = 8, 2.0
"""Models within models, at most; depth of a model without a world."""


def read_sdf(path: Path, found: Found | None = None) -> Found:
    """Return the vehicles and fixed obstacles of an SDF file, of a model or a world, in `found` if given.

    Raises ValueError or OSError.
    """
    root = read_xml(path)
    if root.tag != "sdf":
        raise root.error("must be <sdf>")
    world = root.find("world")
    reader = _Reader(path, found or Found(""))
    reader.found.name = plain_name(path.parent.name if path.stem == "model" else path.stem)
    if world is not None:
        reader.found.name = plain_name(world.name)
        reader.world(world)
    for model in root.all("model"):
        at = model.pose()
        reader.model(model, Pose(at.position_m - (0.0, 0.0, ALONE_M), at.turn), static=False)
        reader.found.assumed(f"a model without a world starts {ALONE_M:g} m below its place")
    if not (reader.found.robots or reader.found.obstacles):
        raise root.error("has no model with a thruster (gz-sim-thruster-system), and no fixed model that is here")
    for document in [root, *reader.included]:
        reader.found.note_unused(document)
    return reader.found


class _Reader:
    def __init__(self, path: Path, found: Found) -> None:
        self.path, self.found = path, found
        self.included: list[Element] = []

    def world(self, world: Element) -> None:
        for plugin in world.all("plugin"):
            if "buoyancy" in (plugin.attribute("filename") or "").lower():
                default = plugin.number("graded_buoyancy/default_density", DENSITY_KG_M3)
                self.found.density_kg_m3 = plugin.number("uniform_fluid_density", default)
        for model in world.all("model"):
            self.model(model, model.pose(), static=model.text("static") in ("1", "true"))
        for include in world.all("include"):
            model_of = self._included(include)
            if model_of is not None:
                static = (include.text("static") or model_of.text("static")) in ("1", "true")
                pose = include.pose() if include.find("pose") else model_of.pose()
                self.model(model_of, pose, static=static, include=include)
        for tag in ("light", "road", "population", "actor"):
            for element in world.all(tag):
                self.found.dropped(element)

    def _included(self, include: Element) -> Element | None:
        """Return the model that an <include> names, or None, with a note, if there is none here."""
        uri = include.text("uri") or ""
        folder = self._resolved(uri)
        if folder is None:
            self.found.dropped(include, f" {uri}: not in {', '.join(RESOURCE_PATHS[:1])} or beside the file")
            return None
        file = folder / "model.sdf" if folder.is_dir() else folder
        if not file.is_file():
            self.found.dropped(include, f" {uri}: '{folder}' has no model.sdf")
            return None
        document = read_xml(file)
        model = document.find("model")
        if model is None:
            self.found.dropped(include, f" {uri}: '{file}' has no <model>")
        else:
            self.included.append(document)
        return model

    def _resolved(self, uri: str) -> Path | None:
        """Return the file or folder of an address, if it is on this machine."""
        name = uri.removeprefix("model://").removeprefix("file://")
        if "://" in name:
            return None
        listed = [folder for key in RESOURCE_PATHS for folder in os.environ.get(key, "").split(os.pathsep) if folder]
        here = self.path.resolve().parent
        for folder in [here, here.parent, here / "models", here.parent / "models", *map(Path, listed)]:
            if (folder / name).exists():
                return folder / name
        return None

    def model(self, model: Element, pose: Pose, *, static: bool, include: Element | None = None) -> None:
        """Read a model at a pose in the world. include: what names it, whose plugins are added to its own."""
        own = [*model.all("plugin"), *(() if include is None else include.all("plugin"))]
        plugins = [(plugin, (plugin.attribute("filename") or "").lower()) for plugin in own]
        thrusters = [(plugin, file) for plugin, file in plugins if "thruster" in file]
        if not thrusters:
            self._obstacles(model, pose, static)
            return
        links = self._links(model, HERE)
        if links.missing:
            raise ValueError(links.missing[0])
        others = [robot.name for robot in self.found.robots]
        base = links.base()
        name = None if include is None else include.text("name")
        robot = Robot(plain_name(name or model.name, others), pose.then(links.poses[base]))
        links.put_into(robot, base)
        self._buoyancy(robot)
        for plugin, file in plugins:
            if is_uuv_object(file):
                put_uuv_object(robot, self.found, plugin, base)
            elif "hydrodynamics" in file:
                self._hydrodynamics(robot, plugin, base, links)
            elif "thruster" not in file and not is_lift_drag(file):
                self.found.dropped(plugin, f", {plugin.attribute('filename')}")
        to_base = links.poses[base].inverse()
        for plugin, file in plugins:
            if is_lift_drag(file):
                put_surface(robot, plugin, links, to_base, self.found)
        limits = dict(_autopilot_limits(model))
        for plugin, file in thrusters:
            if is_uuv_thruster(file):
                robot.thrusters.append(uuv_thruster(plugin, links, to_base, robot, self.found))
            else:
                robot.thrusters.append(self._thruster(plugin, links, to_base, limits, robot))
        for link in model.all("link"):
            for sensor in link.all("sensor"):
                self._sensor(robot, sensor, to_base.then(links.poses[link.needed("name")]).then(sensor.pose()))
        self.found.robots.append(robot)

    def _links(self, model: Element, at: Pose, level: int = 0, *, heavy: bool = True) -> Links:
        """Return the links of a model and of those in it, in the frame of the outermost. heavy: with their masses."""
        if level == LEVELS:
            raise model.error(f"is {LEVELS} models deep: must be fewer")
        links, inner = Links(model, is_vehicle=heavy), [(each, each.name, each.pose()) for each in model.all("model")]
        for include in model.all("include"):
            named = self._included(include)
            if named is not None:
                place = include.pose() if include.find("pose") else named.pose()
                inner.append((named, include.text("name") or named.name, place))
        for each, name, place in inner:
            links.add(name, self._links(each, at.then(place), level + 1, heavy=heavy))
        frames = Frames(model, {key: at.inverse().then(pose) for key, pose in links.poses.items()})
        for link in model.all("link"):
            key = link.needed("name")
            links.poses[key] = at.then(frames.pose(key, link))
            inertial = link.find("inertial")
            if heavy and inertial is not None:
                own = inertial.pose()
                moments = inertia(inertial.find("inertia"), lambda e, k: e.number(k, 0.0))
                mass = inertial.number("mass", 1.0)
                links.lumps[key] = Lump(mass, own.position_m, own.turn @ moments @ own.turn.T)
            solids = [self._solid(collision, links) for collision in link.all("collision")]
            links.solids[key] = [solid for solid in solids if solid is not None]
        for joint in model.all("joint"):
            child = joint.text("child") or ""
            links.pose(child, joint)
            there = at.then(frames.pose(joint.name, joint))
            xyz = joint.numbers("axis/xyz", 3)
            axis = self._axes(joint, frames, at, there) @ (np.array([0.0, 0.0, 1.0]) if xyz is None else xyz)
            kind = joint.attribute("type") or ""
            limits = joint.number("axis/limit/lower", -np.inf), joint.number("axis/limit/upper", np.inf)
            links.joints[joint.name] = Joint(joint.name, kind, joint.text("parent") or "", child, there, axis, limits)
        return links

    def _axes(self, joint: Element, frames: Frames, at: Pose, there: Pose) -> Floats:
        """Return the rotation from the axes in which a joint's axis is stated, by default its own."""
        stated = joint.find("axis/xyz")
        frame = None if stated is None else stated.attribute("expressed_in")
        if joint.text("axis/use_parent_model_frame") in ("1", "true"):
            frame = "__model__"
        return there.turn if frame is None else at.turn @ frames.pose(frame, joint).turn

    def _solid(self, collision: Element, links: Links) -> Mesh | None:
        geometry = collision.find("geometry")
        if geometry is None:
            raise collision.error("has no geometry")
        for shape in geometry.all("*"):
            solid = self._shape(shape, links)
            if solid is not None and shapes.displaces(solid):
                return shapes.placed(solid, collision.pose())
        return None

    def _shape(self, shape: Element, links: Links) -> Mesh | None:
        if shape.tag == "box":
            size = shape.numbers("size", 3)
            if size is None or not shapes.are_sizes(*size):
                raise shape.error("its size must be three positive numbers [m]")
            return shapes.box(size)
        if shape.tag in ("sphere", "cylinder", "capsule"):
            radius = shape.number("radius")
            length = 1.0 if shape.tag == "sphere" else shape.number("length")
            if not shapes.are_sizes(radius, length):
                raise shape.error(f"radius and length must be positive, at most {shapes.SIZE_MAX_M:g} m")
            if shape.tag == "sphere":
                return shapes.sphere(radius)
            return (shapes.cylinder if shape.tag == "cylinder" else shapes.capsule)(radius, length)
        if shape.tag == "ellipsoid":
            radii = shape.numbers("radii", 3)
            if radii is None or not shapes.are_sizes(*radii):
                raise shape.error("its radii must be three positive numbers [m]")
            return shapes.ellipsoid(radii)
        if shape.tag == "mesh":
            file = self._resolved(shape.text("uri") or "")
            if file is None or not file.is_file():
                rule = f"{shape.text('uri')!r}: not in {RESOURCE_PATHS[0]} or beside the file"
                links.missing.append(str(shape.error(rule)))
                return None
            scale = shape.numbers("scale", 3)
            mesh = shapes.from_file(file, np.ones(3) if scale is None else scale)
            return shapes.closed(mesh, shape.path) if links.is_vehicle else mesh
        self.found.left_out(f"{shape.path}: shapes of this kind")
        return None

    def _obstacles(self, model: Element, pose: Pose, static: bool) -> None:
        if not static:
            self.found.dropped(model, ": it moves, and has no thrusters")
            return
        links = self._links(model, HERE, heavy=False)
        for missing in links.missing:
            self.found.left_out(missing)
        for key, solids in links.solids.items():
            for solid in solids:
                name = plain_name(model.name, [item["name"] for item in self.found.obstacles])
                self.found.meshes[name] = shapes.placed(solid, pose.then(links.poses[key]))
                self.found.obstacles.append(
                    {"kind": "mesh", "name": name, "file": f"{name}.ply", "position_m": [0.0, 0.0, 0.0]}
                )

    def _buoyancy(self, robot: Robot) -> None:
        if not robot.solids:
            raise ValueError(f"'{self.path}': model '{robot.name}' has no collision shapes, which Buoyancy needs")
        robot.volume_m3, robot.centre_of_buoyancy_m = summed_volume(robot.solids)

    def _hydrodynamics(self, robot: Robot, plugin: Element, base: str, links: Links) -> None:
        if (name := plugin.text("link_name")) != base:
            links.pose(name or "", plugin)
            raise plugin.error(f"acts on link '{name}': must be the base link, '{base}'")
        if self.found.density_kg_m3 is None and plugin.find("water_density"):
            self.found.density_kg_m3 = plugin.number("water_density")
        added, linear, quadratic = np.zeros((6, 6)), np.zeros((6, 6)), np.zeros((6, 6))
        known = set()
        for i, row in enumerate(ROWS):
            for j, column in enumerate(COLUMNS):
                square = f"{row}{column}abs{column}"
                for matrix, key in ((added, f"{row}Dot{column}"), (linear, f"{row}{column}"), (quadratic, square)):
                    known.add(key)
                    matrix[i, j] = -plugin.number(key, 0.0)
                    if i == j and matrix[i, j] < 0.0:
                        raise plugin.error(f"{key} = {-matrix[i, j]:g}: must not be positive: it would drive the hull")
        for element in plugin.all("*"):
            derivative = element.tag[:1] in ROWS and any(column in element.tag[1:] for column in COLUMNS)
            if derivative and element.tag not in known and element.number(None) != 0.0:
                self.found.left_out(f"{element.path} = {element.text()}")
        if plugin.text("disable_added_mass") in ("1", "true"):
            added[:] = 0.0
        robot.added_mass, robot.linear, robot.quadratic = added, linear, quadratic
        self.found.current_m_s = plugin.numbers("default_current", 3)

    def _thruster(
        self, plugin: Element, links: Links, to_base: Pose, limits: dict[str, tuple[float, float]], robot: Robot
    ) -> Thruster:
        joint = links.joint(plugin.text("joint_name") or "", plugin)
        low, high = limits.get(joint.name, (-THRUST_N, THRUST_N))
        low, high = plugin.number("min_thrust_cmd", low), plugin.number("max_thrust_cmd", high)
        if not low <= 0.0 < high:
            raise plugin.error(f"thrust from {low:g} to {high:g} N: must include 0, and some thrust ahead")
        if joint.name not in limits and not plugin.find("max_thrust_cmd"):
            self.found.assumed(f"{plugin.path}: limits of {-THRUST_N:g} and {THRUST_N:g} N, gz-sim's defaults")
        coefficient = plugin.number("thrust_coefficient", 1.0)
        name = plain_name(joint.name.removesuffix("_joint"), [each.name for each in robot.thrusters])
        pairs = [(-1.0, low), (0.0, 0.0), (1.0, high)]
        if plugin.text("use_angvel_cmd") in ("1", "true", "True"):
            steps = np.linspace(-1.0, 1.0, 21)
            pairs = [(float(x), float((high if x > 0.0 else -low) * x * abs(x))) for x in steps]
        return Thruster(
            name,
            to_base.then(joint.pose).position_m,
            to_base.turn @ joint.axis,
            pairs,
            0.0,
            plugin.number("propeller_diameter", DIAMETER_M),
            abs(coefficient) * 4.0 * np.pi**2,  # gz: rho k D^4 omega^2, omega in rad/s; here by revolutions
            clockwise=coefficient > 0.0,
        )

    def _sensor(self, robot: Robot, sensor: Element, at: Pose) -> None:
        kind, rate = sensor.needed("type"), sensor.number("update_rate", 10.0)
        if kind == "camera":
            camera = sensor.find("camera")
            angle = 1.047 if camera is None else camera.number("horizontal_fov", 1.047)
            width, height = (
                (320.0, 240.0)
                if camera is None
                else (camera.number("image/width", 320.0), camera.number("image/height", 240.0))
            )
            put_camera(robot, sensor.name, at, float(np.degrees(angle)), (int(width), int(height)))
        elif kind in ("gpu_lidar", "lidar", "ray", "gpu_ray"):
            robot.sonar = at.position_m.tolist()
            self.found.assumed(f"{sensor.path}: its place is the multibeam's mount")
        elif kind in SENSORS or (kind == "custom" and "dvl" in (sensor.attribute("gz:type") or sensor.name)):
            mine = SENSORS.get(kind, "dvl")
            put_sensor(robot, self.found, sensor.path, sensor.name, mine, at, rate, _errors(sensor, kind))
        else:
            self.found.dropped(sensor, f", of type {kind}")


def _errors(sensor: Element, kind: str) -> Errors:
    """Return the white noise of an IMU, the largest of its axes, as in a vehicle's file."""
    if kind != "imu":
        return {}
    channels = {
        channel: {"std": max(sensor.number(f"imu/{channel}/{axis}/noise/stddev", 0.0) for axis in "xyz")}
        for channel in ("angular_velocity", "linear_acceleration")
    }
    stated = {channel: errors for channel, errors in channels.items() if errors["std"] > 0.0}
    return {"channels": stated} if stated else {}


def _autopilot_limits(model: Element) -> Iterator[tuple[str, tuple[float, float]]]:
    """Yield the joints that ArduPilot's plugin drives by force, and their thrusts at its lowest and highest output."""
    for plugin in model.all("plugin"):
        for control in plugin.all("control"):
            if control.text("type") == "COMMAND" and "cmd_thrust" in (control.text("cmd_topic") or ""):
                multiplier, offset = control.number("multiplier", 1.0), control.number("offset", 0.0)
                low, high = sorted((multiplier * offset, multiplier * (1.0 + offset)))
                yield control.text("jointName") or "", (low, high)
