"""Obstacles in the world frame: closed triangle meshes, and exact shapes for round obstacles except rings.

Rays hit the exact shapes. Contacts, and the ground truth for map scores, use the mesh: its vertices lie on the round
surface, and its facets at most 0.5 % of the radius inside it.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any, NamedTuple, assert_never, cast

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.base.quaternions import of_yaw_pitch_roll_deg, turned
from uwsim.scenario.build.surface_points import surface_points
from uwsim.scenario.build.terrain import Terrain
from uwsim.scenario.read.disk_cache import cached_arrays
from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.read.mesh_file import Triangles, Vertices, joined, load_mesh
from uwsim.scenario.spec.obstacle import Box, Cylinder, Gate, MeshObstacle, ObstacleSpec, Pipeline, Ring, Sphere

SIDES = 32
"""Sides of a round cross-section: their midpoints are r (1 - cos(pi / 32)) = 0.48 % of the radius inside the circle."""
BALL_SUBDIVISIONS = 4
"""Subdivisions of an icosahedron: the facets lie at most 0.1 % of the radius inside the sphere."""
RING_SEGMENTS = 72
"""Segments around a ring; the chords of its axis are 0.1 % of the major radius inside the circle."""
POST_FOOT_M = 0.5
"""Depth of a gate's posts below the bed, which hides their ends on a slope."""

Mesh = tuple[Vertices, Triangles]
Shapes = list[_core.RoundShape]
Standing = Box | Cylinder | Sphere | Ring | MeshObstacle


class Solid(NamedTuple):
    """A closed solid: vertices (n, 3), world frame, metres; triangles (m, 3), winding outward; and its exact shapes.

    The exact, analytic shapes exist only if the solid is round.
    """

    vertices: Vertices
    triangles: Triangles
    shapes: Shapes


def obstacle_solid(obstacle: ObstacleSpec, terrain: Terrain) -> Solid:
    """Return the obstacle in the world frame. Raises ScenarioError."""
    if not isinstance(obstacle, Pipeline | Gate) and obstacle.on_bed:
        obstacle = _standing(obstacle, terrain)
    match obstacle:  # trimesh, which takes a second to import, is imported only for meshes that are not cached
        case Pipeline():
            return _pipeline(obstacle, terrain)
        case Gate():
            return _gate(obstacle, terrain)
        case Box():
            return Solid(*_posed(_created("box", obstacle.size_m), obstacle), [])
        case Cylinder():
            ends = np.array([[0.0, 0.0, -0.5], [0.0, 0.0, 0.5]]) * obstacle.length_m
            start, end = _in_world(obstacle, ends)
            return _bars([(start, end)], obstacle.radius_m)
        case Sphere():
            vertices, triangles = _created("icosphere", BALL_SUBDIVISIONS, obstacle.radius_m)
            shape = _core.RoundShape.sphere(obstacle.position_m, obstacle.radius_m)
            return Solid(vertices + np.asarray(obstacle.position_m), triangles, [shape])
        case Ring():
            return Solid(*_posed(_torus(obstacle.major_radius_m, obstacle.minor_radius_m), obstacle), [])
        case MeshObstacle():
            return Solid(*_posed(load_mesh(obstacle.file, scale=obstacle.scale, up=obstacle.up), obstacle), [])
        case _:
            assert_never(obstacle)


def _standing(obstacle: Standing, terrain: Terrain) -> Standing:
    """Return the obstacle, lowered until it first touches the bed, then raised by the z of its position."""
    x, y, above_m = obstacle.position_m
    afloat = obstacle.model_copy(update={"on_bed": False, "position_m": (x, y, 0.0)})
    solid = obstacle_solid(afloat, terrain)
    points = np.concatenate([solid.vertices, surface_points(solid.vertices, solid.triangles)])
    clear_m = points[:, 2] - _bed(terrain, points[:, :2], obstacle.name)
    return afloat.model_copy(update={"position_m": (x, y, above_m - float(clear_m.min()))})


def _created(shape: str, *arguments: Any) -> Mesh:
    """Return a mesh created by a function in trimesh.creation."""

    def make() -> Mesh:
        import trimesh

        solid = getattr(trimesh.creation, shape)(*arguments)
        return np.asarray(solid.vertices, np.float64), np.asarray(solid.faces, np.uint32)

    given = (np.asarray(argument, np.float64) for argument in arguments if argument is not None)
    return cast(Mesh, cached_arrays(make, shape, *given))


def _in_world(obstacle: Box | Cylinder | Ring | MeshObstacle, points_m: NDArray[np.float64]) -> NDArray[np.float64]:
    turn = of_yaw_pitch_roll_deg(obstacle.yaw_pitch_roll_deg)
    return turned(turn, points_m) + np.asarray(obstacle.position_m, np.float64)


def _posed(mesh: Mesh, obstacle: Box | Ring | MeshObstacle) -> Mesh:
    return _in_world(obstacle, mesh[0]), mesh[1]


def _torus(major_m: float, minor_m: float) -> Mesh:
    """Return a torus about x, one segment after the other."""
    around = np.linspace(0, 2 * np.pi, RING_SEGMENTS, endpoint=False)[:, None]
    along = np.linspace(0, 2 * np.pi, SIDES, endpoint=False)[None, :]
    radius_m = major_m + minor_m * np.cos(along)
    points = [np.broadcast_to(minor_m * np.sin(along), (RING_SEGMENTS, SIDES))]
    points += [radius_m * np.cos(around), radius_m * np.sin(around)]
    a = np.arange(RING_SEGMENTS * SIDES).reshape(RING_SEGMENTS, SIDES)
    b, after, beyond = np.roll(a, -1, axis=1), np.roll(a, -1, axis=0), np.roll(a, (-1, -1), axis=(0, 1))
    triangles = np.stack([a, beyond, b, a, after, beyond], axis=-1).reshape(-1, 3)
    return np.stack(points, axis=-1).reshape(-1, 3), triangles.astype(np.uint32)


def _bars(lines: Sequence[tuple[NDArray[np.float64], NDArray[np.float64]]], radius_m: float) -> Solid:
    """Return round bars with flat ends, each between two points (3,) on its axis."""
    # trimesh.creation.cylinder(radius, height, sections, segment)
    vertices, triangles = joined([_created("cylinder", radius_m, None, SIDES, line) for line in lines])
    shapes = [_core.RoundShape.cylinder(start, end, radius_m) for start, end in lines]
    return Solid(vertices, triangles.astype(np.uint32), shapes)


def _pipeline(pipeline: Pipeline, terrain: Terrain) -> Solid:
    """Return a tube swept along the line; its axis is radius (1 - 2 buried_fraction) above the bed at each point."""
    xy = _densified(np.asarray(pipeline.points_m, np.float64), step_m=max(1.0, terrain.spacing_m))
    lift = pipeline.radius_m * (1 - 2 * pipeline.buried_fraction)
    axis = np.column_stack([xy, _bed(terrain, xy, pipeline.name) + lift])
    shapes = _core.RoundShape.pipe(axis, pipeline.radius_m)
    return Solid(*swept_tube(axis, pipeline.radius_m), shapes)


def _densified(points: NDArray[np.float64], step_m: float) -> NDArray[np.float64]:
    """Return the polyline (n, k) with points added so that consecutive ones are at most step_m apart."""
    pieces = []
    for start, end in pairwise(points):
        count = int(np.ceil(np.linalg.norm(end - start) / step_m))
        pieces.append(start + (end - start) * np.arange(count)[:, None] / count)
    return np.concatenate([*pieces, points[-1:]])


def swept_tube(axis_m: NDArray[np.float64], radius_m: float) -> Mesh:
    """Return a closed tube with SIDES sides and mitred bends along a line (n, 3) that does not start vertically."""
    directions = np.diff(axis_m, axis=0)
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    before, after = np.vstack([directions[:1], directions]), np.vstack([directions, directions[-1:]])
    side, up = _untwisted_frames(before)
    angles = np.linspace(0, 2 * np.pi, SIDES, endpoint=False)
    rings = radius_m * (np.cos(angles)[None, :, None] * side[:, None] + np.sin(angles)[None, :, None] * up[:, None])
    # Each ring slides along the preceding straight piece into the plane that bisects the bend.
    mitres = before + after
    slide = np.einsum("nak,nk->na", rings, mitres) / np.einsum("nk,nk->n", before, mitres)[:, None]
    rings += axis_m[:, None] - slide[..., None] * before[:, None]
    return _skinned(rings, axis_m[0], axis_m[-1])


def _untwisted_frames(directions: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return two unit normals for each of (n, 3) unit directions, with the smallest rotation between neighbours.

    This keeps the tube's edges straight through a bend; with independent frames, a tube that also climbs would be
    twisted.
    """
    side = np.empty_like(directions)
    side[0] = np.cross([0.0, 0.0, 1.0], directions[0])
    side[0] /= np.linalg.norm(side[0])
    for k, (a, b) in enumerate(pairwise(directions)):
        v = side[k]
        side[k + 1] = v + 2 * b * (a @ v) - (a + b) * ((a + b) @ v) / (1 + a @ b)
    return side, np.cross(directions, side)


def _skinned(rings: NDArray[np.float64], first: NDArray[np.float64], last: NDArray[np.float64]) -> Mesh:
    """Return a mesh over rings (n, sides, 3), counter-clockwise seen from the tube's end, with a fan at each end."""
    n, sides, _ = rings.shape
    a = np.arange((n - 1) * sides).reshape(n - 1, sides)
    b = np.roll(a, -1, axis=1)
    wall = np.stack([a, b, b + sides, a, b + sides, a + sides], axis=-1).reshape(-1, 3)
    ring, after = np.arange(sides), np.roll(np.arange(sides), -1)
    start, end = n * sides, n * sides + 1
    start_fan = np.column_stack([np.full(sides, start), after, ring])
    end_fan = np.column_stack([np.full(sides, end), ring + (n - 1) * sides, after + (n - 1) * sides])
    vertices = np.vstack([rings.reshape(-1, 3), first, last])
    return vertices, np.vstack([wall, start_fan, end_fan]).astype(np.uint32)


def _gate(gate: Gate, terrain: Terrain) -> Solid:
    """Return posts, from below the bed, and crossbars; heights are measured from the bed midway between the posts."""
    yaw = np.radians(gate.yaw_deg)
    across = np.array([-np.sin(yaw), np.cos(yaw)])
    middle = np.asarray(gate.position_m)
    feet = middle + np.array([[-0.5], [0.5]]) * gate.width_m * across
    heights = _bed(terrain, np.vstack([feet, middle]), gate.name)
    top, bottom = heights[2] + gate.height_m, heights[:2] - POST_FOOT_M
    if (heights[:2] >= top).any():
        raise ScenarioError(
            f"obstacle '{gate.name}': the bed at a post is higher than the crossbar; make height_m larger"
        )
    lines = [(np.array([*foot, low]), np.array([*foot, top])) for foot, low in zip(feet, bottom, strict=True)]
    bars = [top] if gate.lower_bar_m is None else [top, heights[2] + gate.lower_bar_m]
    lines += [(np.array([*feet[0], z]), np.array([*feet[1], z])) for z in bars]
    return _bars(lines, gate.bar_radius_m)


def _bed(terrain: Terrain, xy_m: NDArray[np.float64], name: str) -> NDArray[np.float64]:
    heights = terrain.height_at(xy_m)
    outside = np.flatnonzero(np.isnan(heights))
    if len(outside):
        x, y = xy_m[outside[0]]
        raise ScenarioError(f"obstacle '{name}': ({x:g}, {y:g}) m lies outside the terrain, {terrain.extent_text}")
    return heights
