"""The things in the water as closed triangle meshes in the world frame."""

from __future__ import annotations

from itertools import pairwise
from typing import assert_never

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from uwsim.scenario.errors import ScenarioError
from uwsim.scenario.meshes import Triangles, Vertices, joined, load_mesh
from uwsim.scenario.obstacle_spec import Box, Cylinder, Gate, MeshObstacle, ObstacleSpec, Pipeline
from uwsim.scenario.terrain import Terrain

AROUND = 16
"""Sides of what is round: its flats are within 2 % of the radius."""
POST_FOOT_M = 0.5
"""How far a gate's posts reach into the bed, so that no slope shows their ends."""

Mesh = tuple[Vertices, Triangles]


def obstacle_mesh(obstacle: ObstacleSpec, terrain: Terrain) -> Mesh:
    """Vertices (n, 3), world frame, metres, and triangles (m, 3), winding outward. Raises ScenarioError."""
    match obstacle:
        case Pipeline():
            return _pipeline(obstacle, terrain)
        case Gate():
            return _gate(obstacle, terrain)
        case Box():
            return _posed(_parts(trimesh.creation.box(obstacle.size_m)), obstacle)
        case Cylinder():
            solid = trimesh.creation.cylinder(obstacle.radius_m, obstacle.length_m, sections=AROUND)
            return _posed(_parts(solid), obstacle)
        case MeshObstacle():
            return _posed(load_mesh(obstacle.file, scale=obstacle.scale, up=obstacle.up), obstacle)
        case _:
            assert_never(obstacle)


def _parts(solid: trimesh.Trimesh) -> Mesh:
    return np.asarray(solid.vertices, np.float64), np.asarray(solid.faces, np.uint32)


def _posed(mesh: Mesh, obstacle: Box | Cylinder | MeshObstacle) -> Mesh:
    world_from_local = Rotation.from_euler("ZYX", obstacle.yaw_pitch_roll_deg, degrees=True)
    return world_from_local.apply(mesh[0]) + np.asarray(obstacle.position_m), mesh[1]


def _pipeline(pipeline: Pipeline, terrain: Terrain) -> Mesh:
    """Sweep a tube along the line, its axis at bed height + radius (1 - 2 buried_fraction) at each of its points."""
    xy = _densified(np.asarray(pipeline.points_m, np.float64), step_m=max(1.0, terrain.spacing_m))
    lift = pipeline.radius_m * (1 - 2 * pipeline.buried_fraction)
    axis = np.column_stack([xy, _bed(terrain, xy, pipeline.name) + lift])
    return swept_tube(axis, pipeline.radius_m)


def _densified(points: NDArray[np.float64], step_m: float) -> NDArray[np.float64]:
    """Add points to the polyline (n, k) so that none is farther than step_m from the next."""
    pieces = []
    for start, end in pairwise(points):
        count = int(np.ceil(np.linalg.norm(end - start) / step_m))
        pieces.append(start + (end - start) * np.arange(count)[:, None] / count)
    return np.concatenate([*pieces, points[-1:]])


def swept_tube(axis_m: NDArray[np.float64], radius_m: float) -> Mesh:
    """Make a closed tube of AROUND sides along a line (n, 3) that does not start vertical, mitred where it bends."""
    directions = np.diff(axis_m, axis=0)
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    before, after = np.vstack([directions[:1], directions]), np.vstack([directions, directions[-1:]])
    side, up = _untwisted_frames(before)
    angles = np.linspace(0, 2 * np.pi, AROUND, endpoint=False)
    rings = radius_m * (np.cos(angles)[None, :, None] * side[:, None] + np.sin(angles)[None, :, None] * up[:, None])
    # Each ring is moved along the tube before it into the plane that halves the bend, where the next tube meets it.
    mitres = before + after
    slide = np.einsum("nak,nk->na", rings, mitres) / np.einsum("nk,nk->n", before, mitres)[:, None]
    rings += axis_m[:, None] - slide[..., None] * before[:, None]
    return _skinned(rings, axis_m[0], axis_m[-1])


def _untwisted_frames(directions: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Two unit normals at each of (n, 3) unit directions, carried on by the smallest turn from one to the next.

    So the tube's edges run straight through a bend; frames made afresh would twist it where it also climbs.
    """
    side = np.empty_like(directions)
    side[0] = np.cross([0.0, 0.0, 1.0], directions[0])
    side[0] /= np.linalg.norm(side[0])
    for k, (a, b) in enumerate(pairwise(directions)):
        v = side[k]
        side[k + 1] = v + 2 * b * (a @ v) - (a + b) * ((a + b) @ v) / (1 + a @ b)
    return side, np.cross(directions, side)


def _skinned(rings: NDArray[np.float64], first: NDArray[np.float64], last: NDArray[np.float64]) -> Mesh:
    """Triangles over rings (n, sides, 3) that run anticlockwise seen against their way, with a fan over each end."""
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


def _gate(gate: Gate, terrain: Terrain) -> Mesh:
    """Put posts from below the bed to the crossbar, whose height counts from the bed in the middle."""
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
    lines = [[[*foot, low], [*foot, top]] for foot, low in zip(feet, bottom, strict=True)]
    bars = [top] if gate.lower_bar_m is None else [top, heights[2] + gate.lower_bar_m]
    lines += [[[*feet[0], z], [*feet[1], z]] for z in bars]
    solids = [trimesh.creation.cylinder(gate.bar_radius_m, segment=line, sections=AROUND) for line in lines]
    vertices, triangles = joined([_parts(solid) for solid in solids])
    return vertices, triangles.astype(np.uint32)


def _bed(terrain: Terrain, xy_m: NDArray[np.float64], name: str) -> NDArray[np.float64]:
    heights = terrain.height_at(xy_m)
    outside = np.flatnonzero(np.isnan(heights))
    if len(outside):
        x, y = xy_m[outside[0]]
        raise ScenarioError(f"obstacle '{name}': ({x:g}, {y:g}) m lies outside the terrain, {terrain.extent_text}")
    return heights
