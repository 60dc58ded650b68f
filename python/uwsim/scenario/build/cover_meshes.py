"""Shapes of cover, debris and fish: small triangle meshes with the largest extent 1.

They are made from noise, revolution and sweeps.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np
from numpy.typing import ArrayLike

from uwsim.base.arrays import Floats
from uwsim.scenario.read.mesh_file import Triangles, Vertices, joined

Mesh = tuple[Vertices, Triangles]
Random = np.random.Generator


def unit(mesh: Mesh, *, standing: bool = False) -> Mesh:
    """Return a mesh with the largest extent 1. standing: its height counts, and its lowest point is moved to z = 0."""
    vertices, triangles = mesh
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    if standing:
        return (vertices - [0.0, 0.0, low[2]]) / (high[2] - low[2]), triangles
    return (vertices - 0.5 * (low + high)) / (high - low).max(), triangles


def merged(parts: Sequence[Mesh]) -> Mesh:
    """Return one mesh of several."""
    vertices, triangles = joined(list(parts))
    return vertices, triangles.astype(np.uint32)


@cache
def ball(divisions: int) -> Mesh:
    """Return a sphere of radius 1: an icosahedron whose triangles are divided in four `divisions` times."""
    g = (1 + 5**0.5) / 2
    points = [(-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0), (0, -1, g), (0, 1, g), (0, -1, -g), (0, 1, -g)]
    vertices = np.array([*points, (g, 0, -1), (g, 0, 1), (-g, 0, -1), (-g, 0, 1)], np.float64)
    faces = "0b5 051 017 07a 0ab 159 5b4 ba2 a76 718 394 342 326 368 389 495 24b 62a 867 981"
    triangles = np.array([[int(digit, 16) for digit in face] for face in faces.split()])
    for _ in range(divisions):
        edges = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        ends, middle = np.unique(edges, axis=0, return_inverse=True)
        ab, bc, ca = (middle.reshape(-1, 3) + len(vertices)).T
        a, b, c = triangles.T
        vertices = np.vstack([vertices, vertices[ends].mean(axis=1)])
        triangles = np.vstack(
            [np.stack(corners, axis=1) for corners in ((a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca))]
        )
    return vertices / np.linalg.norm(vertices, axis=1)[:, None], triangles.astype(np.uint32)


def lumps(points: Floats, random: Random, per_unit: float, waves: int = 12) -> Floats:
    """Return smooth noise (n,) about 0 with deviation 1 at points (n, 3): plane waves in random directions."""
    along = random.normal(size=(waves, 3))
    along *= per_unit * random.uniform(0.5, 1.5, (waves, 1)) / np.linalg.norm(along, axis=1)[:, None]
    return np.asarray(np.cos(2 * np.pi * (points @ along.T + random.random(waves))).sum(axis=1) * (2 / waves) ** 0.5)


def stone(random: Random, *, cuts: int, roughness: float, divisions: int = 2) -> Mesh:
    """Return a ball that planes have cut, as joints and blows cut rock, with some roughness; its extents differ."""
    vertices, triangles = ball(divisions)
    vertices = vertices * (1 + roughness * lumps(vertices, random, 0.6))[:, None]
    for _ in range(cuts):
        normal = random.normal(size=3)
        normal /= np.linalg.norm(normal)
        beyond = np.maximum(vertices @ normal - random.uniform(0.55, 0.85), 0)
        vertices = vertices - beyond[:, None] * normal
    vertices = vertices * random.uniform(0.6, 1.0, 3)
    return vertices * (1 + 0.02 * lumps(vertices, random, 3.0))[:, None], triangles


def tube(line: ArrayLike, radii: ArrayLike, sides: int = 5, *, closed: bool = True) -> Mesh:
    """Return a tube along a line (n, 3) with a radius (n,) at each point; closed: with points at both ends."""
    points, size = np.asarray(line, np.float64), np.asarray(radii, np.float64)
    along = np.gradient(points, axis=0)
    along /= np.linalg.norm(along, axis=1)[:, None] + 1e-12
    side = _crossed(along, np.array([[0.31, 0.95, 0.05]]))
    side /= np.linalg.norm(side, axis=1)[:, None] + 1e-12
    other = _crossed(along, side)
    turn = 2 * np.pi * np.arange(sides) / sides
    rings = points[:, None] + size[:, None, None] * (
        np.cos(turn)[None, :, None] * side[:, None] + np.sin(turn)[None, :, None] * other[:, None]
    )
    triangles = _skin(len(points), sides)
    if not closed:
        return rings.reshape(-1, 3), triangles
    first, last = len(points) * sides, len(points) * sides + 1
    k = np.arange(sides)
    ends = [np.stack([np.full(sides, first), (k + 1) % sides, k], axis=1)]
    top = (len(points) - 1) * sides
    ends.append(np.stack([np.full(sides, last), top + k, top + (k + 1) % sides], axis=1))
    return np.vstack([rings.reshape(-1, 3), points[:1], points[-1:]]), np.vstack([triangles, *ends]).astype(np.uint32)


def _crossed(a: Floats, b: Floats) -> Floats:
    """Return the cross products of rows (n, 3), to the bit as np.cross, which takes twice as long for few rows."""
    (ax, ay, az), (bx, by, bz) = a.T, b.T
    return np.array([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx]).T


def ribbon(line: ArrayLike, across: ArrayLike, widths: ArrayLike) -> Mesh:
    """Return a strip along a line (n, 3), with a width (n,) along `across`, (3,) or (n, 3)."""
    points, half = np.asarray(line, np.float64), 0.5 * np.asarray(widths, np.float64)[:, None] * np.asarray(across)
    vertices = np.stack([points - half, points + half], axis=1).reshape(-1, 3)
    a = 2 * np.arange(len(points) - 1)
    return vertices, np.vstack([np.stack([a, a + 1, a + 3], axis=1), np.stack([a, a + 3, a + 2], axis=1)]).astype(
        np.uint32
    )


def revolved(radii: ArrayLike, heights: ArrayLike, sides: int = 12) -> Mesh:
    """Return a surface of revolution about z through points (radius, height)."""
    turn = 2 * np.pi * np.arange(sides) / sides
    r, z = np.asarray(radii, np.float64)[:, None], np.asarray(heights, np.float64)[:, None]
    rings = np.stack([r * np.cos(turn), r * np.sin(turn), np.broadcast_to(z, (len(r), sides))], axis=-1)
    return rings.reshape(-1, 3), _skin(len(r), sides)


def turned_to(mesh: Mesh, axis: ArrayLike, at: ArrayLike = (0.0, 0.0, 0.0)) -> Mesh:
    """Return a mesh whose z is turned to an axis (3,), and which is then moved."""
    z = np.asarray(axis, np.float64) / np.linalg.norm(axis)
    x = np.cross([0.31, 0.95, 0.05], z)
    x /= np.linalg.norm(x)
    return mesh[0] @ np.stack([x, np.cross(z, x), z]) + np.asarray(at), mesh[1]


def directions(count: int) -> Floats:
    """Return evenly spread unit vectors (count, 3), on a spiral from pole to pole (Saff and Kuijlaars 1997)."""
    z = 1 - 2 * (np.arange(count) + 0.5) / count
    turn = np.pi * (1 + 5**0.5) * np.arange(count)
    r = np.sqrt(1 - z * z)
    return np.stack([r * np.cos(turn), r * np.sin(turn), z], axis=1)


def _skin(rings: int, sides: int) -> Triangles:
    a = np.arange((rings - 1) * sides).reshape(rings - 1, sides)
    b = np.roll(a, -1, axis=1)
    return np.stack([a, b, b + sides, a, b + sides, a + sides], axis=-1).reshape(-1, 3).astype(np.uint32)


BOX = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])


def lying_about(random: np.random.Generator) -> list[Mesh]:
    """Return a bottle, a can, a tyre, a plank and a brick, of length 1."""
    bottle = revolved([0, 0.5, 0.55, 0.55, 0.5, 0.2, 0.18, 0.18], [0, 0, 0.05, 1.3, 1.6, 1.9, 2.4, 2.4], 12)
    can = revolved([0, 0.5, 0.52, 0.52, 0.48, 0.0], [0, 0, 0.05, 1.85, 1.9, 1.88], 12)
    around = np.linspace(0, 2 * np.pi, 19)
    tyre = tube(np.stack([np.cos(around), np.sin(around), 0 * around], axis=-1), np.full(19, 0.32), 8, closed=False)
    lying = [turned_to(shape, [1.0, 0.05, random.uniform(0, 0.15)]) for shape in (bottle, can)]
    return [unit(shape) for shape in (*lying, tyre, _box(1.0, 0.16, 0.04), _box(0.24, 0.115, 0.07))]


def _box(*size: float) -> Mesh:
    faces = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6],
             [0, 6, 4], [1, 5, 7], [1, 7, 3]]  # fmt: skip
    return merged([(BOX * size, np.array(faces, np.uint32))])


RINGS, SIDES = 12, 8
TAIL = 0.84
"""Where the body ends and the tail fin begins, in lengths from the nose."""


def fish(length_m: float, depth: float, flatness: float, phase: float) -> Mesh:
    """Return a fish that looks along x, z up, its origin in its middle.

    depth: largest height of the body, in lengths. flatness: its width over its height. phase: of the tail's beat, of 1.
    """
    along = TAIL * (0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, RINGS)))
    line = np.column_stack([0.5 - along, np.zeros(RINGS), np.zeros(RINGS)])
    height = np.maximum(_profile(along / TAIL) * 0.5 * depth, 0.012)
    height[0] = 0.004
    vertices, triangles = tube(line, np.ones(RINGS), SIDES)
    ring = np.minimum(np.arange(len(vertices)) // SIDES, RINGS - 1)
    ring[-2:] = 0, RINGS - 1
    turn = 2 * np.pi * (np.arange(len(vertices)) % SIDES) / SIDES
    radial = np.ones(len(vertices))
    radial[-2:] = 0.0
    vertices[:, 0] = line[ring, 0]
    vertices[:, 1] = radial * flatness * height[ring] * np.cos(turn)
    vertices[:, 2] = radial * height[ring] * np.sin(turn)
    parts = [(vertices, triangles), _tail(depth), _back_fin(depth)]
    points, faces = merged(parts)
    share = 0.5 - points[:, 0]
    points[:, 1] += _sway(share, phase)
    return length_m * points, faces


def _sway(share: Floats, phase: float) -> Floats:
    """Return the sideways displacement along a carangiform swimmer, in lengths.

    A wave of one length runs along the body with an amplitude of 0.02 - 0.08 x + 0.16 x^2 (Videler 1993, "Fish
    Swimming", ch. 6).
    """
    amplitude = 0.02 - 0.08 * share + 0.16 * share**2
    return np.asarray(amplitude * np.sin(2 * np.pi * (share - phase)))


def _profile(share: Floats) -> Floats:
    """Return the height of a body, of its largest: full ahead of the middle, and thin at the root of the tail."""
    full = 1.6 * np.sqrt(np.clip(share, 0, 1)) * (1 - share) + 0.9 * share * (1 - share)
    return np.asarray(full / 0.83 + 0.16 * share)


def _tail(depth: float) -> Mesh:
    spread, root = 0.36 * depth + 0.06, 0.02
    points = [(TAIL - 0.03, root), (TAIL - 0.03, -root), (1.0, spread), (0.93, 0.0), (1.0, -spread)]
    vertices = np.array([(0.5 - x, 0.0, z) for x, z in points])
    return vertices, np.array([[0, 2, 3], [0, 3, 1], [1, 3, 4]], np.uint32)


def _back_fin(depth: float) -> Mesh:
    high = 0.5 * depth
    points = [(0.30, 0.9 * high), (0.42, high + 0.09), (0.66, 0.75 * high), (0.52, 0.8 * high)]
    low = [(0.50, -0.8 * high), (0.66, -high - 0.03), (0.70, -0.5 * high)]
    vertices = np.array([(0.5 - x, 0.0, z) for x, z in points + low])
    return vertices, np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6]], np.uint32)
