"""Solids for the mesh generators: built with manifold3d, united without overlaps, written as OBJ."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from manifold3d import Manifold

Point = tuple[float, float, float]


def box(low: Point, high: Point) -> Manifold:
    """Return the cuboid between two corners."""
    size = np.subtract(high, low)
    return Manifold.cube(tuple(size)).translate(low)


def rod(start: Point, end: Point, radius_m: float, sides: int = 12) -> Manifold:
    """Return a cylinder between two points."""
    along = np.subtract(end, start)
    length = float(np.linalg.norm(along))
    pitch = np.degrees(np.arccos(along[2] / length))
    yaw = np.degrees(np.arctan2(along[1], along[0]))
    return Manifold.cylinder(length, radius_m, circular_segments=sides).rotate((0, pitch, yaw)).translate(start)


def ball(centre: Point, radius_m: float, sides: int = 12) -> Manifold:
    """Return a sphere."""
    return Manifold.sphere(radius_m, sides).translate(centre)


def hull(points: list[Point]) -> Manifold:
    """Return the convex hull of points."""
    return Manifold.hull_points(np.asarray(points, np.float64))


def united(parts: list[Manifold]) -> Manifold:
    """Return the union of solids, without slivers thinner than 0.1 mm."""
    total = Manifold()
    for part in parts:
        total += part
    return total.simplify(1e-4)


def centroid(solid: Manifold) -> Point:
    """Return the centre of volume, from the tetrahedra formed by the triangles and the origin."""
    mesh = solid.to_mesh()
    corners = np.asarray(mesh.vert_properties, np.float64)[:, :3][np.asarray(mesh.tri_verts)]
    volumes = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    return tuple(volumes @ corners.sum(axis=1) / (4 * volumes.sum()))


def write_obj(solid: Manifold, path: Path, comment: str) -> None:
    """Write the solid with vertices rounded to 0.01 mm, and print its size."""
    mesh = solid.to_mesh()
    vertices = np.round(np.asarray(mesh.vert_properties, np.float64)[:, :3], 5) + 0.0
    lines = [f"# {comment}", *("v {:.5f} {:.5f} {:.5f}".format(*vertex) for vertex in vertices)]
    lines += ["f {} {} {}".format(*(triangle + 1)) for triangle in np.asarray(mesh.tri_verts, np.int64)]
    path.write_text("\n".join(lines) + "\n")
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    print(
        f"{path.name}: {solid.num_tri()} triangles, {solid.volume():.4f} m3, from {low} to {high} m, "
        f"centre of volume {np.round(centroid(solid), 4)} m"
    )
