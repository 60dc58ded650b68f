"""Closes meshes made for rendering: open, inside-out or crossing meshes, and meshes of many parts that share edges.

Each connected part is made a solid: its winding is made consistent, each hole is capped by a fan around the middle of
its rim, and it is turned outward. A part that intersects itself in many places is wrapped: its capped surface is
thickened by a cell, filled, and thinned again, on a grid of WRAP_CELLS cells along its longest side, or along SHORT of
the whole mesh's if it is shorter; its convex hull replaces a part of less than FEW_CELLS. The union of these solids is
the hull.
"""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, Any

import manifold3d
import numpy as np
from numpy.typing import NDArray

from uwsim.scenario.read.mesh_union import as_mesh, crossings, manifold, parts_of, volume

if TYPE_CHECKING:
    from uwsim.base.whole_trimesh import trimesh

WRAP_CELLS, FEW_CELLS = 48, 8
SHORT = 0.25
SHEET = 1e-4
"""Volume of a capped part, as a fraction of its area to the power of 3/2, below which it is an open sheet."""
FEW_CROSSINGS = 0.01
"""Largest number of pierced edges per triangle with which a part is accepted; its volume counts overlaps twice."""


def closed(mesh: trimesh.Trimesh) -> tuple[trimesh.Trimesh, list[str]]:
    """Return a closed mesh and a description of the changes. Raises ValueError if it encloses nothing."""
    given_m3 = abs(volume(mesh))
    parts, done = _capped_parts(mesh)
    if not parts:
        raise ValueError("encloses no volume")
    solids = [_solid(part) for part in parts]
    wrapped, small, least_m = [], 0, SHORT * float(mesh.extents.max())
    for k, part in enumerate(parts):
        if solids[k] is not None:
            continue
        cell_m = max(longest_m := float(part.extents.max()), least_m) / WRAP_CELLS
        if longest_m < FEW_CELLS * cell_m:
            solids[k] = manifold3d.Manifold.hull_points(np.array(part.vertices))
            small += 1
        else:
            solids[k] = wrap(part, cell_m)
            wrapped.append(cell_m)
    found = as_mesh(manifold3d.Manifold.batch_boolean(solids, manifold3d.OpType.Add))
    if wrapped:
        done.append(f"wrapped {len(wrapped)} parts that cross themselves, to within {max(wrapped):.2g} m")
    if small:
        done.append(f"replaced {small} small parts that cross themselves by their convex hulls")
    if len(parts) > 1:
        done.append(f"united {len(parts)} parts")
    change = f", {100 * (found.volume / given_m3 - 1):+.1f} % of that of the given triangles" if given_m3 > 0 else ""
    return found, [*done, f"it encloses {found.volume:.4g} m3{change}"]


def _capped_parts(mesh: trimesh.Trimesh) -> tuple[list[trimesh.Trimesh], list[str]]:
    """Return the connected parts that enclose a volume, capped and turned outward, and a description of the changes."""
    from uwsim.base.whole_trimesh import trimesh

    parts, holes, turned, sheets = [], 0, 0, 0
    for part in parts_of(mesh):
        if not part.is_winding_consistent:
            trimesh.repair.fix_winding(part)  # type: ignore[no-untyped-call]
        capped, rims = _capped(np.asarray(part.vertices, np.float64), np.asarray(part.faces, np.int64))
        volume_m3 = volume(capped)
        if abs(volume_m3) < SHEET * capped.area**1.5:
            sheets += 1
            continue
        if volume_m3 < 0.0:
            capped.invert()
            turned += 1
        holes += rims
        parts.append(capped)
    counts = (
        (holes, "capped {} holes"), (turned, "turned {} parts outward"), (sheets, "left out {} sheets without inside"),
    )  # fmt: skip
    return parts, [text.format(count) for count, text in counts if count]


def _solid(part: trimesh.Trimesh) -> manifold3d.Manifold | None:
    """Return a closed part as a solid, or None if it is not a solid or intersects itself in many places."""
    solid = manifold(part)
    is_solid = solid.status() == manifold3d.Error.NoError and crossings(solid) <= FEW_CROSSINGS * len(part.faces)
    return solid if is_solid else None


def _capped(vertices: NDArray[np.float64], faces: NDArray[np.int64]) -> tuple[trimesh.Trimesh, int]:
    """Return a part with a fan on each of its rims, and their number."""
    from uwsim.base.whole_trimesh import trimesh

    uses = Counter(map(tuple, faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2).tolist()))
    onward: dict[int, list[int]] = {}
    for (a, b), count in uses.items():
        onward.setdefault(a, []).extend([b] * (count - uses.get((b, a), 0)))
    middles, fans, rims = [], [], 0
    for rim in _simple_cycles(onward):
        middle = len(vertices) + rims
        middles.append(vertices[rim].mean(axis=0))
        fans += [(b, a, middle) for a, b in zip(rim, [*rim[1:], rim[0]], strict=True)]
        rims += 1
    if rims:
        vertices, faces = np.vstack([vertices, middles]), np.vstack([faces, fans])
    return trimesh.Trimesh(vertices, faces, process=False), rims


def _simple_cycles(onward: dict[int, list[int]]) -> list[list[int]]:
    """Return cycles without repeated vertices that use each directed edge once.

    onward: the ends of the edges from each vertex, which has as many incoming as outgoing edges.
    """
    cycles = []
    for start in sorted(onward):
        while onward[start]:
            walk = [start]
            while True:
                end = onward[walk[-1]].pop()
                if end in walk:
                    cut = walk.index(end)
                    cycles.append(walk[cut:])
                    del walk[cut + 1 :]
                    if cut == 0:
                        break
                else:
                    walk.append(end)
    return cycles


def wrap(part: trimesh.Trimesh, cell_m: float) -> manifold3d.Manifold:
    """Return the space that cannot be reached from outside through gaps of less than two cells, as a solid."""
    from scipy.ndimage import distance_transform_edt, label
    from scipy.spatial import cKDTree

    from uwsim.base.whole_trimesh import trimesh

    low, high = part.vertices.min(axis=0), part.vertices.max(axis=0)
    low, high = low - 4 * cell_m, high + 4 * cell_m
    shape = np.ceil((high - low) / cell_m).astype(int) + 1
    points = np.stack(np.meshgrid(*(np.arange(n) for n in shape), indexing="ij"), axis=-1) * cell_m + low
    vertices, _ = trimesh.remesh.subdivide_to_size(  # type: ignore[no-untyped-call]
        part.vertices, part.faces, 0.5 * cell_m, max_iter=30
    )
    far = cKDTree(vertices).query(points.reshape(-1, 3), distance_upper_bound=2 * cell_m)[0].reshape(shape) > cell_m
    regions, _ = label(far)
    inside: Any = (distance_transform_edt(regions != regions[0, 0, 0]) * cell_m - cell_m).tolist()
    (x0, y0, z0), (last_i, last_j, last_k) = low.tolist(), (shape - 2).tolist()

    def height(x: float, y: float, z: float) -> float:
        """Return the field between the grid's points, positive inside. Plain numbers, for speed."""
        u, v, w = (x - x0) / cell_m, (y - y0) / cell_m, (z - z0) / cell_m
        i, j, k = min(int(u), last_i), min(int(v), last_j), min(int(w), last_k)
        u, v, w = u - i, v - j, w - k
        (a, b), (c, d) = inside[i][j : j + 2], inside[i + 1][j : j + 2]
        low_z, high_z = (((a[n] * (1 - u) + c[n] * u) * (1 - v) + (b[n] * (1 - u) + d[n] * u) * v) for n in (k, k + 1))
        return float(low_z * (1 - w) + high_z * w)

    skin = manifold3d.Manifold.level_set(height, [*(low + cell_m), *(high - 2 * cell_m)], cell_m, 0.0)
    return skin.simplify(0.1 * cell_m)
