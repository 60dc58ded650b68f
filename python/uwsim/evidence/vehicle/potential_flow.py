"""Added mass of a deeply submerged hull in ideal flow: a panel method for meshes, Lamb's formulas for ellipsoids."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.special import elliprd

Floats = NDArray[np.float64]
PANELS, PANELS_MAX = 700, 4000
"""Coarser meshes are subdivided to about PANELS; finer ones than PANELS_MAX would need gigabytes and minutes."""
ROWS_AT_ONCE = 256


def added_mass_of_mesh(vertices_m: Floats, triangles: NDArray[np.integer], density_kg_m3: float) -> Floats | None:
    """Return the added mass (6, 6) of a closed mesh about its origin [kg, kg m, kg m2]; None above PANELS_MAX panels.

    vertices_m: (n, 3). triangles: (m, 3), wound outward. Green's identity for the potential outside the hull, constant
    on each triangle and collocated at its centroid: 2 pi phi + sum Omega_j phi_j = -sum S_j (d phi / dn)_j, where
    Omega is a triangle's solid angle (van Oosterom and Strackee 1983) and S its integral of 1/r (Wilton et al. 1984);
    A_ij = -rho int phi_i n_j dS (Newman 1977, "Marine Hydrodynamics", sec. 4.13). Valid without separation, far from
    surface and bed.
    """
    corners = _panels(vertices_m, triangles)
    if len(corners) > PANELS_MAX:
        return None
    doubled_areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas_m2 = 0.5 * np.linalg.norm(doubled_areas, axis=1)
    corners, areas_m2 = corners[areas_m2 > 0.0], areas_m2[areas_m2 > 0.0]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / (2.0 * areas_m2[:, None])
    centres = corners.mean(axis=1)
    speeds = np.hstack([normals, np.cross(centres, normals)])  # normal velocity of the surface for each unit motion
    left, right = np.empty((len(corners), len(corners))), np.empty((len(corners), 6))
    for start in range(0, len(corners), ROWS_AT_ONCE):
        rows = slice(start, start + ROWS_AT_ONCE)
        angles, integrals_m = _influence(centres[rows], corners, normals)
        own = np.arange(len(angles))
        angles[own, start + own] = 2.0 * np.pi
        left[rows], right[rows] = angles, -integrals_m @ speeds
    potentials = np.linalg.solve(left, right)
    matrix = -density_kg_m3 * (potentials * areas_m2[:, None]).T @ speeds
    return np.asarray(0.5 * (matrix + matrix.T))


def _panels(vertices_m: Floats, triangles: NDArray[np.integer]) -> Floats:
    """Return the corners (m, 3, 3) of the triangles, subdivided if they are few."""
    from trimesh.remesh import subdivide_to_size

    corners = vertices_m[triangles]
    area_m2 = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum()
    if len(triangles) >= PANELS:
        return np.asarray(corners, np.float64)
    edge_m = 2.0 * float(np.sqrt(area_m2 / PANELS))
    points, faces = subdivide_to_size(  # type: ignore[no-untyped-call]
        vertices_m, triangles, edge_m, max_iter=20
    )
    return np.asarray(points[faces], np.float64)


def _influence(points_m: Floats, corners_m: Floats, normals: Floats) -> tuple[Floats, Floats]:
    """Return the solid angles and the integrals of 1/r [m] of triangles (m, 3, 3) at points (n, 3), (n, m) each."""
    arms = [corners_m[None, :, k] - points_m[:, None] for k in range(3)]
    lengths = [np.linalg.norm(arm, axis=2) for arm in arms]
    a, b, c = arms
    volume = np.einsum("nmi,nmi->nm", a, np.cross(b, c))
    dots = [np.einsum("nmi,nmi->nm", *pair) for pair in ((a, b), (b, c), (c, a))]
    la, lb, lc = lengths
    angles = 2.0 * np.arctan2(volume, la * lb * lc + dots[0] * lc + dots[1] * la + dots[2] * lb)
    height_m = np.einsum("nmi,mi->nm", a, normals)
    integrals_m = -np.abs(height_m * angles)
    for k in range(3):
        edge = corners_m[:, (k + 1) % 3] - corners_m[:, k]
        edge_m = np.linalg.norm(edge, axis=1)
        outward = np.cross(edge / edge_m[:, None], normals)
        total = lengths[k] + lengths[(k + 1) % 3]
        # ln of (r1 + r2 + edge) / (r1 + r2 - edge), which is Wilton's logarithm without its cancellation
        logs = np.log((total + edge_m) / np.maximum(total - edge_m, 1e-300))
        integrals_m += np.einsum("nmi,mi->nm", arms[k], outward) * logs
    return angles, integrals_m


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
