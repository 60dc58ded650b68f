"""Perspective view of a box: the rays through pixels, and the pixels at which points appear.

World is ENU in metres; pixel (0, 0) is upper left.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

VIEW_DISTANCE = 2.0  # distance from the box's centre, in box diagonals
MIN_ASPECT, MAX_ASPECT = 0.2, 2.0
MIN_BOX_M = 1.0e-3


@dataclass(frozen=True, eq=False)
class PinholeView:
    """A perspective view through a window in the plane at unit distance from the eye.

    world_from_view: (3, 3), with columns right, up, backward. window: left, right, bottom, top in that plane. width,
    height: in pixels.
    """

    eye_world_m: NDArray[np.float64]
    world_from_view: NDArray[np.float64]
    window: tuple[float, float, float, float]
    width: int
    height: int

    @property
    def pixel_rad(self) -> float:
        """The approximate angle subtended by a pixel."""
        return (self.window[1] - self.window[0]) / self.width

    def rays(self, rows: NDArray[np.int64], scale: int) -> NDArray[np.float64]:
        """Return unit vectors (len(rows) * width * scale, 3) through all pixels in these rows.

        scale: each pixel is divided into scale x scale; rows are then those of the finer image.
        """
        x0, x1, y0, y1 = self.window
        x = x0 + (x1 - x0) * (np.arange(self.width * scale) + 0.5) / (self.width * scale)
        y = y1 - (y1 - y0) * (rows + 0.5) / (self.height * scale)
        right, up, backward = self.world_from_view.T
        directions = x[:, None] * right + (y[:, None] * up - backward)[:, None, :]
        directions /= np.sqrt(1.0 + x * x + (y * y)[:, None])[..., None]
        return np.asarray(directions.reshape(-1, 3), np.float64)

    def project(self, points_world_m: NDArray[np.floating]) -> NDArray[np.float64]:
        """Return pixel coordinates (n, 2), column then row, of points (n, 3); nan for points behind the eye."""
        x0, x1, y0, y1 = self.window
        view = (np.asarray(points_world_m, np.float64) - self.eye_world_m) @ self.world_from_view
        plane = view[:, :2] / np.where(view[:, 2:] < 0.0, -view[:, 2:], np.nan)
        columns = (plane[:, 0] - x0) / (x1 - x0) * self.width
        return np.stack([columns, (y1 - plane[:, 1]) / (y1 - y0) * self.height], axis=1)


def view_of_box(
    low_m: NDArray[np.float64], high_m: NDArray[np.float64], azimuth_rad: float, elevation_rad: float, width: int
) -> PinholeView:
    """Return a view of an axis-aligned box, `width` pixels wide and as high as needed.

    The height is kept between MIN_ASPECT and MAX_ASPECT times the width, so the view of a thin box shows more than the
    box. azimuth_rad: direction from the box's centre to the eye, counterclockwise from east. elevation_rad: angle of
    the eye above the horizon, seen from the centre.
    """
    middle, half = (low_m + high_m) / 2.0, np.maximum((high_m - low_m) / 2.0, MIN_BOX_M / 2.0)
    low_m, high_m = middle - half, middle + half
    level = np.array([np.cos(azimuth_rad), np.sin(azimuth_rad), 0.0])
    backward = np.cos(elevation_rad) * level + np.array([0.0, 0.0, np.sin(elevation_rad)])
    right = np.array([-level[1], level[0], 0.0])
    axes = np.stack([right, np.cross(backward, right), backward], axis=1)
    distance_m = VIEW_DISTANCE * float(np.linalg.norm(high_m - low_m))
    corners = np.stack(np.meshgrid(*np.stack([low_m, high_m], axis=1), indexing="ij"), axis=-1).reshape(-1, 3) - middle
    view = corners @ axes
    plane = view[:, :2] / (distance_m - view[:, 2:])
    margin = 0.02 * np.ptp(plane[:, 0])
    (x0, y0), (x1, y1) = plane.min(axis=0) - margin, plane.max(axis=0) + margin
    wider = max((y1 - y0) / MAX_ASPECT - (x1 - x0), 0.0) / 2.0
    higher = max((x1 - x0) * MIN_ASPECT - (y1 - y0), 0.0) / 2.0
    x0, x1, y0, y1 = x0 - wider, x1 + wider, y0 - higher, y1 + higher
    height = max(round(width * (y1 - y0) / (x1 - x0)), 1)
    return PinholeView(middle + distance_m * backward, axes, (x0, x1, y0, y1), width, height)
