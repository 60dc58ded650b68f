"""Textbook estimates of a hull's added mass and drag from its shape, for comparison with a vehicle's file."""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from uwsim.base.arrays import Floats
from uwsim.exchange.hulls.hull_drag import corners_and_crossed, hull_drag
from uwsim.scenario.build.hydrodynamics import added_mass_by_steps, added_mass_of_ellipsoid


@dataclass(frozen=True, eq=False)
class Estimates:
    """Estimates of a hull's added mass [kg, kg m2] and quadratic drag [N s2/m2, N m s2/rad2], (6,) each.

    lamb: added mass of the ellipsoid with the hull's volume and its ratios of moments of inertia, about its centre.
    mesh: added mass of the mesh in ideal flow, about the body's origin. streamlined: drag ahead, without separation;
    NaN on the other axes. bluff: drag with separation, from the hull's silhouettes. speed_m_s: speed at which the
    friction of `streamlined` is computed.
    """

    lamb: Floats
    mesh: Floats
    streamlined: Floats
    bluff: Floats
    speed_m_s: float


def estimates(
    vertices_m: Floats,
    triangles: NDArray[np.integer],
    gyration_m: tuple[float, float, float],
    density_kg_m3: float,
    speed_m_s: float,
) -> Estimates:
    """Return the estimates for a closed hull of outward-wound triangles, body frame.

    gyration_m: (3,) its radii of gyration as a solid, about its own centre.
    """
    volume_m3 = float(np.einsum("mi,mi->m", *corners_and_crossed(vertices_m, triangles)).sum()) / 6.0
    squares = np.square(gyration_m)
    axes_m = np.sqrt(np.maximum(squares.sum() - 2.0 * squares, 1e-12))
    axes_m *= np.cbrt(volume_m3 / (4.0 / 3.0 * np.pi * np.prod(axes_m)))
    streamlined = np.full(6, np.nan)
    drag = hull_drag(vertices_m, triangles, density_kg_m3, speed_m_s)
    streamlined[0] = drag.streamlined
    by_panels, remedy = added_mass_by_steps(vertices_m, triangles, density_kg_m3)
    if remedy:
        warnings.warn(f"added mass: {remedy}", stacklevel=2)
    return Estimates(
        added_mass_of_ellipsoid(axes_m, density_kg_m3),
        np.diagonal(by_panels).copy(),
        streamlined,
        drag.bluff,
        speed_m_s,
    )
