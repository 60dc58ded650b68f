"""Vehicles and worlds in SDF, as Gazebo flies them by its systems Buoyancy, Hydrodynamics, Thruster and LiftDrag.

Sources: the SDF specification (sdformat.org/spec), and gz-sim's documentation and sources of these systems. Thrust is
along the joint's axis; hydrodynamic forces act at the link's origin; buoyancy at the centre of the collision shapes.
"""

from __future__ import annotations

import os
from functools import cached_property
from pathlib import Path

import numpy as np

from uwsim.evidence.robots import shapes
from uwsim.evidence.robots.checkout import checkout_of
from uwsim.evidence.robots.links import Frames, Joint, Links, inertia, summed_volume
from uwsim.evidence.robots.robot import Found, Lump, Mesh, Robot, plain_name
from uwsim.evidence.robots.sensors import put_gz_sensor
from uwsim.evidence.robots.systems import moves, put_plugins
from uwsim.evidence.robots.uuv_plugins import uuv_current_m_s
from uwsim.evidence.robots.xml_file import HERE, Element, Floats, Pose, read_xml

DENSITY_KG_M3 = 1000.0
"""gz-sim's default of Buoyancy."""
RESOURCE_PATHS = ("GZ_SIM_RESOURCE_PATH", "IGN_GAZEBO_RESOURCE_PATH", "GAZEBO_MODEL_PATH")
MARKS = ("package.xml", "model.sdf", "model.config")
"""Files that make a folder a ROS package or a model."""
LEVEL, BED_M = 0.999, -0.5
"""A plane is a bed if it is level and below this height."""
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
        with reader.found.beside(model):
            at = model.pose()
            reader.model(model, Pose(at.position_m - (0.0, 0.0, ALONE_M), at.turn), static=False)
        reader.found.assumed(f"a model without a world starts {ALONE_M:g} m below its place")
    for document in [root, *reader.included]:
        reader.found.note_unused(document)
    if world is not None and not (reader.found.refusals or reader.found.robots or reader.found.obstacles):
        if reader.found.bed_z_m is None:
            reader.found.assumed("nothing fixed of this world is here: it is its water over a flat bed")
        return reader.found
    reader.found.require_any(
        root, "has no model with a thruster (gz-sim-thruster-system), and no fixed model that is here"
    )
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
            if (current := plugin.find("constant_current")) is not None:
                with self.found.beside(plugin):
                    self.found.current_m_s = uuv_current_m_s(current)
        for model in world.all("model"):
            with self.found.beside(model):
                self.model(model, model.pose(), static=model.text("static") in ("1", "true"))
        for include in world.all("include"):
            with self.found.beside(include):
                self._include(include)
        for tag in ("light", "road", "population", "actor"):
            for element in world.all(tag):
                self.found.dropped(element)

    def _include(self, include: Element) -> None:
        model = self._included(include)
        if model is not None:
            static = (include.text("static") or model.text("static")) in ("1", "true")
            pose = include.pose() if include.find("pose") else model.pose()
            self.model(model, pose, static=static, include=include)

    def _included(self, include: Element) -> Element | None:
        """Return the model that an <include> names, or None, with a note, if there is none here."""
        uri = include.text("uri") or ""
        folder = self._resolved(uri, include.file)
        if folder is None:
            self.found.dropped(include, f" {uri}: not beside the file, in its checkout or in {RESOURCE_PATHS[0]}")
            return None
        file = folder / _named_in(folder) if folder.is_dir() else folder
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

    def _resolved(self, uri: str, near: Path) -> Path | None:
        """Return the file or folder of an address in a file, if it is on this machine."""
        scheme, _, name = uri.rpartition("://")
        name = name.strip("/") if scheme else name
        if scheme not in ("", "file", "model", "models", "package"):
            return None
        listed = [folder for key in RESOURCE_PATHS for folder in os.environ.get(key, "").split(os.pathsep) if folder]
        here = self.path.resolve().parent
        beside = [near.resolve().parent, here, here.parent, here / "models", here.parent / "models"]
        for folder in [*beside, *map(Path, listed)]:
            if (folder / name).exists():
                return folder / name
        first, _, rest = name.partition("/")
        model = self._models.get(first)
        return model / rest if model is not None and (model / rest).exists() else None

    @cached_property
    def _models(self) -> dict[str, Path]:
        """The folders of models and of ROS packages in the file's checkout, by name."""
        checkout = checkout_of(self.path)
        found = [] if checkout is None else [each for name in MARKS for each in sorted(checkout.rglob(name))]
        return {mark.parent.name: mark.parent for mark in found}

    def model(self, model: Element, pose: Pose, *, static: bool, include: Element | None = None) -> None:
        """Read a model at a pose in the world. include: what names it, whose plugins are added to its own."""
        own = [*model.all("plugin"), *(() if include is None else include.all("plugin"))]
        if not any(moves(plugin) for plugin in own):
            with self.found.beside(model):
                self._obstacles(model, pose, static)
            return
        with self.found.vehicle(model):
            name = None if include is None else include.text("name")
            self._vehicle(model, pose, plain_name(name or model.name, [robot.name for robot in self.found.robots]), own)

    def _vehicle(self, model: Element, pose: Pose, name: str, plugins: list[Element]) -> None:
        links = self._links(model, HERE)
        for missing in links.missing:
            self.found.left_out(missing)
        base = links.base(self.found)
        robot = Robot(name, pose.then(links.poses[base]))
        self.found.robots.append(robot)
        links.put_into(robot, base)
        self._buoyancy(robot)
        put_plugins(robot, self.found, plugins, links, base)
        to_base = links.poses[base].inverse()
        for link in model.all("link"):
            for sensor in link.all("sensor"):
                with self.found.beside(sensor):
                    at = to_base.then(links.poses[link.needed("name")]).then(sensor.pose())
                    put_gz_sensor(robot, self.found, sensor, at)

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
            links.joints[joint.name] = self._joint(joint, links, frames, at)
        return links

    def _joint(self, joint: Element, links: Links, frames: Frames, at: Pose) -> Joint:
        child, parent = joint.text("child") or "", joint.text("parent") or ""
        links.pose(child, joint)
        there = at.then(frames.pose(joint.name, joint))
        xyz = joint.numbers("axis/xyz", 3)
        axis = self._axes(joint, frames, at, there) @ (np.array([0.0, 0.0, 1.0]) if xyz is None else xyz)
        limits = joint.number("axis/limit/lower", -np.inf), joint.number("axis/limit/upper", np.inf)
        return Joint(joint.name, joint.attribute("type") or "", parent, child, there, axis, limits)

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
            file = self._resolved(shape.text("uri") or "", shape.file)
            if file is None or not file.is_file():
                rule = f"{shape.text('uri')!r}: not in {RESOURCE_PATHS[0]}, beside the file or in its checkout"
                links.missing.append(str(shape.error(rule)))
                return None
            scale = shape.numbers("scale", 3)
            with self.found.beside(shape):
                mesh = shapes.from_file(file, np.ones(3) if scale is None else scale)
                return shapes.closed(mesh, shape.path) if links.is_vehicle else mesh
            return None
        if shape.tag != "plane" or links.is_vehicle:
            self.found.left_out(f"{shape.path}: shapes of this kind")
        return None

    def _obstacles(self, model: Element, pose: Pose, static: bool) -> None:
        if not static:
            self.found.dropped(model, ": it moves, and has no thrusters")
            return
        links = self._links(model, HERE, heavy=False)
        for missing in links.missing:
            self.found.left_out(missing)
        for link in model.all("link"):
            for collision in link.all("collision"):
                if (plane := collision.find("geometry/plane")) is not None:
                    self._plane(plane, pose.then(links.poses[link.needed("name")]).then(collision.pose()))
        for key, solids in links.solids.items():
            for solid in solids:
                name = self.found.body_name(model.name)
                self.found.meshes[name] = shapes.placed(solid, pose.then(links.poses[key]))
                self.found.obstacles.append(
                    {"kind": "mesh", "name": name, "file": f"{name}.ply", "position_m": [0.0, 0.0, 0.0]}
                )

    def _plane(self, plane: Element, at: Pose) -> None:
        """Read a level plane under water as the bed, the deepest of several."""
        normal, height_m = plane.numbers("normal", 3), float(at.position_m[2])
        up = at.turn @ (np.array([0.0, 0.0, 1.0]) if normal is None else normal / np.linalg.norm(normal))
        if not up[2] > LEVEL or height_m > BED_M:
            self.found.left_out(f"{plane.path}: at {height_m:g} m, it is no bed under water")
            return
        self.found.bed_z_m = height_m if self.found.bed_z_m is None else min(height_m, self.found.bed_z_m)

    def _buoyancy(self, robot: Robot) -> None:
        if not robot.solids:
            raise ValueError(f"'{self.path}': model '{robot.name}' has no collision shapes, which Buoyancy needs")
        robot.volume_m3, robot.centre_of_buoyancy_m = summed_volume(robot.solids)


def _named_in(folder: Path) -> str:
    """Return the description's name in a model's folder: that for the latest version, as model.config states."""
    if (folder / "model.config").is_file() and not (folder / "model.sdf").is_file():
        versions = [
            (each.attribute("version") or "", each.text()) for each in read_xml(folder / "model.config").all("sdf")
        ]
        if versions:
            return max(versions)[1] or "model.sdf"
    return "model.sdf"
