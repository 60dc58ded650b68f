"""A vertical prism that clips a scene: everything outside the prism is cut away."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class ClipPrism:
    """A vertical prism over a convex polygon corners_m (k, 2), open at the top and closed by a floor at z = floor_m."""

    corners_m: NDArray[np.float64]
    floor_m: float

    def span(
        self, origins_m: NDArray[np.float64], directions: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the ranges (n,) at which rays enter and leave the prism; entry > exit for rays that miss.

        origins_m, directions: (n, 3); either may be (3,), shared by all rays.
        """
        count = np.broadcast_shapes(origins_m.shape, directions.shape)[0]
        enter, leave = np.zeros(count), np.full(count, np.inf)
        edges = np.roll(self.corners_m, -1, axis=0) - self.corners_m
        winding = np.sign(_cross2(self.corners_m, np.roll(self.corners_m, -1, axis=0)).sum())
        outward = winding * np.stack([edges[:, 1], -edges[:, 0], np.zeros(len(edges))], axis=1)
        planes = [(n, n[:2] @ corner) for n, corner in zip(outward, self.corners_m, strict=True)]
        planes.append((np.array([0.0, 0.0, -1.0]), -self.floor_m))
        for normal, offset in planes:
            inside = offset - origins_m @ normal
            towards = directions @ normal
            with np.errstate(divide="ignore", invalid="ignore"):
                crossing = inside / towards
            np.fmax(enter, np.where(towards < 0.0, crossing, 0.0), out=enter)
            np.fmin(leave, np.where(towards > 0.0, crossing, np.inf), out=leave)
            leave[np.broadcast_to((towards == 0.0) & (inside < 0.0), leave.shape)] = -np.inf
        return enter, leave


def _cross2(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
