"""Textbook estimates of a hull's drag from its shape."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from uwsim.base.arrays import Floats
from uwsim.scenario.build.hull import hull_scene

VISCOSITY_M2_S = 1.139e-6
"""Kinematic viscosity of fresh water at 15 degrees C (ITTC 2011, procedure 7.5-02-01-03)."""
ACROSS = 1.1
"""Drag coefficient of a long cylinder across the flow below the drag crisis (Hoerner 1965, ch. III)."""
SIDE_CELLS = 200
FLAT = 0.97
"""Cosine of the angle, 14 degrees, up to which a face across the flow counts as flat (assumed)."""


@dataclass(frozen=True, eq=False)
class HullDrag:
    """Estimates of a hull's quadratic drag: ahead without separation [N s2/m2], and with separation, (6,).

    flat_share: the share of the frontal area where the bow is flat, and the flow therefore separates at its rim.
    """

    streamlined: float
    bluff: Floats
    flat_share: float


def hull_drag(vertices_m: Floats, triangles: NDArray[np.integer], density_kg_m3: float, speed_m_s: float) -> HullDrag:
    """Return the drag of a closed hull of outward-wound triangles about its origin, body frame.

    streamlined: C_D of the wetted surface = C_f (1 + 1.5 (d/l)^1.5 + 7 (d/l)^3) (Hoerner 1965, "Fluid-Dynamic Drag",
    ch. VI), with the friction line 0.075 / (log10 Re - 2)^2 (ITTC 1957); d is the diameter of a disc as large as the
    frontal area. bluff: ACROSS times the silhouette; for turning, strips of the silhouettes in the flow of the rotation
    (the cross-flow principle, Hoerner 1965, ch. III), which overestimates the drag of a hull that is round about the
    axis. Raises ValueError for a hull without a silhouette.
    """
    _, crossed = corners_and_crossed(vertices_m, triangles)
    doubled_m2 = np.linalg.norm(crossed, axis=1)
    shape = [_Silhouette(vertices_m, triangles, axis) for axis in range(3)]
    if not all(side.area_m2 > 0.0 for side in shape):
        raise ValueError("its hull has no silhouette: its parts are too small for how far apart they are")
    length_m, diameter_m = float(np.ptp(vertices_m[:, 0])), float(np.sqrt(4.0 / np.pi * shape[0].area_m2))
    friction = 0.075 / (np.log10(max(speed_m_s, 1e-2) * length_m / VISCOSITY_M2_S) - 2.0) ** 2
    slender = diameter_m / length_m
    wetted_m2 = 0.5 * float(doubled_m2.sum())
    arms = [sum(shape[j].third_moment_m5(i) for i, j in pairs) for pairs in ROTATIONS]
    flat_m2 = 0.5 * float(crossed[crossed[:, 0] > FLAT * doubled_m2, 0].sum())
    return HullDrag(
        0.5 * density_kg_m3 * wetted_m2 * friction * (1.0 + 1.5 * slender**1.5 + 7.0 * slender**3),
        0.5 * density_kg_m3 * ACROSS * np.array([*(side.area_m2 for side in shape), *arms]),
        min(1.0, flat_m2 / shape[0].area_m2),
    )


def corners_and_crossed(vertices_m: Floats, triangles: NDArray[np.integer]) -> tuple[Floats, Floats]:
    """Return the first corner (m, 3) of each triangle, and its outward normal times twice its area."""
    corners = vertices_m[triangles]
    return corners[:, 0], np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])


ROTATIONS = (((1, 2), (2, 1)), ((0, 2), (2, 0)), ((0, 1), (1, 0)))
"""Rotations about x, y, z: a strip at a distance along axis i moves along axis j."""


class _Silhouette:
    """The silhouette of a hull along one of its axes, sampled by parallel rays."""

    def __init__(self, vertices_m: Floats, triangles: NDArray[np.integer], axis: int) -> None:
        self._across = [k for k in range(3) if k != axis]
        low, high = vertices_m.min(axis=0), vertices_m.max(axis=0)
        cell_m = float(max(high[self._across] - low[self._across])) / SIDE_CELLS
        lines = [np.arange(low[k] + 0.5 * cell_m, high[k], cell_m) for k in self._across]
        points = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, 2)
        origins = np.full((len(points), 3), low[axis] - 1.0)
        origins[:, self._across] = points
        hits = hull_scene(vertices_m, triangles).cast(origins, np.tile(np.eye(3)[axis], (len(points), 1)), 1e4)
        self._points_m, self._cell_m2 = points[np.isfinite(hits.ranges_m)], cell_m**2

    @property
    def area_m2(self) -> float:
        return self._cell_m2 * len(self._points_m)

    def third_moment_m5(self, along: int) -> float:
        """Return the integral of |x|^3 over the silhouette, x along an axis from the body's origin."""
        distances_m = np.abs(self._points_m[:, self._across.index(along)])
        return self._cell_m2 * float((distances_m**3).sum())
