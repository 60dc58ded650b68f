"""Drag coefficients of loose bodies by kind of shape, along each axis, as they sink or rise.

A ball's depends on the Reynolds number: the standard drag curve, by Clift and Gauvin 1971 up to 3.38e5, within 6 % of
measurements, and beyond, where the boundary layer of a smooth ball becomes turbulent, by Clift, Grace and Weber 1978,
"Bubbles, Drops, and Particles", table 5.2. Bodies with edges have theirs from 1e4 on (White 2011, "Fluid Mechanics",
7th ed., table 7.3; Hoerner 1965, "Fluid-Dynamic Drag", ch. 3, for plate and cube), a cylinder across its axis that of
laminar flow. Assumed, without measurements of ours: that this lasts up to 2e5, that smaller bodies have the same, and
that a box has the cylinder's along its axis.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
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
