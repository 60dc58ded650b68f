"""The triangles of a hull that are under water, and how the water pushes on each."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from uwsim.base.arrays import Floats
from uwsim.base.short_repr import ShortRepr


@dataclass(frozen=True, eq=False, repr=False)
class WetTriangles(ShortRepr):
    """The part of a hull's surface that is under water, as triangles that wind outward, in body axes.

    corners_body_m: (n, 3, 3), triangle by corner by x, y, z, from the body's origin; triangles at the surface are cut
    at it. forces_body_n: (n, 3), the water's pressure at the centroid times the area, along the inward normal. In still
    water of one density they sum to the weight of the displaced water (Archimedes); in waves, and in layered water,
    they approximate the `buoyancy` of `forces`, which is an integral over the volume.
    """

    corners_body_m: Floats
    forces_body_n: Floats

    def __len__(self) -> int:
        return len(self.forces_body_n)

    @property
    def areas_m2(self) -> Floats:
        """The area of each triangle, (n,)."""
        a, b, c = self.corners_body_m.transpose(1, 0, 2)
        return np.asarray(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1))

    @property
    def area_m2(self) -> float:
        """The wetted area."""
        return float(self.areas_m2.sum())
