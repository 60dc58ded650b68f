"""Generate assets/meshes/otter.obj, a small catamaran; needs manifold3d and trimesh.

Metres; x forward, y left, z up; origin on the waterline amidships. Each pontoon is 2 m long and 0.25 m wide, has a
draught of 0.195 m, a waterplane of 0.75 and a block coefficient of 0.4, as assets/vehicles/otter.yaml has them from its
source; what is above the water (deck, box, mast) is for the eye.
"""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
from manifold3d import Manifold
from solids import box, hull, rod, united, write_obj

ASSETS = Path(__file__).resolve().parents[2] / "assets"
LENGTH_M, BEAM_M, DRAUGHT_M, ABEAM_M = 2.0, 0.25, 0.19512, 0.395
WATERPLANE, BLOCK = 0.75, 0.4
CENTRE_X_M = 0.153125
"""Where its weight is, so that it floats level."""
FREEBOARD_M = 0.16
SECTIONS = 41
GREY, BLACK, ORANGE = (0.40, 0.41, 0.43), (0.02, 0.02, 0.022), (0.75, 0.16, 0.01)
"""Colours of the beams, of case and mast, of the pontoons; linear."""


def outline(x: np.ndarray) -> np.ndarray:
    """Return the share of the half beam at x in [-1, 1]: (1 - |x|^3), whose mean is the waterplane's coefficient."""
    return 1.0 - np.abs(x) ** (WATERPLANE / (1.0 - WATERPLANE))


def section(share: float, full: float) -> list[tuple[float, float]]:
    """Return y and z of a section's right half: wall-sided above the water, a trapezium of fullness `full` below."""
    half = max(0.5 * BEAM_M * share, 1e-3)
    floor = half * (2.0 * full - 1.0)
    return [(half, FREEBOARD_M), (half, 0.0), (max(floor, 5e-4), -DRAUGHT_M)]


def pontoon(side: int) -> Manifold:
    """Return a pontoon, between sections whose fullness is that of the block coefficient."""
    along = np.linspace(-1.0, 1.0, SECTIONS)
    full = BLOCK / WATERPLANE
    parts = []
    for low, high in pairwise(along):
        points = [
            (CENTRE_X_M + 0.5 * LENGTH_M * x, side * ABEAM_M + sign * y, z)
            for x in (low, high)
            for y, z in section(float(outline(np.array(x))), full)
            for sign in (-1, 1)
        ]
        parts.append(hull(points))
    return united(parts)


def main() -> None:
    """Write the mesh."""
    top = FREEBOARD_M
    pontoons = [pontoon(1), pontoon(-1)]
    beams = [box((x - 0.04, -0.46, top - 0.02), (x + 0.04, 0.46, top + 0.04)) for x in (-0.35, 0.65)]
    case = box((-0.35, -0.22, top), (0.6, 0.22, top + 0.16))
    mast = rod((-0.25, 0.0, top + 0.1), (-0.25, 0.0, top + 0.7), 0.02, 8)
    solid = united([*pontoons, *beams, case, mast])
    colours = {GREY: beams, BLACK: [case, mast], ORANGE: pontoons}
    comment = "made by tools/assets/make_otter.py; metres, x forward"
    write_obj(solid, ASSETS / "meshes" / "otter.obj", comment, colours)


if __name__ == "__main__":
    main()
