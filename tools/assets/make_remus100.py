"""Generate assets/meshes/remus100.obj, a torpedo-shaped AUV; needs manifold3d and trimesh.

Metres; x forward, y left, z up; 1.6 m long, 0.19 m across; origin at the centre of volume. A Myring hull (Myring 1976,
Aeronautical Quarterly 27): elliptic nose, cylinder, pointed tail; four fins and a propeller.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from manifold3d import CrossSection, Manifold
from solids import ball, box, centroid, hull, rod, united, write_obj

ASSETS = Path(__file__).resolve().parents[2] / "assets"
BLACK, YELLOW = (0.015, 0.015, 0.018), (0.72, 0.43, 0.02)
"""Colours of nose, tail and fittings, and of the hull; linear."""
LENGTH_M, DIAMETER_M = 1.6, 0.19
NOSE_M, TAIL_M, TAIL_ANGLE = 0.62, 0.82, np.radians(20)
"""Nose and tail lengths for which the hull's volume is close to that of the spheroid in the vehicle's file."""


def radius_m(from_nose_m: float) -> float:
    """Return the hull's radius by Myring's equations, with nose exponent 2."""
    half, middle = DIAMETER_M / 2, LENGTH_M - NOSE_M - TAIL_M
    if from_nose_m < NOSE_M:
        return half * float(np.sqrt(1 - ((from_nose_m - NOSE_M) / NOSE_M) ** 2))
    s = from_nose_m - NOSE_M - middle
    if s <= 0:
        return half
    square = 3 * half / TAIL_M**2 - np.tan(TAIL_ANGLE) / TAIL_M
    cube = 2 * half / TAIL_M**3 - np.tan(TAIL_ANGLE) / TAIL_M**2
    return float(half - square * s**2 + cube * s**3)


def body() -> Manifold:
    """Return the profile revolved about the axis; the tail is cut off where the propeller shaft emerges."""
    nose = NOSE_M * (1 - np.cos(np.linspace(0, np.pi / 2, 9)))
    stations = [*nose, *np.linspace(LENGTH_M - TAIL_M, LENGTH_M - 0.03, 11)]
    outline = [(0.0, -stations[0]), *((radius_m(x), -x) for x in stations[1:]), (0.0, -stations[-1])]
    turned = Manifold.revolve(CrossSection([outline[::-1]]), circular_segments=24)
    return turned.rotate((0, 90, 0)).translate((LENGTH_M / 2, 0, 0))


def fin(turn_deg: float) -> Manifold:
    """Return a swept fin of 0.00665 m2 (Prestero 2001) on the tail, its tip 0.15 m from the axis, rotated about x."""
    root, tip = 0.03, 0.15
    outline = [(-0.655, root), (-0.74, root), (-0.735, tip), (-0.69, tip)]
    points = [(x, side * half, z) for x, z in outline for side, half in ((-1, 0.002), (1, 0.002))]
    points += [(-0.69, side * 0.005, root) for side in (-1, 1)] + [(-0.705, side * 0.003, tip) for side in (-1, 1)]
    return hull(points).rotate((turn_deg, 0, 0))


def propeller() -> list[Manifold]:
    """Return the hub and three blades, 0.14 m across."""
    parts = [rod((-0.79, 0, 0), (-0.75, 0, 0), 0.016, 10), ball((-0.79, 0, 0), 0.0155, 10)]
    for turn in (0, 120, 240):
        blade = box((-0.0015, -0.018, 0.01), (0.0015, 0.018, 0.07)).rotate((0, 0, 40))
        parts.append(blade.translate((-0.775, 0, 0)).rotate((turn, 0, 0)))
    return parts


def fittings() -> list[Manifold]:
    """Return the antenna mast and the acoustic transducer below the nose."""
    mast = hull(
        [(x, y, z) for x, z in ((0.11, 0.08), (0.05, 0.08), (0.075, 0.17), (0.055, 0.17)) for y in (-0.006, 0.006)]
    )
    return [mast, rod((0.5, 0, -0.11), (0.5, 0, -0.06), 0.025, 10)]


def main() -> None:
    """Write the mesh."""
    whole = body()
    black = [*(fin(turn) for turn in (0, 90, 180, 270)), *propeller(), *fittings()]
    comment = "made by tools/assets/make_remus100.py; metres, x forward, z up"
    solid = united([whole, *black])
    shift = tuple(-each for each in centroid(solid))
    ends = [whole ^ box((low, -1, -1), (low + 1, 1, 1)) for low in (0.55, -1.6)]
    colours = {BLACK: [*black, *ends], YELLOW: [whole]}
    placed = {colour: [part.translate(shift) for part in parts] for colour, parts in colours.items()}
    write_obj(solid.translate(shift), ASSETS / "meshes" / "remus100.obj", comment, placed)


if __name__ == "__main__":
    main()
