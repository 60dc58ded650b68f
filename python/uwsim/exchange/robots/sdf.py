"""Vehicles and worlds in SDF, as Gazebo flies them by its systems Buoyancy, Hydrodynamics, Thruster and LiftDrag.

Sources: the SDF specification (sdformat.org/spec), and gz-sim's documentation and sources of these systems. Thrust is
along the joint's axis; hydrodynamic forces act at the link's origin; buoyancy at the centre of the collision shapes.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from uwsim.exchange.robots import shapes
from uwsim.exchange.robots.floors import put_plane
from uwsim.exchange.robots.links import Frames, Links, carried, summed_volume, unit
from uwsim.exchange.robots.robot import Description, Robot, plain_name
from uwsim.exchange.robots.sdf_models import Models
from uwsim.exchange.robots.sensors import put_gz_sensor
from uwsim.exchange.robots.systems import DENSITY_KG_M3, moves, put_plugins
from uwsim.exchange.robots.uuv_plugins import uuv_current_m_s
from uwsim.exchange.robots.xml_file import Element, Pose, is_yes

ALONE_M = 2.0
"""Depth of a model without a world."""


def read_sdf(path: Path, found: Description | None = None) -> Description:
    """Return the vehicles and fixed obstacles of an SDF file, of a model or a world, in `found` if given.

    Raises ValueError or OSError.
    """
    reader = _Reader(path, found or Description(""))
    root = reader.document(path)
    if root.tag != "sdf":
        raise root.error("must be <sdf>")
    world = root.find("world")
    reader.found.name = plain_name(path.parent.name if path.stem == "model" else path.stem)
    if world is not None:
        reader.found.name = plain_name(world.name)
        reader.world(world)
    for model in root.all("model"):
        with reader.found.beside(model):
            at = model.pose()
            reader.model(model, Pose(at.position_m - (0.0, 0.0, ALONE_M), at.turn), static=False)
        reader.found.assumed(f"a model without a world starts {ALONE_M:g} m below its place")
    for document in reader.documents:
        reader.found.note_unused(document)
    if world is not None and not (reader.found.refusals or reader.found.robots or reader.found.obstacles):
        if reader.found.bed_z_m is None:
            reader.found.assumed("nothing fixed of this world is here: it is its water over a flat bed")
        return reader.found
    reader.found.require_any(
        root, "has no model with a thruster (gz-sim-thruster-system), and no fixed model that is here"
    )
    return reader.found


class _Reader(Models):
    def __init__(self, path: Path, found: Description) -> None:
        super().__init__(path, found)
        self._buoyant: set[str] = set()

    def world(self, world: Element) -> None:
        for plugin in world.all("plugin"):
            if "buoyancy" in (plugin.attribute("filename") or "").lower():
                default = plugin.number("graded_buoyancy/default_density", DENSITY_KG_M3)
                self.found.density_kg_m3 = plugin.number("uniform_fluid_density", default)
                self._buoyant |= {each.text() or "" for each in plugin.all("enable")}
            if (current := plugin.find("constant_current")) is not None:
                with self.found.beside(plugin):
                    self.found.current_m_s = uuv_current_m_s(current)
        frames = Frames(world)
        for model in world.all("model"):
            with self.found.beside(model):
                self.model(model, frames.of(model), static=is_yes(model.text("static")))
        for include in world.all("include"):
            with self.found.beside(include):
                self._include(include, frames)
        for tag in ("light", "road", "population", "actor"):
            for element in world.all(tag):
                self.found.dropped(element)

    def _include(self, include: Element, frames: Frames) -> None:
        model = self.included(include)
        if model is not None:
            static = is_yes(include.text("static") or model.text("static"))
            pose = frames.of(include) if include.find("pose") else model.pose()
            self.model(model, pose, static=static, include=include)

    def model(self, model: Element, pose: Pose, *, static: bool, include: Element | None = None) -> None:
        """Read a model at a pose in the world. include: what names it, whose plugins are added to its own."""
        own = list(self.plugins(model, include))
        if not any(moves(plugin) for plugin in own):
            with self.found.beside(model):
                self._obstacles(model, pose, static, include, own)
            return
        with self.found.vehicle(model):
            try:
                self._vehicle(model, pose, include, own)
            except (ValueError, OSError):
                for plugin in own:
                    self.found.left_out(f"{plugin.path}, {plugin.attribute('filename')}: its vehicle cannot be used")
                raise

    def _vehicle(self, model: Element, pose: Pose, include: Element | None, plugins: list[Element]) -> None:
        links = self.links(model, include)
        for missing in links.missing:
            self.found.left_out(missing)
        base, named = links.base(self.found), None if include is None else include.text("name")
        name = plain_name(named or model.name, [robot.name for robot in self.found.robots])
        robot = Robot(name, links.placed(pose, model).then(links.poses[base]))
        self.found.robots.append(robot)
        links.put_into(robot, base)
        self._buoyancy(robot, links, base, named or model.name)
        put_plugins(robot, self.found, plugins, links, base)
        to_base = links.poses[base].inverse()
        for key, matrix in links.added_mass.items():
            there = carried(matrix, to_base.then(links.poses[key]))
            robot.added_mass = there if robot.added_mass is None else robot.added_mass + there
        for sensor, at in links.sensors:
            with self.found.beside(sensor):
                put_gz_sensor(robot, self.found, sensor, to_base.then(at))

    def _obstacles(
        self, model: Element, pose: Pose, static: bool, include: Element | None, plugins: list[Element]
    ) -> None:
        if not static:
            files = ", ".join(f"'{plugin.attribute('filename')}'" for plugin in plugins)
            self.found.dropped(model, f": it moves, and has no thrusters{': none is in ' if files else ''}{files}")
            return
        links = self.links(model, include, heavy=False)
        pose = links.placed(pose, model)
        for missing in links.missing:
            self.found.left_out(missing)
        for plane, at in links.planes:
            there, normal = pose.then(at), plane.numbers("normal", 3)
            up = there.turn @ (np.eye(3)[2] if normal is None else unit(normal, plane))
            put_plane(self.found, plane.path, there.position_m, up)
        for key, solids in links.solids.items():
            for solid in solids:
                name = self.found.body_name(model.name)
                self.found.meshes[name] = shapes.placed(solid, pose.then(links.poses[key]))
                self.found.obstacles.append(
                    {"kind": "mesh", "name": name, "file": f"{name}.ply", "position_m": [0.0, 0.0, 0.0]}
                )

    def _buoyancy(self, robot: Robot, links: Links, base: str, model: str) -> None:
        """Set what displaces water: all solids, or those of the links that the world's plugin enables."""
        if not robot.solids:
            raise ValueError(f"'{self.path}': model '{robot.name}' has no collision shapes, which Buoyancy needs")
        floats = {
            key for key in links.solids
            if not self._buoyant or any(f"{model}::{key}::".startswith(f"{name}::") for name in self._buoyant)
        }  # fmt: skip
        to_base = links.poses[base].inverse()
        solids = [
            shapes.placed(each, to_base.then(links.poses[key]))
            for key in links.solids
            if key in floats
            for each in links.solids[key]
        ]
        if not solids:
            raise ValueError(f"'{self.path}': Buoyancy enables none of the links of model '{robot.name}'")
        robot.volume_m3, robot.centre_of_buoyancy_m = summed_volume(solids)
