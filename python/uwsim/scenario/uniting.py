"""Closed parts that overlap are made one solid; surfaces that cross themselves are found."""

from __future__ import annotations

from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray

Vertices = NDArray[np.float64]
Faces = NDArray[Any]

OVERLAP = 1e-6  # share of the volume above which parts that overlap are united
INSIDE = 1e-9  # share of an edge or a triangle within which a crossing counts as a touch
CHUNK = 2_000_000  # pairs of an edge and a triangle looked at together


def united(mesh: trimesh.Trimesh) -> tuple[trimesh.Trimesh, int] | None:
    """Return the union of a closed mesh's parts and how many they were, or None when none of them overlap.

    A part of negative volume is a cavity of the smallest part round it. Raises ValueError when a part crosses itself
    in a way that the union (manifold3d) does not take.
    """
    faces = [mesh.faces[part] for part in _components(mesh)]
    solids = [part for part in faces if _volume(mesh, part) > 0.0]
    cavities = [part for part in faces if _volume(mesh, part) <= 0.0]
    if len(solids) < 2 or not _boxes_meet(mesh, solids):
        return None
    import manifold3d

    def manifold(triangles: Faces) -> Any:
        body = manifold3d.Manifold(
            manifold3d.Mesh64(
                np.ascontiguousarray(mesh.vertices, np.float64), np.ascontiguousarray(triangles, np.uint64)
            )
        )
        if body.status() != manifold3d.Error.NoError:
            raise ValueError(f"a part is not a solid ({body.status().name})")
        return body

    solids.sort(key=lambda part: _volume(mesh, part))
    groups = [[part] for part in solids]
    for cavity in cavities:
        groups[_holder(mesh, solids, cavity)].append(cavity)
    bodies = [manifold(np.vstack(group)) for group in groups]
    whole = manifold3d.Manifold.batch_boolean(bodies, manifold3d.OpType.Add)
    apart = sum(body.volume() for body in bodies)
    if whole.volume() >= apart * (1.0 - OVERLAP):
        return None
    out = whole.to_mesh64()
    return trimesh.Trimesh(np.asarray(out.vert_properties)[:, :3], np.asarray(out.tri_verts), process=False), len(
        bodies
    )


def crossings(vertices: Vertices, faces: Faces) -> int:
    """Count the edges that pierce a triangle with which they share no vertex; touching does not count."""
    faces = np.asarray(faces, np.int64)
    edges = np.unique(np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    ends, corners = vertices[edges], vertices[faces]
    edge_low, edge_high = ends.min(axis=1), ends.max(axis=1)
    face_low, face_high = corners.min(axis=1), corners.max(axis=1)
    order = np.argsort(face_low[:, 0])
    faces, corners, face_low, face_high = faces[order], corners[order], face_low[order], face_high[order]
    # Along x: triangles that begin before an edge ends, and are not surely past when it begins.
    widest = float(np.max(face_high[:, 0] - face_low[:, 0]))
    first = np.searchsorted(face_low[:, 0], edge_low[:, 0] - widest)
    last = np.searchsorted(face_low[:, 0], edge_high[:, 0], side="right")
    found = 0
    start = 0
    sums = np.concatenate([[0], np.cumsum(last - first)])
    while start < len(edges):
        end = max(start + 1, int(np.searchsorted(sums, sums[start] + CHUNK, side="right")) - 1)
        counts = (last - first)[start:end]
        edge = np.repeat(np.arange(start, end), counts)
        face = (
            np.arange(len(edge)) - np.repeat(np.cumsum(counts) - counts, counts) + np.repeat(first[start:end], counts)
        )
        near = ((face_low[face] < edge_high[edge]) & (edge_low[edge] < face_high[face])).all(axis=1)
        near |= _flat(face_low[face], face_high[face], edge_low[edge], edge_high[edge])
        edge, face = edge[near], face[near]
        apart = (edges[edge][:, :, None] != faces[face][:, None, :]).all(axis=(1, 2))
        edge, face = edge[apart], face[apart]
        found += int(_pierces(ends[edge], corners[face]).sum())
        start = end
    return found


def _flat(face_low: Vertices, face_high: Vertices, edge_low: Vertices, edge_high: Vertices) -> NDArray[np.bool_]:
    """Boxes of no thickness along an axis meet though none of their open intervals does."""
    meet = ((face_low <= edge_high) & (edge_low <= face_high)).all(axis=1)
    thin = ((face_low == face_high) | (edge_low == edge_high)).any(axis=1)
    return np.asarray(meet & thin, np.bool_)


def _pierces(ends: Vertices, corners: Vertices) -> NDArray[np.bool_]:
    """Whether each segment (n, 2, 3) passes through the inside of its triangle (n, 3, 3) (Moeller, Trumbore 1997)."""
    way = ends[:, 1] - ends[:, 0]
    ab, ac = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    across = np.cross(way, ac)
    det = np.einsum("ij,ij->i", ab, across)
    size = np.linalg.norm(way, axis=1) * np.linalg.norm(np.cross(ab, ac), axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        offset = ends[:, 0] - corners[:, 0]
        u = np.einsum("ij,ij->i", offset, across) / det
        turned = np.cross(offset, ab)
        v = np.einsum("ij,ij->i", way, turned) / det
        t = np.einsum("ij,ij->i", ac, turned) / det
        inside = (u > INSIDE) & (v > INSIDE) & (u + v < 1 - INSIDE) & (t > INSIDE) & (t < 1 - INSIDE)
    return np.asarray(inside & (np.abs(det) > 1e-12 * size), np.bool_)


def _components(mesh: trimesh.Trimesh) -> list[NDArray[np.int64]]:
    return list(trimesh.graph.connected_components(mesh.face_adjacency, nodes=np.arange(len(mesh.faces)), min_len=1))


def _volume(mesh: trimesh.Trimesh, faces: Faces) -> float:
    a, b, c = mesh.vertices[faces].transpose(1, 0, 2)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def _box(mesh: trimesh.Trimesh, faces: Faces) -> tuple[Vertices, Vertices]:
    points = mesh.vertices[faces].reshape(-1, 3)
    return points.min(axis=0), points.max(axis=0)


def _boxes_meet(mesh: trimesh.Trimesh, parts: list[Faces]) -> bool:
    lows, highs = (np.array(side) for side in zip(*(_box(mesh, part) for part in parts), strict=True))
    meet = ((lows[:, None] < highs[None]) & (lows[None] < highs[:, None])).all(axis=2)
    return bool(meet.sum() > len(parts))


def _holder(mesh: trimesh.Trimesh, solids: list[Faces], cavity: Faces) -> int:
    """Index of the first, smallest, solid whose box holds the cavity's."""
    low, high = _box(mesh, cavity)
    for index, solid in enumerate(solids):
        outer_low, outer_high = _box(mesh, solid)
        if (outer_low < low).all() and (high < outer_high).all():
            return index
    return len(solids) - 1
