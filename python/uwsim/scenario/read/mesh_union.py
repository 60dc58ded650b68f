"""Union of the overlapping closed parts of a mesh, and detection of self-intersecting surfaces."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from uwsim.scenario.read.mesh_file import Vertices

if TYPE_CHECKING:
    from uwsim.base.whole_trimesh import trimesh

Faces = NDArray[Any]

MIN_OVERLAP = 1e-6  # fraction of the volume; parts that overlap by less are not united
TOUCH_TOLERANCE = 1e-9  # fraction of an edge or triangle; a crossing this close to its end or rim is only a touch
MAX_PAIRS = 400_000  # pairs of an edge and a box tested at once


def united(mesh: trimesh.Trimesh) -> tuple[trimesh.Trimesh, int] | None:
    """Return the union of the parts of a closed mesh, and the number of parts, or None if none overlap.

    A part with negative volume is a cavity in the smallest part around it. Raises ValueError if a part intersects
    itself in a way that manifold3d does not accept.
    """
    faces = [mesh.faces[part] for part in _components(mesh)]
    solids = [part for part in faces if _volume(mesh, part) > 0.0]
    cavities = [part for part in faces if _volume(mesh, part) <= 0.0]
    if len(solids) < 2 or not _boxes_meet(mesh, solids):
        return None
    import manifold3d

    from uwsim.base.whole_trimesh import trimesh

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
        groups[_solid_around(mesh, solids, cavity)].append(cavity)
    bodies = [manifold(np.vstack(group)) for group in groups]
    whole = manifold3d.Manifold.batch_boolean(bodies, manifold3d.OpType.Add)
    separate_volume = sum(body.volume() for body in bodies)
    if whole.volume() >= separate_volume * (1.0 - MIN_OVERLAP):
        return None
    out = whole.to_mesh64()
    return trimesh.Trimesh(np.array(out.vert_properties[:, :3]), np.array(out.tri_verts), process=False), len(bodies)


def crossings(vertices: Vertices, faces: Faces) -> int:
    """Return the number of edges that pierce a triangle with which they share no vertex; touching does not count."""
    faces = np.asarray(faces, np.int64)
    edges = np.unique(np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    ends, corners = vertices[edges], vertices[faces]
    edge_low, edge_high = ends.min(axis=1), ends.max(axis=1)
    order, levels = _tree(corners.min(axis=1), corners.max(axis=1))
    faces, corners = faces[order], corners[order]
    found = 0
    pending = [(0, np.arange(len(edges)), np.zeros(len(edges), np.int64))]
    while pending:
        level, edge, node = pending.pop()
        if len(edge) > MAX_PAIRS:
            half = len(edge) // 2
            pending += [(level, edge[:half], node[:half]), (level, edge[half:], node[half:])]
            continue
        low, high = levels[level]
        near = ((low[node] <= edge_high[edge]) & (edge_low[edge] <= high[node])).all(axis=1)
        edge, node = edge[near], node[near]
        if level + 1 < len(levels):
            pending.append((level + 1, np.repeat(edge, 2), (2 * node[:, None] + [0, 1]).ravel()))
            continue
        disjoint = (edges[edge][:, :, None] != faces[node][:, None, :]).all(axis=(1, 2))
        found += int(_pierces(ends[edge[disjoint]], corners[node[disjoint]]).sum())
    return found


def _tree(low: Vertices, high: Vertices) -> tuple[NDArray[np.int64], list[tuple[Vertices, Vertices]]]:
    """Return an order of boxes (n, 3) along a Morton curve, and the binary tree of boxes over it, from its root.

    The boxes of level k, (2**k, 3) each, are around pairs of those of the next; the last are those given, and empty.
    """
    middle = low + high
    cell = (1023 * (middle - middle.min(axis=0)) / max(float(np.ptp(middle, axis=0).max()), 1e-300)).astype(np.int64)
    code = sum((cell[:, axis] >> bit & 1) << 3 * bit + axis for bit in range(10) for axis in range(3))
    order = np.argsort(code, kind="stable")
    leaves = 1 << (len(order) - 1).bit_length()
    levels = [(np.full((leaves, 3), np.inf), np.full((leaves, 3), -np.inf))]
    levels[0][0][: len(order)], levels[0][1][: len(order)] = low[order], high[order]
    while len(levels[-1][0]) > 1:
        low, high = levels[-1]
        levels.append((np.minimum(low[::2], low[1::2]), np.maximum(high[::2], high[1::2])))
    return order, levels[::-1]


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


def _components(mesh: trimesh.Trimesh) -> list[NDArray[np.int64]]:
    from uwsim.base.whole_trimesh import trimesh

    return list(trimesh.graph.connected_components(mesh.face_adjacency, nodes=np.arange(len(mesh.faces)), min_len=1))


def volume(corners: Vertices) -> float:
    """Return the signed volume of triangles (m, 3, 3)."""
    a, b, c = corners.transpose(1, 0, 2)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def _volume(mesh: trimesh.Trimesh, faces: Faces) -> float:
    return volume(mesh.vertices[faces])


def _box(mesh: trimesh.Trimesh, faces: Faces) -> tuple[Vertices, Vertices]:
    points = mesh.vertices[faces].reshape(-1, 3)
    return points.min(axis=0), points.max(axis=0)


def _boxes_meet(mesh: trimesh.Trimesh, parts: list[Faces]) -> bool:
    lows, highs = (np.array(side) for side in zip(*(_box(mesh, part) for part in parts), strict=True))
    meet = ((lows[:, None] < highs[None]) & (lows[None] < highs[:, None])).all(axis=2)
    return bool(meet.sum() > len(parts))


def _solid_around(mesh: trimesh.Trimesh, solids: list[Faces], cavity: Faces) -> int:
    """Return the index of the first (smallest) solid whose box contains the cavity's, or of the last if none does."""
    low, high = _box(mesh, cavity)
    for index, solid in enumerate(solids):
        outer_low, outer_high = _box(mesh, solid)
        if (outer_low < low).all() and (high < outer_high).all():
            return index
    return len(solids) - 1
