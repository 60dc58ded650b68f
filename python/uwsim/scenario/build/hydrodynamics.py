"""Added mass and drag by shape: of hulls in ideal flow, and of loose bodies as they sink or rise.

Added mass of a deeply submerged hull: panels on its mesh, Lamb's formulas for ellipsoids.

The drag coefficient of a ball depends on the Reynolds number: the standard drag curve, by Clift and Gauvin 1971 up to
3.38e5, within 6 % of measurements, and beyond, where the boundary layer of a smooth ball becomes turbulent, by Clift,
Grace and Weber 1978, "Bubbles, Drops, and Particles", table 5.2. Bodies with edges have theirs from 1e4 on (White 2011,
"Fluid Mechanics", 7th ed., table 7.3; Hoerner 1965, "Fluid-Dynamic Drag", ch. 3, for plate and cube), a cylinder across
its axis that of laminar flow. Assumed, without measurements of ours: that this lasts up to 2e5, that smaller bodies
have the same, and that a box has the cylinder's along its axis.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.read.mesh_closing import wrap
from uwsim.scenario.read.mesh_union import volume_within

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
    from scipy.special import elliprd  # not at the top: a scenario without ellipsoids needs no SciPy

    square = np.asarray(semi_axes_m, np.float64) ** 2
    product = float(np.prod(semi_axes_m))
    mass_kg = density_kg_m3 * 4.0 / 3.0 * np.pi * product
    integrals = elliprd(np.roll(square, -1), np.roll(square, -2), square)
    shape = 2.0 / 3.0 * product * integrals
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


GRAVITY_M_S2, VISCOSITY_M2_S = 9.80665, 1.2e-6
"""The kinematic viscosity of water of 13 deg C, fresh or salt within 3 %."""
CRISIS, OVER = 3.38e5, 4e5
NUMBERS = np.geomspace(1e3, 1e7, 2001)
"""Reynolds numbers: balls that hardly sink are taken for the least, as currents and vehicles move them."""
PRISM = {0.0: 1.17, 1.0: 1.05, 2.0: 0.85, 4.0: 0.87, 8.0: 0.99}
"""Drag coefficients of a box by its length along the flow over the root of its area across; a rod has a cylinder's."""
AXIAL = {0.0: 1.17, 0.5: 1.15, 1.0: 0.90, 2.0: 0.85, 4.0: 0.87, 8.0: 0.99}
"""Drag coefficients of a cylinder along its axis, by length over diameter."""
ACROSS = {1.0: 0.64, 2.0: 0.68, 5.0: 0.74, 10.0: 0.82, 20.0: 0.91, 40.0: 0.98, 1000.0: 1.20}
"""Drag coefficients of a cylinder across its axis, by length over diameter."""


def sphere_drag(reynolds: Floats) -> Floats:
    """Return the drag coefficients of smooth spheres, (n,), at Reynolds numbers by the diameter, from 1 to 1e7."""
    w = np.log10(reynolds)
    below = 24.0 / reynolds * (1.0 + 0.15 * reynolds**0.687) + 0.42 / (1.0 + 4.25e4 * reynolds**-1.16)
    beyond = np.where(reynolds < 1e6, 0.1 * w - 0.49, 0.19 - 8e4 / reynolds)
    return np.where(reynolds < CRISIS, below, np.where(reynolds < OVER, 29.78 - 5.3 * w, beyond))


def default_drag(kind: str, sizes_m: Floats, net_kg: float, water_kg_m3: float) -> Floats:
    """Return the drag coefficients of a body along its axes, (3,), by its kind of shape; 1 for a mesh.

    sizes_m (3,): of its bounding box. net_kg: its mass beyond that of the water that it displaces.
    """
    slender = float(sizes_m[2] / sizes_m[0])
    if kind == "sphere":  # from rest, it accelerates to the first speed at which drag carries its weight in water
        drag_n = sphere_drag(NUMBERS) * NUMBERS**2 * math.pi / 8.0 * water_kg_m3 * VISCOSITY_M2_S**2
        settled = np.searchsorted(np.maximum.accumulate(drag_n), GRAVITY_M_S2 * abs(net_kg))
        return np.full(3, sphere_drag(NUMBERS[min(int(settled), len(NUMBERS) - 1)]))
    if kind == "cylinder":
        return np.array([_at(ACROSS, slender), _at(ACROSS, slender), _at(AXIAL, slender)])
    if kind == "box":
        return np.array([_at(PRISM, size**1.5 / math.sqrt(sizes_m.prod())) for size in sizes_m.tolist()])
    return np.ones(3)


def _at(table: dict[float, float], ratio: float) -> float:
    return float(np.interp(ratio, list(table), list(table.values())))
