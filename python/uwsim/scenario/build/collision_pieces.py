"""Collision shapes made of several convex pieces, which preserve the hollows that a single convex hull would fill.

CoACD (Wei et al. 2022, ACM Trans. Graph. 41(4)) takes ten seconds to a minute to decompose a hull of 2,000 triangles,
too long to do at every start. The decomposition is therefore done once (`uwsim vehicle decompose`), and the pieces are
stored as an asset next to the mesh; loading them does not require CoACD.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import ConvexHull, QhullError

from uwsim.base.atomic_file import write_atomically
from uwsim.base.extras import explained
from uwsim.scenario.build.hull import hull_placement, vehicle_hull
from uwsim.scenario.build.scale import size_text
from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.read.mesh_file import Forward, Triangles, Vertices, load_mesh
from uwsim.scenario.spec.vehicle import VehicleModel

MAX_PIECES = 256
MAX_STRETCH = 2.0
"""Largest ratio between the extents of pieces and hull, either way, along each axis; matching ones agree to a few
percent."""


def vehicle_pieces(model: VehicleModel) -> list[Vertices]:
    """Return a vehicle's collision pieces in the body frame, scaled and placed like its mesh. Raises ScenarioError."""
    assert model.collision_pieces is not None
    in_body, _ = vehicle_hull(model)
    factor, shift = hull_placement(model)
    in_file = load_pieces(model.collision_pieces, scale=model.mesh_scale, forward=model.mesh_forward or "x")
    pieces = [factor * piece + shift for piece in in_file]
    size_m, hull_m = np.ptp(np.concatenate(pieces), axis=0), np.ptp(in_body, axis=0)
    if not np.all((size_m <= MAX_STRETCH * hull_m) & (size_m * MAX_STRETCH >= hull_m)):
        raise ScenarioError(
            f"collision pieces '{model.collision_pieces}': {size_text(size_m)} together, must be those of the hull of "
            f"{size_text(hull_m)}: make them from its mesh with `uwsim vehicle decompose`",
            at=("collision_pieces",),
        )
    return pieces


def load_pieces(path: str | Path, *, scale: float = 1.0, forward: Forward = "x") -> list[Vertices]:
    """Return the corners (n, 3) of each convex piece: the hull of each connected part of the file's mesh.

    path: any file that load_mesh can read, with z up. scale, forward: those of the mesh from which they were made.
    Raises ScenarioError.
    """
    vertices, triangles = load_mesh(path, scale, "z", forward)
    count = len(vertices)
    pairs = np.concatenate([triangles[:, :2], triangles[:, 1:]]).astype(np.int64)
    links = coo_array((np.ones(len(pairs), np.int8), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    _, part_of = connected_components(links, directed=False)
    used = np.unique(triangles)
    parts = [used[part_of[used] == part] for part in np.unique(part_of[used])]
    if len(parts) > MAX_PIECES:
        raise ScenarioError(f"collision pieces '{path}': {len(parts)} separate parts, must be at most {MAX_PIECES}")
    return [_corners(vertices[part], f"collision pieces '{path}': part {k + 1}") for k, part in enumerate(parts)]


def decompose(
    vertices: Vertices, triangles: Triangles, *, threshold: float = 0.1, max_pieces: int = 24, seed: int = 0
) -> list[Vertices]:
    """Decompose a closed mesh into approximately convex pieces, using CoACD; return the corners (n, 3) of each.

    threshold: permitted remaining concavity, relative to the mesh's size. The same seed produces the same pieces.
    Raises ScenarioError if CoACD is not installed.
    """
    try:
        import coacd
    except ImportError as error:
        raise ScenarioError(f"decomposing a mesh: {explained(error)}") from None
    coacd.set_log_level("error")
    pieces = coacd.run_coacd(
        coacd.Mesh(vertices, triangles),
        threshold=threshold,
        max_convex_hull=max_pieces,
        preprocess_mode="off",  # preprocessing repairs open meshes; vehicle hulls are closed
        resolution=1000,
        mcts_nodes=10,
        mcts_iterations=60,
        mcts_max_depth=2,
        seed=seed,
    )
    return [_corners(np.asarray(corners, np.float64), f"piece {k + 1}") for k, (corners, _) in enumerate(pieces)]


def write_pieces(pieces: list[Vertices], path: str | Path, *, made_from: str) -> None:
    """Write the pieces as objects of a single OBJ file, which any modelling program can open."""
    from uwsim.base.whole_trimesh import trimesh

    lines = [f"# convex pieces of {made_from}: uwsim vehicle decompose (CoACD)"]
    first = 1
    for k, corners in enumerate(pieces):
        hull = trimesh.convex.convex_hull(corners)
        lines.append(f"o piece_{k:02d}")
        lines += [f"v {x:.5f} {y:.5f} {z:.5f}" for x, y, z in hull.vertices]
        lines += [f"f {a + first} {b + first} {c + first}" for a, b, c in hull.faces]
        first += len(hull.vertices)
    write_atomically(Path(path), ("\n".join(lines) + "\n").encode())


def _corners(points: Vertices, what: str) -> Vertices:
    try:
        return np.ascontiguousarray(points[np.sort(ConvexHull(points).vertices)])
    except (QhullError, ValueError):
        raise ScenarioError(f"{what}: {len(points)} points in one plane or line enclose no volume") from None
