"""Added mass of a deeply submerged hull in ideal flow: panels on its mesh, Lamb's formulas for ellipsoids."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.special import elliprd

from uwsim import _core
from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.read.mesh_closing import wrap
from uwsim.scenario.read.mesh_union import volume_within

Floats = NDArray[np.float64]
COARSE, GIVEN_MAX, PANELS, PANELS_EACH = 500, 3000, 3000, 2
"""A mesh of more than COARSE triangles is simplified, since narrow facets of a round hull would use up the panels, and
has then at most GIVEN_MAX. The core splits triangles, most of them near edges, until there are PANELS, or PANELS_EACH
for each if that is more, since a frame has edges everywhere."""
FINEST = 1e-3
"""The least change of a mesh that simplifies it, relative to its size."""
SHIFTS = (1e-5, 1e-3)
"""Shifts of vertices, relative to a mesh's size, that part surfaces which touch, on which panels fail."""
CELLS = 24
MARGIN = 1.05


def added_mass_of_mesh(vertices_m: Floats, triangles: NDArray[np.integer], density_kg_m3: float) -> Floats:
    """Return the added mass (6, 6) of a closed mesh about its origin [kg, kg m, kg m2], see _core.added_mass.

    vertices_m: (n, 3). triangles: (m, 3), wound outward. Raises ScenarioError.
    """
    points_m, faces = simplified(vertices_m, triangles)
    return _by_panels(points_m, faces, density_kg_m3)


def _by_panels(points_m: Floats, faces: NDArray[np.integer], density_kg_m3: float) -> Floats:
    try:
        matrix = _core.added_mass(points_m, faces, density_kg_m3, max(PANELS, PANELS_EACH * len(faces)))
    except ValueError as error:
        raise ScenarioError(f"added mass: {error}") from None
    if not _is_plausible(matrix, points_m, faces, density_kg_m3):
        raise ScenarioError(f"added mass: panels on {len(faces)} triangles have an impossible result")
    return matrix


def _is_plausible(matrix: Floats, points_m: Floats, faces: NDArray[np.integer], density_kg_m3: float) -> bool:
    """Return whether an added mass is positive, and not larger than the ellipsoid around the mesh's box allows.

    A body inside another has at most its sum of added and displaced mass (Schiffer and Szegoe 1949, "Virtual mass and
    polarization"), since the flow around the other, with its inside moved along, is one around the body.
    """
    outer_m = 0.5 * np.sqrt(3.0) * np.ptp(points_m, axis=0)
    moved_kg = added_mass_of_ellipsoid(outer_m, density_kg_m3)[:3] + density_kg_m3 * 4.0 / 3.0 * np.pi * outer_m.prod()
    least = np.linalg.eigvalsh(matrix).min() if np.isfinite(matrix).all() else -np.inf
    along_kg = np.diagonal(matrix)[:3] + density_kg_m3 * volume_within(points_m[faces])
    return bool(least > -1e-6 * np.abs(matrix).max() and (along_kg < MARGIN * moved_kg).all())


def added_mass_by_steps(vertices_m: Floats, triangles: NDArray[np.integer], density_kg_m3: float) -> tuple[Floats, str]:
    """Return the added mass as `added_mass_of_mesh` does, and "", or what was done to a mesh on which panels fail.

    They fail where surfaces touch. Its vertices are shifted by SHIFTS, at random; it is wrapped on a grid of CELLS; and
    at last, Lamb's ellipsoid of its volume and ratios of radii of gyration replaces it.
    """
    for done, points_m, faces in _panelled(vertices_m, triangles):
        try:
            return _by_panels(points_m, faces, density_kg_m3), done and f"panels fail on its mesh, which is {done}"
        except ScenarioError:
            continue
    middle_m, gyration_m = _middle_and_gyration(vertices_m, triangles)
    volume_m3 = volume_within(vertices_m[triangles])
    axes_m = gyration_m * np.cbrt(volume_m3 / (4.0 / 3.0 * np.pi * gyration_m.prod()))
    x, y, z = middle_m
    at_middle = np.eye(6)
    at_middle[:3, 3:] = [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]]
    of_ellipsoid = at_middle.T @ np.diag(added_mass_of_ellipsoid(axes_m, density_kg_m3)) @ at_middle
    return of_ellipsoid, "panels fail on its mesh, which is replaced by Lamb's ellipsoid of its volume"


def _panelled(vertices_m: Floats, triangles: NDArray[np.integer]) -> Iterator[tuple[str, Floats, NDArray[np.integer]]]:
    """Yield the meshes to try, with what was done to each."""
    from uwsim.base.whole_trimesh import trimesh

    size_m = float(np.ptp(vertices_m, axis=0).max())
    for wrapped in ("", f"wrapped, to a {CELLS}th of its size"):
        points_m, faces = vertices_m, triangles
        try:
            if wrapped:
                skin = wrap(trimesh.Trimesh(vertices_m, triangles, process=False), size_m / CELLS).to_mesh64()
                points_m, faces = np.array(skin.vert_properties[:, :3]), np.array(skin.tri_verts, np.int64)
            points_m, faces = simplified(points_m, faces)
        except ValueError:  # no solid
            continue
        yield wrapped, points_m, faces
        for shift in SHIFTS:
            moved_m = shift * size_m * np.random.default_rng(0).uniform(-1.0, 1.0, points_m.shape)
            yield f"{wrapped and wrapped + ' and '}shifted by {shift:g} of its size", points_m + moved_m, faces


def simplified(
    vertices_m: Floats, triangles: NDArray[np.integer], most: int = GIVEN_MAX
) -> tuple[Floats, NDArray[np.integer]]:
    """Return points (n, 3) and at most `most` triangles (m, 3): a solid of the same middle and extent.

    Simplifying cuts corners, so the result is stretched along each axis until its radii of gyration are those given.

    Raises ScenarioError if manifold3d does not accept the mesh.
    """
    if len(triangles) <= COARSE:
        return vertices_m, triangles
    import manifold3d

    copied = manifold3d.Mesh64(np.array(vertices_m, np.float64), np.array(triangles, np.uint64))
    given = manifold3d.Manifold(copied)
    if given.status() != manifold3d.Error.NoError:
        raise ScenarioError(
            f"added mass: a mesh of {len(triangles)} triangles cannot be simplified: {given.status().name}"
        )
    moved_m = FINEST * float(np.ptp(vertices_m, axis=0).max())
    solid = given.simplify(moved_m)
    while solid.num_tri() > most:
        moved_m *= 1.2
        solid = solid.simplify(moved_m)
    mesh = solid.to_mesh64()
    points_m, faces = np.array(mesh.vert_properties[:, :3]), np.array(mesh.tri_verts, np.int64)
    middle_m, wanted_m = _middle_and_gyration(vertices_m, triangles)
    found_m, gyration_m = _middle_and_gyration(points_m, faces)
    return middle_m + wanted_m / gyration_m * (points_m - found_m), faces


def _middle_and_gyration(vertices_m: Floats, triangles: NDArray[np.integer]) -> tuple[Floats, Floats]:
    """Return the centroid of a solid, and the root of its mean square distance from it along each axis, (3,) each."""
    from uwsim.base.whole_trimesh import trimesh

    solid = trimesh.Trimesh(vertices_m, triangles, process=False)
    inertia = np.diagonal(solid.moment_inertia) / solid.volume
    return np.asarray(solid.center_mass), np.sqrt(0.5 * inertia.sum() - inertia)


def added_mass_of_ellipsoid(semi_axes_m: Floats, density_kg_m3: float) -> Floats:
    """Return an ellipsoid's added masses along its axes [kg] and added moments of inertia about them [kg m2], (6,).

    Lamb 1932, "Hydrodynamics", arts. 114 and 115; the integrals alpha_0, beta_0, gamma_0 are Carlson's R_D.
    """
    square = np.asarray(semi_axes_m, np.float64) ** 2
    product = float(np.prod(semi_axes_m))
    mass_kg = density_kg_m3 * 4.0 / 3.0 * np.pi * product
    shape = np.array(
        [2.0 / 3.0 * product * elliprd(square[(k + 1) % 3], square[(k + 2) % 3], square[k]) for k in range(3)]
    )
    moments = []
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        difference, total = square[i] - square[j], square[i] + square[j]
        if abs(difference) <= 1e-9 * total:  # round about this axis, so rotation moves no water
            moments.append(0.0)
            continue
        bend = shape[j] - shape[i]
        moments.append(mass_kg / 5.0 * difference**2 * bend / (2.0 * difference - total * bend))
    return np.concatenate([mass_kg * shape / (2.0 - shape), moments])
