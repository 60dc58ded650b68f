"""Added mass of a deeply submerged hull in ideal flow: panels on its mesh, Lamb's formulas for ellipsoids."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.special import elliprd

from uwsim import _core
from uwsim.scenario.read.errors import ScenarioError

Floats = NDArray[np.float64]
COARSE, GIVEN_MAX, PANELS, PANELS_EACH = 500, 3000, 3000, 2
"""A mesh of more than COARSE triangles is simplified, since narrow facets of a round hull would use up the panels, and
has then at most GIVEN_MAX. The core splits triangles, most of them near edges, until there are PANELS, or PANELS_EACH
for each if that is more, since a frame has edges everywhere."""
FINEST = 1e-3
"""The least change of a mesh that simplifies it, relative to its size."""


def added_mass_of_mesh(vertices_m: Floats, triangles: NDArray[np.integer], density_kg_m3: float) -> Floats:
    """Return the added mass (6, 6) of a closed mesh about its origin [kg, kg m, kg m2], see _core.added_mass.

    vertices_m: (n, 3). triangles: (m, 3), wound outward. Raises ScenarioError.
    """
    points_m, faces = simplified(vertices_m, triangles)
    try:
        return _core.added_mass(points_m, faces, density_kg_m3, max(PANELS, PANELS_EACH * len(faces)))
    except ValueError as error:
        raise ScenarioError(f"added mass: {error}") from None


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
