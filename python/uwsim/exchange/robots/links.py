"""Links and joints of a robot description: poses, lumped masses and solids, for SDF and URDF alike."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass, field, replace
from itertools import islice
from typing import NamedTuple

import numpy as np

from uwsim.exchange.robots.robot import Description, Lump, Mesh, Robot
from uwsim.exchange.robots.shapes import placed, volume_and_centre
from uwsim.exchange.robots.xml_file import HERE, Element, Floats, Pose

SHOWN, ASKED = 9, 100
"""Names in a message; poses in models within, each relative to the next, at most."""


@dataclass
class Joint:
    """A joint. pose: of the joint's frame in the model. axis: unit vector in the model's frame, nan for an odd one."""

    name: str
    kind: str
    parent: str
    child: str
    pose: Pose
    axis: Floats
    limits_rad: tuple[float, float] = (-np.inf, np.inf)


@dataclass
class Links:
    """The links of a model. poses: of each in the frame of the model. missing: a line for each absent mesh.

    is_vehicle: whether its solids displace water, for which they have to be closed. frames: the poses of all that has a
    name. placement: the name of what the model's pose places, if not its own frame. added_mass: (6, 6), about the
    link's origin, of links that state it. sensors, planes: with their poses.
    """

    element: Element
    poses: dict[str, Pose] = field(default_factory=dict)
    lumps: dict[str, Lump] = field(default_factory=dict)
    solids: dict[str, list[Mesh]] = field(default_factory=dict)
    joints: dict[str, Joint] = field(default_factory=dict)
    missing: list[str] = field(default_factory=list)
    is_vehicle: bool = True
    frames: dict[str, Pose] = field(default_factory=dict)
    placement: str | None = None
    added_mass: dict[str, Floats] = field(default_factory=dict)
    sensors: list[tuple[Element, Pose]] = field(default_factory=list)
    planes: list[tuple[Element, Pose]] = field(default_factory=list)

    def add(self, prefix: str, other: Links, at: Pose) -> None:
        """Add the links and joints of a model within this one, at a pose, with a prefix to all names."""
        self.poses |= {f"{prefix}{key}": at.then(pose) for key, pose in other.poses.items()}
        self.lumps |= {f"{prefix}{key}": value for key, value in other.lumps.items()}
        self.solids |= {f"{prefix}{key}": value for key, value in other.solids.items()}
        self.added_mass |= {f"{prefix}{key}": value for key, value in other.added_mass.items()}
        self.sensors += [(sensor, at.then(pose)) for sensor, pose in other.sensors]
        self.planes += [(plane, at.then(pose)) for plane, pose in other.planes]
        self.missing += other.missing
        for key, joint in other.joints.items():
            name, parent, child = (f"{prefix}{each}" for each in (key, joint.parent, joint.child))
            pose, axis = at.then(joint.pose), at.turn @ joint.axis
            self.joints[name] = replace(joint, name=name, parent=parent, child=child, pose=pose, axis=axis)

    def pose(self, name: str, of: Element) -> Pose:
        """Return a link's pose in the model. Raises ValueError for a name that there is not."""
        if name not in self.poses:
            raise of.error(f"there is no link '{name}' among {among(self.poses)}")
        return self.poses[name]

    def placed(self, pose: Pose, of: Element) -> Pose:
        """Return the pose of the model's frame, from that of what it places. Raises ValueError for a bad name."""
        if not self.placement:
            return pose
        if self.placement not in self.frames:
            raise of.error(f"there is no placement_frame '{self.placement}' among {among(self.frames)}")
        return pose.then(self.frames[self.placement].inverse())

    def joint(self, name: str, of: Element) -> Joint:
        """Return a joint. Raises ValueError for a name that there is not, and for one without an axis."""
        if name not in self.joints:
            raise of.error(f"there is no joint '{name}' among {among(self.joints)}")
        if not np.isfinite(self.joints[name].axis).all():
            raise of.error(f"joint '{name}' has no axis that can be used: see what was left out")
        return self.joints[name]

    def base(self, found: Description) -> str:
        """Return the link that is no joint's child, of the heaviest tree of links: others are left out.

        Raises ValueError if there is none.
        """
        below: dict[str, list[str]] = {}
        for joint in self.joints.values():
            below.setdefault(joint.parent, []).append(joint.child)
        children = {joint.child for joint in self.joints.values()}
        trees = {root: {root} for root in self.poses if root not in children}
        if not trees:
            raise self.element.error("must have a link that is no joint's child")
        for root, tree in trees.items():
            waiting = [root]
            while waiting:
                new = [child for child in below.get(waiting.pop(), []) if child not in tree]
                tree.update(new)
                waiting += new
        masses = {
            root: sum(self.lumps[each].mass_kg for each in tree if each in self.lumps) for root, tree in trees.items()
        }
        base = max(masses, key=lambda root: masses[root])
        for root, tree in trees.items():
            if root != base:
                found.left_out(f"{self.element.path}/link '{root}': no joint holds it and those on it to '{base}'")
                for name in tree - trees[base]:
                    for parts in (self.lumps, self.solids, self.added_mass):
                        parts.pop(name, None)
        return base

    def put_into(self, robot: Robot, base: str) -> None:
        """Add all masses and solids, in the frame of the base link."""
        to_base = self.poses[base].inverse()
        for name, pose in self.poses.items():
            there = to_base.then(pose)
            if (lump := self.lumps.get(name)) is not None:
                turned = there.turn @ lump.inertia_kg_m2 @ there.turn.T
                robot.lumps.append(Lump(lump.mass_kg, there.points(lump.centre_m[None])[0], turned))
            robot.solids += [placed(solid, there) for solid in self.solids.get(name, [])]


class Inner(NamedTuple):
    """A model within another. prefix: of its names, empty if it is merged. element: which has its pose."""

    prefix: str
    element: Element
    links: Links


class Frames:
    """The poses of what has a name in a model or a world, each relative to another of them (SDF 1.7)."""

    def __init__(self, model: Element, inner: Iterable[Inner] = ()) -> None:
        self._inner, self._asked = list(inner), set[str]()
        self._poses = {"__model__": HERE, "world": HERE, "__root__": HERE}
        tags = ("model", "frame", "joint", "link")  # of those of one name, which only old files have, the link
        self._elements = {each.name: each for tag in tags for each in model.all(tag)}
        self._models = {each.prefix.removesuffix("::"): each for each in self._inner if each.prefix}
        self._elements |= {name: each.element for name, each in self._models.items()}

    def all(self) -> dict[str, Pose]:
        """Return the poses of all names, of models within as well, but for those that have none."""
        names = dict(self._elements)
        names |= {f"{each.prefix}{name}": each.element for each in self._inner for name in each.links.frames}
        for name, element in names.items():
            with suppress(ValueError):
                self.pose(name, element)
        return self._poses

    def pose(self, name: str, of: Element) -> Pose:
        """Return a pose in the model's frame. Raises ValueError for a name that there is not, and for a circle."""
        asked: dict[str, None] = {}
        while name not in self._poses:
            if (within := self._within(name, of)) is not None:
                self._poses[name] = within
                break
            if name not in self._elements:
                raise of.error(f"there is no link, joint or frame '{name}' among {among(self._elements)}")
            asked[name] = None
            of = self._elements[name]
            child = of.text("child") if of.tag == "joint" else None
            name = of.relative_to() or child or of.attribute("attached_to") or "__model__"
            if name in asked:
                raise of.error(f"its pose refers to itself: {' - '.join([*asked, name])}")
        for each in reversed(asked):
            of = self._elements[each]
            pose, inner = self._poses[name].then(of.pose(of_frame=True)), self._models.get(each)
            if inner is None and of.tag == "model" and of.attribute("placement_frame"):
                raise of.error("its placement_frame does not let other poses be relative to it here")
            self._poses[each] = pose if inner is None else inner.links.placed(pose, of)
            name = each
        return self._poses[name]

    def of(self, element: Element, default: Pose = HERE) -> Pose:
        """Return the pose of an element. default: that of the frame which holds it."""
        frame = element.relative_to()
        base = default if frame is None else self.pose(frame, element)
        return base.then(element.pose(of_frame=True))

    def link_of(self, name: str, of: Element) -> str:
        """Return the link to which a name is attached: itself, or the one that a frame names, through others."""
        for _ in range(len(self._elements) + 1):
            element = self._elements.get(name)
            if element is None or element.tag != "frame" or not (to := element.attribute("attached_to")):
                return name
            name = to
        raise of.error(f"frame '{name}' is attached to itself")

    def _within(self, name: str, of: Element) -> Pose | None:
        """Return the pose of a name of a model within this one, if it is one."""
        for each in self._inner:
            if name.startswith(each.prefix) and (pose := each.links.frames.get(name.removeprefix(each.prefix))):
                if name in self._asked or len(self._asked) == ASKED:
                    raise of.error(f"its pose refers to itself, or to too many models: {name}")
                self._asked.add(name)
                own = each.prefix.removesuffix("::")
                return (self.pose(own, of) if own else each.links.placed(self.of(each.element), of)).then(pose)
        return None


def among(names: Iterable[str]) -> str:
    """Return the first of some names, for a message."""
    first = list(islice(names, SHOWN + 1))
    return ", ".join([*first[:SHOWN], *(["others"] if len(first) > SHOWN else [])]) or "none"


def unit(axis: Floats, of: Element) -> Floats:
    """Return a direction of any length as one of length 1. Raises ValueError for none."""
    if not (size := float(np.linalg.norm(axis))) > 0.0:
        raise of.error("its axis must not be zero")
    return axis / size


def inertia(element: Element | None, number: Callable[[Element, str], float], default: float = 0.0) -> Floats:
    """Return the inertia matrix of six numbers, or that of the default about each axis without an element."""
    if element is None:
        return default * np.eye(3)
    xx, xy, xz, yy, yz, zz = (number(element, key) for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"))
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def carried(matrix: Floats, there: Pose) -> Floats:
    """Return a 6 x 6 matrix of a link, between velocities and forces at its origin, at the frame in which its pose is.

    J^T M J, where J takes velocities of that frame to those of the link (Fossen 2011, eq. 2.33 and 7.24).
    """
    x, y, z = there.position_m
    across = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turn = there.turn.T
    to_link = np.block([[turn, -turn @ across], [np.zeros((3, 3)), turn]])
    return np.asarray(to_link.T @ matrix @ to_link)


def is_same(pose: Pose) -> bool:
    """Return whether a frame is that in which its pose is."""
    return not pose.position_m.any() and bool((pose.turn == np.eye(3)).all())


def summed_volume(solids: list[Mesh]) -> tuple[float, Floats]:
    """Return the sum of the volumes, in which overlaps count twice, and the centre by volume."""
    each = [volume_and_centre(solid) for solid in solids]
    volume = sum(size for size, _ in each)
    return volume, sum((size * centre for size, centre in each), start=np.zeros(3)) / volume
