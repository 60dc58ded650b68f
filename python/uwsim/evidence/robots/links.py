"""Links and joints of a robot description: poses, lumped masses and solids, for SDF and URDF alike."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from uwsim.evidence.robots.robot import Found, Lump, Mesh, Robot
from uwsim.evidence.robots.shapes import placed, volume_and_centre
from uwsim.evidence.robots.xml_file import HERE, Element, Floats, Pose


@dataclass
class Joint:
    """A joint. pose: of the joint's frame in the model. axis: unit vector in the model's frame."""

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

    is_vehicle: whether its solids displace water, for which they have to be closed.
    """

    element: Element
    poses: dict[str, Pose] = field(default_factory=dict)
    lumps: dict[str, Lump] = field(default_factory=dict)
    solids: dict[str, list[Mesh]] = field(default_factory=dict)
    joints: dict[str, Joint] = field(default_factory=dict)
    missing: list[str] = field(default_factory=list)
    is_vehicle: bool = True

    def add(self, name: str, other: Links) -> None:
        """Add the links and joints of a model within this one, under its name."""
        self.poses |= {f"{name}::{key}": value for key, value in other.poses.items()}
        self.lumps |= {f"{name}::{key}": value for key, value in other.lumps.items()}
        self.solids |= {f"{name}::{key}": value for key, value in other.solids.items()}
        self.missing += other.missing
        for key, joint in other.joints.items():
            parent, child = f"{name}::{joint.parent}", f"{name}::{joint.child}"
            self.joints[f"{name}::{key}"] = replace(joint, name=f"{name}::{key}", parent=parent, child=child)

    def pose(self, name: str, of: Element) -> Pose:
        """Return a link's pose in the model. Raises ValueError for a name that there is not."""
        if name not in self.poses:
            raise of.error(f"there is no link '{name}' among {', '.join(self.poses) or 'none'}")
        return self.poses[name]

    def joint(self, name: str, of: Element) -> Joint:
        """Return a joint. Raises ValueError for a name that there is not."""
        if name not in self.joints:
            raise of.error(f"there is no joint '{name}' among {', '.join(self.joints) or 'none'}")
        return self.joints[name]

    def base(self, found: Found) -> str:
        """Return the link that is no joint's child, of the heaviest tree of links: others are left out.

        Raises ValueError if there is none.
        """
        children = {joint.child for joint in self.joints.values()}
        trees = {root: {root} for root in self.poses if root not in children}
        if not trees:
            raise self.element.error("must have a link that is no joint's child")
        for tree in trees.values():
            while new := {each.child for each in self.joints.values() if each.parent in tree} - tree:
                tree |= new
        masses = {
            root: sum(self.lumps[each].mass_kg for each in tree if each in self.lumps) for root, tree in trees.items()
        }
        base = max(masses, key=lambda root: masses[root])
        for root, tree in trees.items():
            if root != base:
                found.left_out(f"{self.element.path}/link '{root}': no joint holds it and those on it to '{base}'")
                for name in tree - trees[base]:
                    for parts in (self.lumps, self.solids):
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


class Frames:
    """The poses of a model's links, joints and frames, each relative to another of them (SDF 1.7).

    inner: the poses of links in models within it, by name.
    """

    def __init__(self, model: Element, inner: dict[str, Pose]) -> None:
        self._model, self._poses = model, {"__model__": HERE, **inner}
        self._elements = {each.name: each for tag in ("link", "joint", "frame") for each in model.all(tag)}
        self._asked: list[str] = []

    def pose(self, name: str, of: Element) -> Pose:
        """Return a pose in the model's frame. Raises ValueError for a name that there is not, and for a circle."""
        if name in self._poses:
            return self._poses[name]
        if name not in self._elements:
            raise of.error(f"there is no link, joint or frame '{name}' among {', '.join(self._elements) or 'none'}")
        if name in self._asked:
            raise of.error(f"its pose refers to itself: {' - '.join([*self._asked, name])}")
        element = self._elements[name]
        stated, child = element.find("pose"), element.text("child") if element.tag == "joint" else None
        around = stated.attribute("relative_to") if stated is not None else None
        self._asked.append(name)
        base = self.pose(around or child or element.attribute("attached_to") or "__model__", element)
        self._asked.pop()
        self._poses[name] = base.then(element.pose())
        return self._poses[name]


def inertia(element: Element | None, number: Callable[[Element, str], float]) -> Floats:
    """Return the inertia matrix of six numbers, zero without an element."""
    if element is None:
        return np.zeros((3, 3))
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
