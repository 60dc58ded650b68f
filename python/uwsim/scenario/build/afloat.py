"""Where a hull floats upright at rest."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from uwsim.scenario.build.hull import rigid_body, vehicle_hull
from uwsim.scenario.spec.vehicle import VehicleModel

BOAT = 0.9
"""The largest share of its hull that a boat's weight submerges; divers' vehicles have 0.97 and more."""
HALVINGS = 50
GRAVITY_M_S2 = 9.80665


def is_boat(model: VehicleModel, density_kg_m3: float) -> bool:
    """Return whether a vehicle floats with much of its hull above water of a density."""
    body = rigid_body(model, density_kg_m3)
    return _mass_kg(model, density_kg_m3) <= BOAT * density_kg_m3 * body.volume_m3


def floating_height_m(model: VehicleModel, density_kg_m3: float) -> float:
    """Return the height of a boat's origin above the surface [m], upright, in water of a density."""
    vertices, triangles = vehicle_hull(model)
    corners_m = np.asarray(vertices, np.float64)[triangles]
    low, high = -float(vertices[:, 2].max()), -float(vertices[:, 2].min())
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        is_low = density_kg_m3 * volume_below_m3(corners_m, -middle) > _mass_kg(model, density_kg_m3)
        low, high = (middle, high) if is_low else (low, middle)
    return high


def volume_below_m3(corners_m: NDArray[np.float64], z_m: float) -> float:
    """Return the volume below a height of a closed hull with outward triangles (m, 3, 3).

    By the divergence theorem, it is minus the integral of depth over the area that faces up; over a triangle, that of
    the positive part of a linear depth has a closed form.
    """
    a, b, c = corners_m[:, 0], corners_m[:, 1], corners_m[:, 2]
    up_m2 = 0.5 * np.cross(b - a, c - a)[:, 2]
    d1, d2, d3 = np.sort(z_m - corners_m[..., 2], axis=1)[:, ::-1].T
    with np.errstate(divide="ignore", invalid="ignore"):  # of the cases that do not apply
        one = d1**3 / (3.0 * (d1 - d2) * (d1 - d3))
        two = (d1 + d2 + d3) / 3.0 - d3**3 / (3.0 * (d1 - d3) * (d2 - d3))
    mean_m = np.select([d3 >= 0.0, d2 >= 0.0, d1 > 0.0], [(d1 + d2 + d3) / 3.0, two, one], 0.0)
    return -float(up_m2 @ mean_m)


def _mass_kg(model: VehicleModel, density_kg_m3: float) -> float:
    """Return the mass with ballast and the weights of trim."""
    body = rigid_body(model, density_kg_m3)
    if model.trim is None:
        return body.mass_kg + model.ballast_kg
    return density_kg_m3 * body.volume_m3 - model.trim.net_buoyancy_n / GRAVITY_M_S2 + model.ballast_kg
