"""Parts of a mesh: their union by manifold3d, and where their surfaces cross."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

import manifold3d
import numpy as np
from numpy.typing import NDArray

from uwsim.scenario.read.mesh_file import Vertices

if TYPE_CHECKING:  # takes a second to import, and is not needed for a cached hull
    from uwsim.base.whole_trimesh import trimesh

MIN_OVERLAP = 1e-6  # fraction of the volume; parts that overlap by less are not united
TOUCH_TOLERANCE = 1e-9  # fraction of an edge or triangle; a crossing this close to its end or rim is only a touch


def united(mesh: trimesh.Trimesh) -> tuple[trimesh.Trimesh, int] | None:
    """Return the union of the parts of a closed mesh, and the number of parts, or None if none overlap.

    A part with negative volume is a cavity in the smallest part around it. Raises ValueError if a part intersects
    itself in a way that manifold3d does not accept.
    """
    parts = parts_of(mesh)
    solids = sorted((part for part in parts if volume(part) > 0.0), key=volume)
    if len(solids) < 2:
        return None
    lows, highs = np.array([part.bounds for part in solids]).transpose(1, 0, 2)
    if ((lows[:, None] < highs[None]) & (lows[None] < highs[:, None])).all(axis=2).sum() <= len(solids):
        return None
    groups = [[part] for part in solids]
    for cavity in (part for part in parts if volume(part) <= 0.0):
        around = (k for k, solid in enumerate(solids) if is_around(solid, cavity))
        groups[next(around, -1)].append(cavity)
    bodies = [manifold(whole_of(group)) for group in groups]
    for body in bodies:
        if body.status() != manifold3d.Error.NoError:
            raise ValueError(f"a part is not a solid ({body.status().name})")
    whole = manifold3d.Manifold.batch_boolean(bodies, manifold3d.OpType.Add)
    if whole.volume() >= sum(body.volume() for body in bodies) * (1.0 - MIN_OVERLAP):
        return None
    return as_mesh(whole), len(bodies)


def parts_of(mesh: trimesh.Trimesh) -> list[trimesh.Trimesh]:
    """Return the parts of a mesh whose triangles share edges."""
    return list(mesh.split(only_watertight=False, repair=False))


def whole_of(parts: list[trimesh.Trimesh]) -> trimesh.Trimesh:
    """Return parts as one mesh."""
    from uwsim.base.whole_trimesh import trimesh

    return cast("trimesh.Trimesh", trimesh.util.concatenate(parts))


def manifold(mesh: trimesh.Trimesh) -> manifold3d.Manifold:
    """Return a mesh as manifold3d's, whose status is NoError for a solid."""
    vertices, faces = np.ascontiguousarray(mesh.vertices), np.ascontiguousarray(mesh.faces, np.uint64)
    return manifold3d.Manifold(manifold3d.Mesh64(vertices, faces))


def as_mesh(solid: manifold3d.Manifold) -> trimesh.Trimesh:
    """Return a solid as a mesh."""
    from uwsim.base.whole_trimesh import trimesh

    out = solid.to_mesh64()
    return trimesh.Trimesh(np.array(out.vert_properties[:, :3]), np.array(out.tri_verts, np.int64), process=False)


def crossings(solid: manifold3d.Manifold) -> int:
    """Return the number of edges that pierce a triangle with which they share no vertex; touching does not count."""
    out = solid.to_mesh64()
    vertices, faces = np.array(out.vert_properties[:, :3]), np.array(out.tri_verts, np.int64)
    edges = np.unique(np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    met = ((k, hit.face_id) for k, ends in enumerate(vertices[edges]) for hit in solid.ray_cast(*ends))
    edge, face = np.fromiter(met, np.dtype((np.int64, 2))).T
    disjoint = (edges[edge][:, :, None] != faces[face][:, None, :]).all(axis=(1, 2))
    return int(_pierces(vertices[edges[edge[disjoint]]], vertices[faces[face[disjoint]]]).sum())


def _pierces(ends: Vertices, corners: Vertices) -> NDArray[np.bool_]:
    """Return a mask (n,) of segments (n, 2, 3) that pass through their triangles (n, 3, 3) (Moeller, Trumbore 1997)."""
    segment = ends[:, 1] - ends[:, 0]
    ab, ac = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    across = np.cross(segment, ac)
    det = np.einsum("ij,ij->i", ab, across)
    size = np.linalg.norm(segment, axis=1) * np.linalg.norm(np.cross(ab, ac), axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        offset = ends[:, 0] - corners[:, 0]
        u = np.einsum("ij,ij->i", offset, across) / det
        turned = np.cross(offset, ab)
        v = np.einsum("ij,ij->i", segment, turned) / det
        t = np.einsum("ij,ij->i", ac, turned) / det
        low, high = TOUCH_TOLERANCE, 1 - TOUCH_TOLERANCE
        inside = (u > low) & (v > low) & (u + v < high) & (t > low) & (t < high)
    return np.asarray(inside & (np.abs(det) > 1e-12 * size), np.bool_)


def volume(mesh: trimesh.Trimesh) -> float:
    """Return the signed volume of a mesh."""
    return volume_within(mesh.triangles)


def volume_within(corners_m: NDArray[np.float64]) -> float:
    """Return the signed volume within triangles, by their corners (n, 3, 3)."""
    a, b, c = corners_m.transpose(1, 0, 2)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def is_around(outer: trimesh.Trimesh, inner: trimesh.Trimesh) -> bool:
    """Return whether a mesh's box contains another's."""
    return bool((outer.bounds[0] < inner.bounds[0]).all() and (inner.bounds[1] < outer.bounds[1]).all())
