"""Compares the added mass of ten hulls with the limit that Capytaine's panels approach by refinement.

tests/python/data/make_capytaine_added_mass.py computed the stored results of three meshes of each hull, whose panels
have half the size from one to the next. Those of round hulls have the volume of the smooth one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.base.arrays import Floats
from uwsim.base.axes import AXES
from uwsim.base.texts.json_text import read_json
from uwsim.base.whole_trimesh import trimesh
from uwsim.evidence.validate.check import Check, relative
from uwsim.scenario.build.hydrodynamics import added_mass_of_mesh

Mesh = tuple[Floats, NDArray[np.integer]]
RESULTS = Path(__file__).parent / "capytaine_added_mass.json"
LEVELS = (1, 2, 3)
COMPARED = 2
"""The level of the mesh from which ours is computed."""
ROUND, EDGED = 0.01, 0.016
"""Tolerances. At the edges of a hull, Capytaine's sources are infinite, and equal panels converge so slowly that the
limit is up to 1.5 % low: ours is a lower bound. With panels that thin towards the edges, 4000 give 639.4 kg and 39.19
kg m2 for the cube, and 157.9 kg and 7.15 kg m2 for the cross; ours are 638.3, 39.21, 157.6 and 7.09."""
SHRINKS = 1.5
"""The least factor between two differences from which a limit is computed."""
SMALL = 0.02
"""Added masses and added moments of inertia below this, relative to the hull's largest, are left out: turning a round
hull about its axis moves water only because its panels are flat."""


def _box(size_m: tuple[float, float, float], longest_m: float | None, level: int) -> Mesh:
    return _halved([trimesh.creation.box(size_m)], longest_m, level)


def _cross(level: int) -> Mesh:
    sizes = (1.0, 0.3, 0.3), (0.3, 1.0, 0.3), (0.3, 0.3, 1.0)
    return _halved([trimesh.creation.box(size) for size in sizes], 0.3, level - 1)


def _halved(parts: list[trimesh.Trimesh], longest_m: float | None, times: int) -> Mesh:
    """Return the union of solids, its edges split to a longest one and then halved."""
    import manifold3d

    solid = manifold3d.Manifold()
    for part in parts:
        solid += manifold3d.Manifold(manifold3d.Mesh64(np.array(part.vertices), np.array(part.faces, np.uint64)))
    mesh = (solid if longest_m is None else solid.refine_to_length(longest_m)).to_mesh64()
    vertices, triangles = np.array(mesh.vert_properties[:, :3]), np.array(mesh.tri_verts, np.int64)
    for _ in range(times):
        vertices, triangles = trimesh.remesh.subdivide(vertices, triangles)  # type: ignore[no-untyped-call]
    return vertices, triangles


def _ellipsoid(semi_axes_m: tuple[float, float, float], level: int) -> Mesh:
    ball = trimesh.creation.icosphere(subdivisions=level + 1)
    return ball.vertices * np.cbrt(4.0 / 3.0 * np.pi / ball.volume) * semi_axes_m, ball.faces


def _turned(corners_m: list[tuple[float, float]], parts: list[int], volume_m3: float, level: int) -> Mesh:
    """Return a body of revolution about x. corners_m: (x, radius). parts: intervals between corners at level 0."""
    ends = zip(corners_m, corners_m[1:], parts, strict=False)
    line = [corners_m[0], *(point for a, b, n in ends for point in np.linspace(a, b, n * 2**level + 1)[1:])]
    return _revolved(np.array(line), volume_m3, level)


def _capsule(level: int) -> Mesh:
    angles = np.linspace(0.0, np.pi / 2.0, 2 * 2**level + 1)
    bow = np.stack([0.3 + 0.15 * np.sin(angles), 0.15 * np.cos(angles)], axis=1)
    stern = bow[::-1] * (-1.0, 1.0)
    sides = np.linspace(stern[-1], bow[0], 4 * 2**level + 1)[1:-1]
    return _revolved(np.concatenate([stern, sides, bow]), np.pi * 0.15**2 * (0.6 + 4.0 / 3.0 * 0.15), level)


def _revolved(line_m: Floats, volume_m3: float, level: int) -> Mesh:
    line_m[[0, -1], 1] = 0.0
    solid = trimesh.creation.revolve(line_m[:, ::-1], sections=6 * 2**level)
    solid = trimesh.Trimesh(solid.vertices[:, [2, 0, 1]], solid.faces)
    solid.apply_scale(float(np.cbrt(volume_m3 / solid.volume)))  # type: ignore[no-untyped-call]
    solid.apply_translation(-solid.centroid)
    return np.asarray(solid.vertices), np.asarray(solid.faces)


HULLS: dict[str, Callable[[int], Mesh]] = {
    "sphere": partial(_ellipsoid, (1.0, 1.0, 1.0)),
    "ellipsoid": partial(_ellipsoid, (0.8, 0.2, 0.1)),
    "capsule": _capsule,
    "cylinder": partial(_turned, [(-0.4, 0), (-0.4, 0.2), (0.4, 0.2), (0.4, 0)], [1, 5, 1], np.pi * 0.04 * 0.8),
    "cone": partial(_turned, [(0, 0), (0, 0.3), (0.8, 0)], [2, 5], np.pi * 0.09 * 0.8 / 3.0),
    "cube": lambda level: _box((1.0, 1.0, 1.0), None, level + 1),
    "box": lambda level: _box((1.2, 0.8, 0.7), None, level + 1),
    "slab": lambda level: _box((0.8, 0.6, 0.2), 0.2, level - 1),
    "slender box": lambda level: _box((1.2, 0.3, 0.3), 0.2, level - 1),
    "cross": _cross,
}
"""The mesh of each hull at a level: vertices [m] and triangles."""
WITH_EDGES = ("cube", "box", "slab", "slender box", "cross")


def limit_of(results: Floats) -> Floats:
    """Return the limit of three results (3, n) whose differences shrink by a constant factor (Aitken); NaN for none."""
    first, second = results[1] - results[0], results[2] - results[1]
    return np.where(first / second >= SHRINKS, results[2] + second**2 / (first - second), np.nan)


def checks() -> list[Check]:
    """Return a check of each hull's added masses and of its added moments of inertia: the worst axis of each."""
    kept = read_json(RESULTS)
    return [check for name in HULLS for check in _checks_of(name, kept)]


def _checks_of(name: str, kept: dict[str, Any]) -> Iterator[Check]:
    vertices_m, triangles = HULLS[name](COMPARED)
    theirs = limit_of(np.array(kept["added_mass"][name]))
    ours = np.diagonal(added_mass_of_mesh(vertices_m, triangles, kept["density_kg_m3"]))
    moved_kg = ours[:3].max() * np.square(np.ptp(vertices_m, axis=0).max() / 2.0)
    for axes, unit, least in (
        (range(3), "kg", ours[:3].max()),
        (range(3, 6), "kg m2", max(ours[3:].max(), moved_kg / 100)),
    ):
        known = [k for k in axes if np.isfinite(theirs[k]) and ours[k] > SMALL * least]
        if not known:
            continue
        worst = max(known, key=lambda k: abs(ours[k] / theirs[k] - 1.0))
        quantity = f"{name}, added mass in {AXES[worst]}, limit by refinement"
        tolerance = EDGED if name in WITH_EDGES else ROUND
        yield relative(f"Capytaine {kept['capytaine']}", quantity, theirs[worst], ours[worst], tolerance, unit)
