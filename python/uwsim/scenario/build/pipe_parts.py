"""Places of a pipeline's joints, anodes and features, and the debris that lies on it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from uwsim.scenario.build.cover_meshes import Mesh
from uwsim.scenario.build.debris_meshes import lying_about
from uwsim.scenario.build.pipe_shape import (
    COVER_M,
    all_features,
    anodes_m,
    clock_angle,
    joints_m,
)
from uwsim.scenario.spec.bubble_plume import BubblePlume
from uwsim.scenario.spec.part import Part
from uwsim.scenario.spec.pipe_condition import PipeCondition, PipeFeature

Floats = NDArray[np.float64]
TOP_H = 12.0
LEAK_L_MIN = 3.0
DEBRIS_SUNK = 0.03
"""How far debris has sunk into the coating, relative to its length."""


@dataclass(frozen=True, eq=False)
class Course:
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


def pipe_parts(condition: PipeCondition, course: Course, length_m: float) -> list[Part]:
    """Return the parts of a pipeline: its features, then its anodes and joints."""
    features = all_features(condition, length_m)
    parts = [_band(one.kind, one.at_m, course) for one in features if one.kind in ("burial", "span")]
    parts += [_band("joint", float(at), course) for at in joints_m(condition, length_m)]
    parts += [_band("anode", float(at), course) for at in anodes_m(condition, length_m)]
    for kind in ("damage", "leak"):
        marked = [one for one in features if one.kind == kind]
        parts += [Part(kind, course.surface(one.at_m, clock_angle(one.clock_h))) for one in marked]
    return parts + [_lump(mesh) for mesh in pipe_debris(condition, course, length_m)]


def pipe_debris(condition: PipeCondition, course: Course, length_m: float) -> list[Mesh]:
    """Return the meshes, in the world, of the debris that lies across the pipe."""
    lying = [one for one in all_features(condition, length_m) if one.kind == "debris"]
    return [_dropped(one, course, [condition.seed, 0x64656272, k]) for k, one in enumerate(lying)]


def pipe_leaks(condition: PipeCondition, course: Course, length_m: float) -> list[BubblePlume]:
    """Return the plumes of the leaks."""
    leaks = [one for one in all_features(condition, length_m) if one.kind == "leak"]
    return [
        BubblePlume(course.surface(one.at_m, clock_angle(one.clock_h)), one.rate_l_min or LEAK_L_MIN) for one in leaks
    ]


def _dropped(one: PipeFeature, course: Course, seed: Sequence[int]) -> Mesh:
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


def _band(kind: str, at_m: float, course: Course) -> Part:
    """Return a part that goes all around the pipe, at its top."""
    above_m = COVER_M if kind == "burial" else 0.0  # where it is buried, its place is on the bed
    return Part(kind, course.surface(at_m, clock_angle(TOP_H)) + np.array([0.0, 0.0, above_m]))
