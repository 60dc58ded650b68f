"""Repairs meshes that must be closed, such as hulls; a warning describes each repair."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from uwsim.scenario.read.disk_cache import cached_arrays
from uwsim.scenario.read.errors import RepairWarning, ScenarioError
from uwsim.scenario.read.mesh_closing import closed
from uwsim.scenario.read.mesh_file import Triangles, Vertices
from uwsim.scenario.read.mesh_union import crossings, is_around, manifold, parts_of, united, volume, whole_of

if TYPE_CHECKING:  # takes a second to import, and is not needed for a cached hull
    from uwsim.base.whole_trimesh import trimesh


def closed_mesh(vertices_m: Vertices, triangles: NDArray[Any], name: str = "mesh") -> tuple[Vertices, Triangles]:
    """Return the same surface closed and winding outward, with equal vertices merged. Raises ScenarioError.

    In the result, every edge is shared by two triangles that traverse it in opposite directions, and the volume is
    positive. Overlapping closed parts are united. A surface that is open, or still intersects itself, is closed part by
    part, see mesh_closing. Merging vertices that STL duplicates is
    silent; any other repair issues a RepairWarning. The result is kept on disk, with its warning.
    """
    if not len(triangles):
        raise ScenarioError(f"mesh '{name}': has no triangles")
    points_m, faces, note = cached_arrays(lambda: _closed(vertices_m, triangles, name), "closed", vertices_m, triangles)
    if len(note):
        warnings.warn(f"mesh '{name}': {note.tobytes().decode()}", RepairWarning, stacklevel=2)
    return cast(Vertices, points_m), cast(Triangles, faces)


def _closed(vertices_m: Vertices, triangles: NDArray[Any], name: str) -> tuple[Vertices, Triangles, NDArray[np.uint8]]:
    """Return the closed mesh, and the text that describes the repairs. Raises ScenarioError."""
    from uwsim.base.whole_trimesh import trimesh

    mesh = trimesh.Trimesh(vertices_m, np.asarray(triangles, np.int64), process=False)
    mesh.merge_vertices(merge_tex=True, merge_norm=True)
    mesh.update_faces(mesh.nondegenerate_faces() & mesh.unique_faces())
    mesh.remove_unreferenced_vertices()
    given = mesh.copy()
    repairs = _repair(mesh)
    note = ""
    if not _is_closed(mesh):
        defects = _defects(given)
        try:
            mesh, done = closed(given)
        except ValueError as error:
            raise ScenarioError(f"mesh '{name}': is not closed ({defects}) and {error}") from None
        note = f"was not closed ({defects}): {', '.join(done)}"
    else:
        if mesh.volume <= 0.0:
            raise ScenarioError(f"mesh '{name}': encloses no volume")
        try:
            mesh = _without_overlaps(mesh, repairs)
        except ValueError as error:
            raise ScenarioError(f"mesh '{name}': {', '.join(repairs)} and {error}") from None
        if repairs:
            note = f"repaired: {', '.join(repairs)}"
    points_m, faces = np.asarray(mesh.vertices, np.float64), np.asarray(mesh.faces, np.uint32)
    return points_m, faces, np.frombuffer(note.encode(), np.uint8)


def _without_overlaps(mesh: trimesh.Trimesh, repairs: list[str]) -> trimesh.Trimesh:
    """Unite overlapping parts, close what still intersects itself, and record it in `repairs`. Raises ValueError."""
    try:
        whole = united(mesh)
    except ValueError as error:  # a part is no solid
        repairs.append(f"its parts overlap and {error}")
    else:
        if whole is not None:
            mesh, count = whole
            repairs.append(f"united {count} parts that overlapped")
        pierced = crossings(manifold(mesh))
        if not pierced:
            return mesh
        repairs.append(f"crosses itself ({pierced} edges pierce its triangles)")
    mesh, done = closed(mesh)
    repairs.extend(done)
    return mesh


def _repair(mesh: trimesh.Trimesh) -> list[str]:
    """Repair the mesh in place; return descriptions of the repairs."""
    from uwsim.base.whole_trimesh import trimesh

    repairs = []
    if not mesh.is_watertight:
        before = len(mesh.faces)
        trimesh.repair.fill_holes(mesh, use_fan=True)
        if len(mesh.faces) > before:
            repairs.append(f"filled holes with {len(mesh.faces) - before} triangles")
    if mesh.is_watertight and not mesh.is_winding_consistent:  # otherwise each part is closed alone
        trimesh.repair.fix_winding(mesh)  # type: ignore[no-untyped-call]
        repairs.append("made the winding consistent")
    parts = parts_of(mesh) if _is_closed(mesh) else []
    inverted = [part for part in parts if volume(part) < 0.0 and not any(is_around(each, part) for each in parts)]
    if inverted:
        for part in inverted:
            part.invert()
        whole = whole_of(parts)
        mesh.vertices, mesh.faces = whole.vertices, whole.faces
        repairs.append("turned inside-out parts outward")
    return repairs


def _is_closed(mesh: trimesh.Trimesh) -> bool:
    return bool(mesh.is_watertight and mesh.is_winding_consistent)


def _defects(mesh: trimesh.Trimesh) -> str:
    _, uses = np.unique(mesh.edges_sorted, axis=0, return_counts=True)
    found = [
        f"{count} edges {what}"
        for count, what in (
            (np.sum(uses == 1), "of one triangle only"),
            (np.sum(uses > 2), "of more than two triangles"),
        )
        if count
    ]
    return ", ".join(found) or "triangles that wind against each other"
