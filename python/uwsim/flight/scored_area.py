"""The area in which a flight's map is scored: a single rule, so that the same map always gets the same score."""

from __future__ import annotations

from contextlib import suppress

import numpy as np
from numpy.typing import NDArray

from uwsim.scoring.polygon import inside_polygon

AREA_MARGIN_M = 5.0
Array = NDArray[np.float64]


def scored_area_m(survey_area_m: Array | None, path_world_m: Array) -> Array | None:
    """Return the polygon (k, 2) in which the map of a flight is scored; None if there is none.

    path_world_m: the positions (n, 3) at which its pings were taken.

    It is the scenario's survey area or, if there is no survey or no ping was taken over its area, the area around the
    sonar positions; see flown_area_m.
    """
    if survey_area_m is not None:
        is_over = not len(path_world_m) or inside_polygon(path_world_m[:, :2], survey_area_m).any()
        if is_over:
            return survey_area_m
    return flown_area_m(path_world_m)


def flown_area_m(path_world_m: Array) -> Array | None:
    """Return the convex hull (k, 2) of positions (n, 3), enlarged by AREA_MARGIN_M; None if there are no positions."""
    if not len(path_world_m):
        return None
    from scipy.spatial import ConvexHull, QhullError  # here, since scipy is slow to import

    angles = np.radians(np.arange(0.0, 360.0, 22.5))
    ring = AREA_MARGIN_M * np.column_stack([np.cos(angles), np.sin(angles)])
    places = np.unique(path_world_m[:, :2].round(2), axis=0)
    with suppress(QhullError, ValueError):  # fewer than three positions, or all collinear
        places = places[ConvexHull(places).vertices]
    around = (places[:, None] + ring).reshape(-1, 2)
    return np.asarray(around[ConvexHull(around).vertices], np.float64)
