"""The surface of a pipeline, by rings of varying radius along an axis; its joints, anodes, features and debris."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, cast

import numpy as np

from uwsim.base.arrays import Floats
from uwsim.scenario.build.cover_meshes import Mesh, lying_about
from uwsim.scenario.build.solids import SIDES
from uwsim.scenario.spec.obstacle import BubblePlume, FeatureKind, Part, PipeCondition, PipeFeature

# Sizes assumed, of a small pipe with a coating of concrete; they scale with the radius where it is small.
JOINT_M, JOINT_DEEP = 0.30, 0.06
"""Length of a field joint, where the coating ends, and its depth in radii."""
ANODE_M, ANODE_HIGH = 0.50, 0.12
DAMAGE_DEEP, DAMAGE_HALF_RAD = 0.12, 0.9
LEAK_HALF_RAD = 0.4
STEP_M = 0.5
COVER_M = 0.1
"""Height of the bed above the top of a buried pipe."""
COATING, JOINT, ANODE, RUST = (0.30, 0.29, 0.27), (0.10, 0.10, 0.11), (0.55, 0.55, 0.57), (0.22, 0.07, 0.02)
DEBRIS = (0.16, 0.15, 0.13)


class Rings(NamedTuple):
    """A pipe's rings: distances along it (n,), height above the usual axis, and by ring and side radius and albedo.

    At each end of a joint, an anode or a damage there are two rings a millimetre apart, so that edges are sharp.
    """

    along_m: Floats
    lift_m: Floats
    radius_m: Floats
    albedo: Floats


def all_features(condition: PipeCondition, length_m: float) -> list[PipeFeature]:
    """Return the features on a pipeline of a length: the given ones that are on it, then those of the seed.

    Raises ValueError if a given one is beyond its end, or if there is no room.
    """
    found = list(condition.features)
    for one in found:
        if one.at_m > length_m:
            raise ValueError(f"a feature is at {one.at_m:g} m: must be at most {length_m:.4g} m, the pipe's length")
    random = np.random.default_rng([condition.seed, 0x70697065])
    wanted: list[FeatureKind] = []
    counts = {"span": condition.spans, "burial": condition.burials, "damage": condition.damages}
    for name, count in {**counts, "debris": condition.debris or 0, "leak": condition.leaks or 0}.items():
        wanted += [cast("FeatureKind", name)] * count
    for kind in wanted:
        for _ in range(500):
            new = PipeFeature(
                kind=kind, at_m=float(random.uniform(0, length_m)), clock_h=float(random.uniform(9, 15)) % 12
            )
            half = new.extent_m / 2
            free = all(abs(new.at_m - one.at_m) > half + one.extent_m / 2 for one in found)
            if half <= new.at_m <= length_m - half and free:
                found.append(new)
                break
        else:
            raise ValueError(f"no room for another {kind} on {length_m:.4g} m: must be fewer")
    return found


def pipe_rings(condition: PipeCondition, length_m: float, corners_m: Floats, radius_m: float, buried_m: float) -> Rings:
    """Return a pipe's rings. corners_m (k,): distances of the line's corners. buried_m: how deep it lies in the bed."""
    features = all_features(condition, length_m)
    joints = joints_m(condition, length_m)
    anodes = anodes_m(condition, length_m)
    bands = [(at - JOINT_M / 2, at + JOINT_M / 2) for at in joints] + [
        (at - ANODE_M / 2, at + ANODE_M / 2) for at in anodes
    ]
    bands += [_ends(one) for one in features if one.kind in ("damage", "leak")]
    edges = np.array(bands).reshape(-1, 2).ravel()
    evenly = np.linspace(0, length_m, max(int(np.ceil(length_m / STEP_M)), 1) + 1)
    along = np.concatenate([evenly, corners_m, edges - 5e-4, edges + 5e-4])
    along = np.unique(np.clip(along, 0, length_m))
    along = along[np.concatenate([[True], np.diff(along) > 2e-4])]
    radius = np.full((len(along), SIDES), radius_m)
    albedo = np.broadcast_to(np.array(COATING), (len(along), SIDES, 3)).copy()
    for places, size, high, colour in ((joints, JOINT_M, -JOINT_DEEP, JOINT), (anodes, ANODE_M, ANODE_HIGH, ANODE)):
        for at in places:
            on = np.abs(along - at) <= size / 2
            radius[on] = radius_m * (1 + high)
            albedo[on] = colour
    lift = np.zeros(len(along))
    for one in features:
        start, end = _ends(one)
        on = (along >= start) & (along <= end)
        if one.kind == "damage":
            sides = np.abs(np.angle(np.exp(1j * (side_angles() - clock_angle(one.clock_h))))) < DAMAGE_HALF_RAD
            radius[np.ix_(on, sides)] = radius_m * (1 - DAMAGE_DEEP)
            albedo[np.ix_(on, sides)] = RUST
        if one.kind == "leak":
            sides = np.abs(np.angle(np.exp(1j * (side_angles() - clock_angle(one.clock_h))))) < LEAK_HALF_RAD
            albedo[np.ix_(on, sides)] = RUST
        if one.kind in ("damage", "debris", "leak"):
            continue
        swell = np.sin(np.pi * (along - start) / (end - start)) ** 2
        deep_m = 2 * radius_m - buried_m + COVER_M
        lift += np.where(on, swell * (one.height_m if one.kind == "span" else -deep_m), 0.0)
    return Rings(along, lift, radius, albedo)


def joints_m(condition: PipeCondition, length_m: float) -> Floats:
    """Return the distances of the field joints along a pipe."""
    return np.arange(condition.joint_m, length_m, condition.joint_m)


def anodes_m(condition: PipeCondition, length_m: float) -> Floats:
    """Return the distances of the anodes along a pipe: by default in the middle of every other length."""
    return np.arange(condition.anode_m / 4, length_m, condition.anode_m)


def side_angles() -> Floats:
    """Return the angle (SIDES,) of each side about the axis: 0 to the left seen along the line, 90 degrees on top."""
    return np.linspace(0, 2 * np.pi, SIDES, endpoint=False)


def clock_angle(clock_h: float) -> float:
    """Return the angle of an hour: 12 is on top, 3 to the right seen along the line."""
    return float(np.pi / 2 + 2 * np.pi * clock_h / 12)


def triangle_albedos(albedo: Floats) -> Floats:
    """Return the albedos (m, 3) of the triangles of a tube whose rings have these (n, SIDES, 3), ends last."""
    wall = np.repeat(albedo[:-1].reshape(-1, 3), 2, axis=0)
    return np.vstack([wall, albedo[0], albedo[-1]])


def _ends(one: PipeFeature) -> tuple[float, float]:
    return one.at_m - one.extent_m / 2, one.at_m + one.extent_m / 2


TOP_H = 12.0
LEAK_L_MIN = 3.0
DEBRIS_SUNK = 0.03
"""How far debris has sunk into the coating, relative to its length."""


@dataclass(frozen=True, eq=False)
class PipeRun:
    """Where a pipeline lies. along_m (n,), axis_m (n, 3): distances along it on the chart, and its axis there."""

    along_m: Floats
    axis_m: Floats
    radius_m: float

    def middle(self, at_m: float) -> Floats:
        """Return the axis (3,) at a distance."""
        return np.array([np.interp(at_m, self.along_m, self.axis_m[:, k]) for k in range(3)])

    def frame(self, at_m: float) -> Floats:
        """Return unit vectors ahead, left and up as rows (3, 3), at a distance; ahead is level."""
        k = min(max(int(np.searchsorted(self.along_m, at_m)), 1), len(self.along_m) - 1)
        ahead = self.axis_m[k] - self.axis_m[k - 1]
        x, y = ahead[:2] / np.hypot(ahead[0], ahead[1])
        return np.array([[x, y, 0.0], [-y, x, 0.0], [0.0, 0.0, 1.0]])

    def surface(self, at_m: float, angle_rad: float) -> Floats:
        """Return the point (3,) of the usual surface at a distance and an angle about the axis."""
        _, left, up = self.frame(at_m)
        return np.asarray(self.middle(at_m) + self.radius_m * (np.cos(angle_rad) * left + np.sin(angle_rad) * up))


def pipe_parts(condition: PipeCondition, course: PipeRun, length_m: float) -> list[Part]:
    """Return the parts of a pipeline: its features, then its anodes and joints."""
    features = all_features(condition, length_m)
    parts = [_band(one.kind, one.at_m, course) for one in features if one.kind in ("burial", "span")]
    parts += [_band("joint", float(at), course) for at in joints_m(condition, length_m)]
    parts += [_band("anode", float(at), course) for at in anodes_m(condition, length_m)]
    for kind in ("damage", "leak"):
        marked = [one for one in features if one.kind == kind]
        parts += [Part(kind, course.surface(one.at_m, clock_angle(one.clock_h))) for one in marked]
    return parts + [_lump(mesh) for mesh in pipe_debris(condition, course, length_m)]


def pipe_debris(condition: PipeCondition, course: PipeRun, length_m: float) -> list[Mesh]:
    """Return the meshes, in the world, of the debris that lies across the pipe."""
    lying = [one for one in all_features(condition, length_m) if one.kind == "debris"]
    return [_dropped(one, course, [condition.seed, 0x64656272, k]) for k, one in enumerate(lying)]


def pipe_leaks(condition: PipeCondition, course: PipeRun, length_m: float) -> list[BubblePlume]:
    """Return the plumes of the leaks."""
    leaks = [one for one in all_features(condition, length_m) if one.kind == "leak"]
    return [
        BubblePlume(course.surface(one.at_m, clock_angle(one.clock_h)), one.rate_l_min or LEAK_L_MIN) for one in leaks
    ]


def _dropped(one: PipeFeature, course: PipeRun, seed: Sequence[int]) -> Mesh:
    random = np.random.default_rng(seed)
    kinds = lying_about(random)
    vertices, triangles = kinds[int(random.integers(len(kinds)))]
    turn = random.uniform(0.2, 0.8) * np.pi  # across the pipe rather than along it
    ahead, left, _ = course.frame(one.at_m)
    level = np.array([np.cos(turn) * ahead + np.sin(turn) * left, np.cos(turn) * left - np.sin(turn) * ahead])
    size_m = one.extent_m
    up = size_m * (vertices[:, 2] - vertices[:, 2].min() - DEBRIS_SUNK)
    at = course.surface(one.at_m, clock_angle(TOP_H))
    return size_m * vertices[:, :2] @ level + up[:, None] * [0.0, 0.0, 1.0] + at, triangles


def _lump(mesh: Mesh) -> Part:
    low, high = mesh[0].min(axis=0), mesh[0].max(axis=0)
    return Part("debris", np.array([*0.5 * (low + high)[:2], high[2]]))


def _band(kind: str, at_m: float, course: PipeRun) -> Part:
    """Return a part that goes all around the pipe, at its top."""
    above_m = COVER_M if kind == "burial" else 0.0  # where it is buried, its place is on the bed
    return Part(kind, course.surface(at_m, clock_angle(TOP_H)) + np.array([0.0, 0.0, above_m]))
