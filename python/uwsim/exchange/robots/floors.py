"""The bed of a world whose floor is a body of its own: a plane, level or not, or the ground of a pool."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import distance_transform_edt

from uwsim.exchange.robots.robot import Description, Mesh
from uwsim.exchange.robots.xml_file import Floats

LEVEL, STEEP, BED_M = 0.99999, 0.5, -0.5
"""A plane is a bed if its normal is this far up, level or sloped, and if it is below this height."""
COVERS, ROOM_M, SAMPLES = 0.9, 2.0, 41
"""The share of the extent of all fixed bodies below which one has to be to be the ground, and how far about each
vehicle; places along an edge where that is tried."""
TRIANGLES_MAX = 200_000
EDGE = 1e-9


def put_plane(found: Description, path: str, point_m: Floats, up: Floats) -> None:
    """Take a plane under water as the bed: the deepest of several that are level, else a sloped one.

    path: of its element. up: its unit normal.
    """
    height_m = float(point_m[2])
    if up[2] > LEVEL and height_m <= BED_M:
        found.bed_z_m = height_m if found.bed_z_m is None else min(height_m, found.bed_z_m)
    elif up[2] > STEEP and height_m <= BED_M:
        found.bed_plane = point_m, up
    else:
        found.left_out(f"{path}: at {height_m:g} m, it is no bed under water")


def plane_heights(point_m: Floats, normal: Floats, x: Floats, y: Floats) -> Floats:
    """Return the heights (ny, nx) at x (nx,) and y (ny,) of a plane through a point that is not upright."""
    slope = -normal[:2] / normal[2]
    return np.asarray(point_m[2] + slope[0] * (x[None, :] - point_m[0]) + slope[1] * (y[:, None] - point_m[1]))


def ground_of(meshes: dict[str, Mesh], places_m: Floats) -> str | None:
    """Return the name of the body that is the ground: under all places (n, 3), and as wide as all that is in the water.

    What stands above the water, such as a pool's deck, does not count.
    """
    wet = {name: vertices[vertices[:, 2] < BED_M] for name, (vertices, _) in meshes.items()}
    boxes = {name: np.array([each.min(axis=0), each.max(axis=0)]) for name, each in wet.items() if len(each)}
    if not boxes:
        return None
    every = np.concatenate(list(boxes.values()))
    x, y = np.linspace(every.min(axis=0), every.max(axis=0), SAMPLES + 2)[1:-1, :2].T
    for name, (least, most) in boxes.items():
        around = (least[:2] + ROOM_M <= places_m[:, :2]) & (places_m[:, :2] <= most[:2] - ROOM_M)
        is_low = around.all() and least[2] < places_m[:, 2].min() and len(meshes[name][1]) <= TRIANGLES_MAX
        if is_low and np.isfinite(top_heights(meshes[name], BED_M, x, y)).mean() >= COVERS:
            return name
    return None


def ground_heights(mesh: Mesh, below_m: float, x: Floats, y: Floats) -> Floats | None:
    """Return `top_heights` with those of the nearest edge beside the body, or None if it has none."""
    heights = top_heights(mesh, below_m, x, y)
    known = np.isfinite(heights)
    if not known.any():
        return None
    rows, columns = distance_transform_edt(~known, return_distances=False, return_indices=True)
    return np.asarray(heights[rows, columns])


def top_heights(mesh: Mesh, below_m: float, x: Floats, y: Floats) -> Floats:
    """Return the height (ny, nx) of a body's highest surface below a level, -inf beside it, at x (nx,) and y (ny,).

    Triangles may wind either way, as those of others' pools do.
    """
    heights, corners = np.full((len(y), len(x)), -np.inf), mesh[0][mesh[1]]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    down = across[:, 2] < 0.0
    corners[down], across[down] = corners[down][:, ::-1], -across[down]
    flat = across[:, 2] > EDGE * np.linalg.norm(across, axis=1)
    for (a, b, c), normal in zip(corners[flat], across[flat], strict=True):
        (west, south), (east, north) = (edge([a, b, c], axis=0)[:2] for edge in (np.min, np.max))
        i0, i1 = np.searchsorted(x, [west - EDGE, east + EDGE])
        j0, j1 = np.searchsorted(y, [south - EDGE, north + EDGE])
        if i0 == i1 or j0 == j1:
            continue
        px, py = x[None, i0:i1], y[j0:j1, None]
        inside = np.ones((j1 - j0, i1 - i0), bool)
        for (sx, sy, _), (ex, ey, _) in ((a, b), (b, c), (c, a)):
            inside &= (ex - sx) * (py - sy) - (ey - sy) * (px - sx) >= -EDGE
        z = plane_heights(a, normal, x[i0:i1], y[j0:j1])
        part = heights[j0:j1, i0:i1]
        part[inside & (z < below_m) & (z > part)] = z[inside & (z < below_m) & (z > part)]
    return heights


def grid_text(heights: Floats, spacing_m: float) -> bytes:
    """Return heights (ny, nx), from south to north, as an ESRI ASCII grid about the origin."""
    rows, columns = heights.shape
    head = {
        "ncols": columns, "nrows": rows, "xllcorner": -0.5 * columns * spacing_m, "yllcorner": -0.5 * rows * spacing_m,
        "cellsize": spacing_m,
    }  # fmt: skip
    lines = [f"{key} {value!r}" for key, value in head.items()]
    return "\n".join([*lines, *(" ".join(f"{z:.4f}" for z in row) for row in heights[::-1]), ""]).encode()
