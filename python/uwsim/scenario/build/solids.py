"""Parts of obstacles: closed triangle meshes, and exact shapes for round ones.

Rays hit the exact shapes. Contacts, and the ground truth for map scores, use the mesh: its vertices lie on the round
surface, and its facets at most 0.5 % of the radius inside it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.base.quaternions import of_yaw_pitch_roll_deg, turned
from uwsim.scenario.read.disk_cache import cached_arrays
from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.read.mesh_file import Triangles, Vertices, joined
from uwsim.scenario.spec.obstacle import Bed, Solid

SIDES = 32
"""Sides of a round cross-section: their midpoints are r (1 - cos(pi / 32)) = 0.48 % of the radius inside the circle."""

Mesh = tuple[Vertices, Triangles]
Point = tuple[float, float, float]


def created(shape: str, *arguments: Any) -> Mesh:
    """Return a mesh created by a function in trimesh.creation."""

    def make() -> Mesh:
        from uwsim.base.whole_trimesh import trimesh

        solid = getattr(trimesh.creation, shape)(*arguments)
        return np.asarray(solid.vertices, np.float64), np.asarray(solid.faces, np.uint32)

    given = (np.asarray(argument, np.float64) for argument in arguments if argument is not None)
    return cast(Mesh, cached_arrays(make, shape, *given))


def posed(points_m: NDArray[np.float64], position_m: Point, yaw_pitch_roll_deg: Point) -> NDArray[np.float64]:
    """Return points (n, 3) of an obstacle's own frame in the world."""
    return turned(of_yaw_pitch_roll_deg(yaw_pitch_roll_deg), points_m) + np.asarray(position_m, np.float64)


def bars(lines: Sequence[tuple[NDArray[np.float64], NDArray[np.float64]]], radius_m: float) -> Solid:
    """Return round bars with flat ends, each between two points (3,) on its axis."""
    # trimesh.creation.cylinder(radius, height, sections, segment)
    vertices, triangles = joined([created("cylinder", radius_m, None, SIDES, line) for line in lines])
    shapes = [_core.RoundShape.cylinder(start, end, radius_m) for start, end in lines]
    return Solid(vertices, triangles.astype(np.uint32), shapes)


def bed_below(terrain: Bed, xy_m: NDArray[np.float64], name: str) -> NDArray[np.float64]:
    """Return z (n,) of the bed at points (n, 2). Raises ScenarioError for one outside the terrain."""
    heights = terrain.height_at(xy_m)
    outside = np.flatnonzero(np.isnan(heights))
    if len(outside):
        x, y = xy_m[outside[0]]
        raise ScenarioError(f"obstacle '{name}': ({x:g}, {y:g}) m lies outside the terrain, {terrain.extent_text}")
    return heights
