"""Models of SDF: their files, the links, joints and frames in them, and the shapes of their links.

Source: the SDF specification (sdformat.org/spec), and libsdformat's conversions of its older versions.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from functools import cache, cached_property
from pathlib import Path

import numpy as np

from uwsim.exchange.robots import shapes
from uwsim.exchange.robots.links import Frames, Inner, Joint, Links, inertia, unit
from uwsim.exchange.robots.robot import Description, Lump, Mesh, merged
from uwsim.exchange.robots.sources import checkout_of
from uwsim.exchange.robots.xml_file import Element, Floats, Pose, is_yes, read_xml

RESOURCE_PATHS = ("GZ_SIM_RESOURCE_PATH", "IGN_GAZEBO_RESOURCE_PATH", "GAZEBO_MODEL_PATH")
MARKS = ("package.xml", "model.sdf", "model.config")
"""Files that make a folder a ROS package or a model."""
LEVELS = 8
"""Models within models, at most."""
AXES_OF_JOINTS = (1, 5)
"""The version from which a joint's axis is in the joint's frame, in place of the model's."""
DENSITY_KG_M3 = 1000.0
"""SDF's default of an inertia that follows from shapes."""
ADDED = "xyzpqr"


class Models:
    """Reads the models of a file and of those that it includes."""

    def __init__(self, path: Path, found: Description) -> None:
        self.path, self.found = path, found
        self.documents: list[Element] = []
        self.document = cache(self._document)
        self._old: set[Path] = set()

    def _document(self, path: Path) -> Element:
        """Return the root of a file, and keep it."""
        root = read_xml(path)
        self.documents.append(root)
        version = (root.attribute("version") or "").split(".")
        if all(part.isdecimal() for part in version) and tuple(map(int, version)) < AXES_OF_JOINTS:
            self._old.add(path)
        return root

    def included(self, include: Element) -> Element | None:
        """Return the model that an <include> names, or None, with a note, if there is none here."""
        uri = include.text("uri") or ""
        folder = self.resolved(uri, include.file)
        if folder is None:
            self.found.dropped(include, f" {uri}: not beside the file, in its checkout or in {RESOURCE_PATHS[0]}")
            return None
        file = folder / _named_in(folder) if folder.is_dir() else folder
        if not file.is_file():
            self.found.dropped(include, f" {uri}: '{folder}' has no model.sdf")
            return None
        if include.find("experimental:params") is not None:
            self.found.left_out(f"{include.path}/experimental:params, by which the model '{uri}' differs here")
        model = self.document(file).find("model")
        if model is None:
            self.found.dropped(include, f" {uri}: '{file}' has no <model>")
        return model

    def resolved(self, uri: str, near: Path) -> Path | None:
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

    def plugins(self, model: Element, include: Element | None, level: int = 0) -> Iterator[Element]:
        """Yield the plugins of a model, of what names it, and of the models that are merged with it."""
        yield from model.all("plugin")
        if include is not None:
            yield from include.all("plugin")
        for each in model.all("include"):
            if is_yes(each.attribute("merge")) and level < LEVELS and (merged := self.included(each)) is not None:
                yield from self.plugins(merged, each, level + 1)

    def links(self, model: Element, include: Element | None = None, level: int = 0, *, heavy: bool = True) -> Links:
        """Return the links of a model and of those in it, in its frame. include: what names it. heavy: with masses."""
        if level == LEVELS:
            raise model.error(f"is {LEVELS} models deep: must be fewer")
        inner = [
            Inner(f"{each.name}::", each, self.links(each, None, level + 1, heavy=heavy)) for each in model.all("model")
        ]
        for each in model.all("include"):
            if (named := self.included(each)) is not None:
                prefix = "" if is_yes(each.attribute("merge")) else f"{each.text('name') or named.name}::"
                links = self.links(named, each, level + 1, heavy=heavy)
                inner.append(Inner(prefix, each if each.find("pose") else named, links))
        frames, links = Frames(model, inner), Links(model, is_vehicle=heavy)
        placement = None if include is None else include.text("placement_frame")
        links.placement = placement or model.attribute("placement_frame")
        for prefix, element, within in inner:
            own = prefix.removesuffix("::")
            links.add(prefix, within, frames.pose(own, element) if own else within.placed(frames.of(element), element))
        for link in model.all("link"):
            key = link.needed("name")
            links.poses[key] = frames.pose(key, link)
            self._link(link, key, links, frames)
        for joint in model.all("joint"):
            with self.found.beside(joint):
                links.joints[joint.name] = self._joint(joint, links, frames)
        links.frames = frames.all()
        return links

    def _link(self, link: Element, key: str, links: Links, frames: Frames) -> None:
        links.solids[key], parts = [], []
        at, back = links.poses[key], links.poses[key].inverse()
        for collision in link.all("collision"):
            with self.found.beside(collision):
                place = frames.of(collision, at)
                if (solid := self._solid(collision, links, place)) is not None:
                    links.solids[key].append(shapes.placed(solid, back.then(place)))
                    parts.append(collision)
        for sensor in link.all("sensor"):
            with self.found.beside(sensor):
                links.sensors.append((sensor, frames.of(sensor, at)))
        if links.is_vehicle:
            links.lumps[key] = self._lump(link, list(zip(parts, links.solids[key], strict=True)))
            if (added := link.find("inertial/fluid_added_mass")) is not None:
                matrix = np.array([[added.number(min(a + b, b + a, key=_is_below), 0.0) for b in ADDED] for a in ADDED])
                links.added_mass[key] = matrix
        elif (inertial := link.find("inertial")) is not None:
            inertial.use_all()

    def _lump(self, link: Element, solids: list[tuple[Element, Mesh]]) -> Lump:
        inertial = link.find("inertial")
        if inertial is None:
            self.found.assumed(f"{link.path}: 1 kg, and 1 kg m2 about each axis, SDF's defaults")
            return Lump(1.0, np.zeros(3), np.eye(3))
        if not is_yes(inertial.attribute("auto")):
            own = inertial.pose()
            moments = inertia(inertial.find("inertia"), lambda e, k: e.number(k, float(k[1] == k[2])), 1.0)
            return Lump(inertial.number("mass", 1.0), own.position_m, own.turn @ moments @ own.turn.T)
        if not solids:
            raise inertial.error("auto: the link has no collision shape from which its inertia could follow")
        density = inertial.number("density", DENSITY_KG_M3)
        whole = merged(
            [
                shapes.solid_lump(solid, shapes.volume_and_centre(solid)[0] * collision.number("density", density))
                for collision, solid in solids
            ]
        )
        mass = inertial.number("mass", whole.mass_kg)
        return Lump(mass, whole.centre_m, whole.inertia_kg_m2 * (mass / whole.mass_kg))

    def _joint(self, joint: Element, links: Links, frames: Frames) -> Joint:
        child, parent = (frames.link_of(joint.text(end) or "", joint) for end in ("child", "parent"))
        links.pose(child, joint)
        there, stated = frames.of(joint, frames.pose(joint.text("child") or "", joint)), joint.find("axis")
        axis, limits = there.turn[:, 2], (-np.inf, np.inf)
        if stated is not None:
            axis = np.full(3, np.nan)
            with self.found.beside(stated):
                axis = self._axis(stated, frames, there)
            if (limit := stated.find("limit")) is not None:
                with self.found.beside(limit):
                    limits = limit.bound("lower", -np.inf), limit.bound("upper", np.inf)
        return Joint(joint.name, joint.attribute("type") or "", parent, child, there, axis, limits)

    def _axis(self, axis: Element, frames: Frames, there: Pose) -> Floats:
        """Return a joint's axis in the model's frame, from the axes in which it is stated, by default the joint's."""
        stated, xyz = axis.find("xyz"), axis.numbers("xyz", 3)
        frame = None if stated is None else stated.attribute("expressed_in")
        if is_yes(axis.text("use_parent_model_frame")) or (not frame and axis.file in self._old):
            frame = "__model__"
        turn = frames.pose(frame, axis).turn if frame else there.turn
        return turn @ unit(np.array([0.0, 0.0, 1.0]) if xyz is None else xyz, axis)

    def _solid(self, collision: Element, links: Links, place: Pose) -> Mesh | None:
        geometry = collision.find("geometry")
        if geometry is None:
            raise collision.error("has no geometry")
        for shape in geometry.all("*"):
            if shape.tag == "plane" and not links.is_vehicle:
                links.planes.append((shape, place))
                continue
            solid = self._shape(shape, links)
            if solid is not None and shapes.displaces(solid):
                return solid
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
            file = self.resolved(shape.text("uri") or "", shape.file)
            if file is None or not file.is_file():
                rule = f"{shape.text('uri')!r}: not in {RESOURCE_PATHS[0]}, beside the file or in its checkout"
                links.missing.append(str(shape.error(rule)))
                return None
            if (part := shape.find("submesh")) is not None:
                raise part.error(
                    f"'{part.text('name')}' of {file.name}: must be a whole mesh: give it a file of its own"
                )
            scale = shape.numbers("scale", 3)
            self.found.opens(file)
            mesh = shapes.from_file(file, np.ones(3) if scale is None else scale)
            return shapes.closed(mesh, shape.path) if links.is_vehicle else mesh
        self.found.left_out(f"{shape.path}: shapes of this kind")
        return None


def _is_below(pair: str) -> bool:
    """Return whether an element of the added mass is below its diagonal, where none is stated."""
    return ADDED.index(pair[0]) > ADDED.index(pair[1])


def _named_in(folder: Path) -> str:
    """Return the description's name in a model's folder: that for the latest version, as model.config states."""
    if (folder / "model.config").is_file() and not (folder / "model.sdf").is_file():
        versions = [
            (each.attribute("version") or "", each.text()) for each in read_xml(folder / "model.config").all("sdf")
        ]
        if versions:
            return max(versions)[1] or "model.sdf"
    return "model.sdf"
