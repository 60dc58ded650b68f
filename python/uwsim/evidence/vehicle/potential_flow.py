"""Added mass of a deeply submerged hull in ideal flow: a panel method for meshes, Lamb's formulas for ellipsoids."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.spatial.distance import cdist
from scipy.special import elliprd

Floats = NDArray[np.float64]
PANELS, PANELS_MAX = 1000, 2500
"""Edges are split to the length that they have in an even mesh of PANELS, so that thin members have enough panels, but
no more than PANELS_MAX; finer meshes are simplified, since they would need minutes."""
FINEST = 3e-4
"""The smallest change of a mesh that simplifies it, relative to its size."""
ROWS_AT_ONCE = 256
WEIGHTS = np.array([[4.0, 1.0, 1.0], [1.0, 4.0, 1.0], [1.0, 1.0, 4.0]]) / 6.0
"""Barycentric coordinates of the points of a triangle whose mean is exact for quadratic functions."""


def added_mass_of_mesh(vertices_m: Floats, triangles: NDArray[np.integer], density_kg_m3: float) -> Floats:
    """Return the added mass (6, 6) of a closed mesh about its origin [kg, kg m, kg m2].

    vertices_m: (n, 3). triangles: (m, 3), wound outward. The potential outside the hull satisfies Green's identity
    2 pi phi + sum int phi d(1/r)/dn dS = -sum S (d phi / dn), where S is a triangle's integral of 1/r, and A_ij = -rho
    int phi_i n_j dS (Newman 1977, "Marine Hydrodynamics", sec. 4.13). The identity holds in the mean over each triangle
    for a potential that is constant on it, and over each vertex's neighbours for one that is linear (Galerkin's
    method). At the edges of a hull the first gives too much and the second too little, so the result is their mean.
    Valid without separation, far from surface and bed.
    """
    points, faces = _panels(vertices_m, triangles)
    corners = points[faces]
    doubled_areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas_m2 = 0.5 * np.linalg.norm(doubled_areas, axis=1)
    kept = areas_m2 > 0.0
    surface = _Surface(corners[kept], doubled_areas[kept] / (2.0 * areas_m2[kept, None]), areas_m2[kept])
    count = len(surface.areas_m2)
    indices = np.arange(count)
    corner_of = [csr_array((np.ones(count), (indices, faces[kept, k])), (count, len(points))) for k in range(3)]
    constant, linear = (np.zeros((size, size)) for size in (count, len(points)))
    right, right_linear = np.zeros((count, 6)), np.zeros((len(points), 6))
    speeds = surface.speeds(surface.corners_m.mean(axis=1))
    for weights in WEIGHTS:
        at_m = np.einsum("k,mki->mi", weights, surface.corners_m)
        for start in range(0, count, ROWS_AT_ONCE):
            rows = slice(start, start + ROWS_AT_ONCE)
            angles, by_corner, integrals_m = surface.influence(at_m[rows], start)
            source = -integrals_m @ speeds
            constant[rows] += angles / len(WEIGHTS)
            right[rows] += source / len(WEIGHTS)
            row = sum((own.T @ part.T).T for own, part in zip(corner_of, by_corner, strict=True))
            row += 2.0 * np.pi * sum(w * own[rows].toarray() for w, own in zip(weights, corner_of, strict=True))
            for w, own in zip(weights, corner_of, strict=True):
                share = (own[rows] * (w * surface.areas_m2[rows, None])).T
                linear += share @ row
                right_linear += share @ source
    constant[indices, indices] = 2.0 * np.pi
    potentials = np.linalg.solve(constant, right)
    matrix = (potentials * surface.areas_m2[:, None]).T @ speeds
    potentials = np.linalg.solve(linear, right_linear)
    for own, spread in zip(corner_of, np.eye(3), strict=True):
        # the mean over a triangle of a corner's hat function times the position is a quarter of the corner away
        mean_m = np.einsum("k,mki->mi", 0.25 + 0.25 * spread, surface.corners_m)
        matrix += (own @ potentials * surface.areas_m2[:, None] / 3.0).T @ surface.speeds(mean_m)
    matrix *= -0.5 * density_kg_m3
    return np.asarray(0.5 * (matrix + matrix.T))


def _panels(vertices_m: Floats, triangles: NDArray[np.integer]) -> tuple[Floats, NDArray[np.integer]]:
    """Return points (n, 3) and triangles (m, 3) of the same hull, refined if they are few, simplified if many."""
    import manifold3d

    mesh = manifold3d.Mesh64(np.array(vertices_m, np.float64), np.array(triangles, np.uint64))  # copies: not read-only
    given = solid = manifold3d.Manifold(mesh)
    if given.status() != manifold3d.Error.NoError:
        return vertices_m, triangles
    length_m = 1.5 * float(np.sqrt(given.surface_area() / PANELS))
    moved_m = FINEST * float(np.ptp(vertices_m, axis=0).max())
    if len(triangles) < PANELS_MAX:
        while (solid := given.refine_to_length(length_m)).num_tri() > PANELS_MAX:
            length_m *= 1.1
    while solid.num_tri() > PANELS_MAX:
        solid, moved_m = solid.simplify(moved_m), 1.2 * moved_m
    out = solid.to_mesh64()
    centre_m, growth = vertices_m.mean(axis=0), np.cbrt(given.volume() / solid.volume())  # simplifying cuts corners
    return centre_m + growth * (out.vert_properties[:, :3] - centre_m), np.array(out.tri_verts, np.int64)


@dataclass(frozen=True, eq=False)
class _Surface:
    """Triangles (m, 3, 3) with their outward normals (m, 3) and areas (m,)."""

    corners_m: Floats
    normals: Floats
    areas_m2: Floats

    def speeds(self, at_m: Floats) -> Floats:
        """Return the normal velocities (m, 6) of the triangles, at points (m, 3), for each unit motion."""
        return np.hstack([self.normals, np.cross(at_m, self.normals)])

    def _along(self, directions: Floats, corner: int, points_m: Floats) -> Floats:
        """Return the distances (n, m) from points to a corner of each triangle, along a direction of each (m, 3)."""
        return np.asarray(np.einsum("mi,mi->m", self.corners_m[:, corner], directions) - points_m @ directions.T)

    def influence(self, points_m: Floats, first: int) -> tuple[Floats, list[Floats], Floats]:
        """Return integrals over the triangles seen from points (n, 3), (n, m) each.

        They are the solid angles (van Oosterom and Strackee 1983), the parts of these that belong to the hat function
        of each of three corners, and the integrals of 1/r [m] (Wilton et al. 1984). first: the triangle in whose plane
        the first point lies; the next point lies in the next one. The gradient of 1/r along the plane becomes an
        integral of 1/r around the rim, so the hat functions need the same logarithms as 1/r.
        """
        lengths = [cdist(points_m, self.corners_m[:, k]) for k in range(3)]
        la, lb, lc = lengths
        edges = [self.corners_m[:, (k + 1) % 3] - self.corners_m[:, k] for k in range(3)]
        edges_m = [np.linalg.norm(edge, axis=1) for edge in edges]
        outward = [np.cross(edge / edge_m[:, None], self.normals) for edge, edge_m in zip(edges, edges_m, strict=True)]
        to_rim_m = [self._along(outward[k], k, points_m) for k in range(3)]
        height_m = self._along(self.normals, 0, points_m)
        dots = [0.5 * (lengths[k] ** 2 + lengths[(k + 1) % 3] ** 2 - edges_m[k] ** 2) for k in range(3)]
        spread = la * lb * lc + dots[0] * lc + dots[1] * la + dots[2] * lb
        angles = 2.0 * np.arctan2(2.0 * self.areas_m2 * height_m, spread)
        own = np.arange(len(points_m))
        angles[own, first + own] = height_m[own, first + own] = 0.0
        totals = [lengths[k] + lengths[(k + 1) % 3] for k in range(3)]
        # ln of (r1 + r2 + edge) / (r1 + r2 - edge), which is Wilton's logarithm without its cancellation
        logs = [np.log((r + e) / np.maximum(r - e, 1e-300)) for r, e in zip(totals, edges_m, strict=True)]
        integrals_m = sum(to_rim_m[k] * logs[k] for k in range(3)) - np.abs(height_m * angles)
        by_corner = []
        for k in range(3):
            facing = (k + 1) % 3  # the edge that does not touch corner k
            steep = edges_m[facing] / (2.0 * self.areas_m2)  # the hat function's slope away from that edge
            along = [-steep * np.einsum("mi,mi->m", outward[facing], outward[j]) for j in range(3)]
            by_corner.append(steep * to_rim_m[facing] * angles - height_m * sum(along[j] * logs[j] for j in range(3)))
        return angles, by_corner, integrals_m


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
