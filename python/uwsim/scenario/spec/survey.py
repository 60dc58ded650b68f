"""The survey of a scenario, flown by `uwsim survey`, and the geometry of its polygon."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from uwsim.scenario.spec.fields import InRange, Model, NoseDown, Point2, broken

Point = tuple[float, float]


def crossing_edges(corners: Sequence[Point]) -> tuple[int, int] | None:
    """Return two edges that cross, touch or fold back, as indices of their first corners; None for a simple polygon."""
    n = len(corners)
    edges = [(corners[k], corners[(k + 1) % n]) for k in range(n)]
    for i in range(n):
        for j in range(i + 1, n):
            if j == i + 1 or (i == 0 and j == n - 1):
                first, second = (edges[i], edges[j]) if j == i + 1 else (edges[j], edges[i])
                if _folds_back(first[0], first[1], second[1]):
                    return i, j
            elif _meet(*edges[i], *edges[j]):
                return i, j
    return None


def area(corners: Sequence[Point]) -> float:
    """Return the area of a simple polygon, whose corners may be in either order."""
    x, y = np.asarray(corners, np.float64).T
    x, y = x - x[0], y - y[0]  # avoids cancellation far from the origin
    return abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1))) / 2


def narrowest_width(corners: Sequence[Point]) -> float:
    """Return the smallest distance between two parallel lines that enclose the polygon.

    One of the lines runs along an edge of the convex hull (Houle and Toussaint 1988), and so through two corners.
    """
    points = np.asarray(corners, np.float64)
    first, second = np.triu_indices(len(points), 1)
    along = points[second] - points[first]
    along = along[along.any(axis=1)]
    normals = np.column_stack([-along[:, 1], along[:, 0]]) / np.hypot(*along.T)[:, None]
    return float(np.ptp(normals @ (points - points[0]).T, axis=1).min())


def _turn(a: Point, b: Point, c: Point) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _folds_back(a: Point, b: Point, c: Point) -> bool:
    """Return whether the edge from b to c runs back along the edge from a to b, or one of them has no length."""
    along = (b[0] - a[0]) * (c[0] - b[0]) + (b[1] - a[1]) * (c[1] - b[1])
    return a == b or b == c or (_turn(a, b, c) == 0.0 and along < 0.0)


def _meet(a: Point, b: Point, c: Point, d: Point) -> bool:
    t1, t2, t3, t4 = _turn(a, b, c), _turn(a, b, d), _turn(c, d, a), _turn(c, d, b)
    if t1 * t2 < 0 and t3 * t4 < 0:
        return True
    touching = ((t1, a, b, c), (t2, a, b, d), (t3, c, d, a), (t4, c, d, b))
    return any(turn == 0 and _within(p, q, r) for turn, p, q, r in touching)


def _within(p: Point, q: Point, r: Point) -> bool:
    """Return whether r lies in the box spanned by p and q."""
    return all(min(p[k], q[k]) <= r[k] <= max(p[k], q[k]) for k in (0, 1))


MIN_WIDTH_VOXELS, MIN_AREA_VOXELS = 2, 10
"""A smaller survey area would hardly be visible on the map."""

Entry = Literal["north", "north-east", "east", "south-east", "south", "south-west", "west", "north-west"]


class Survey(Model):
    """The scenario's survey.

    area_m: corners (x, y) of the polygon to cover, in order around it. altitude_m: height above the bed.
    line_spacing_m: distance between the lawn-mower's lanes. speed_m_s: speed along the lanes. tilt_deg: tilt of the
    sonar, positive nose down. heading_deg: direction of the lanes, or its opposite, clockwise from the y axis; by
    default, that of the area's longest edge. entry: the side or corner of the area where they begin; by default, near
    the vehicle's start. cross_lines: the number of lanes, evenly spaced, that cross all others at right angles and are
    flown after them. voxel_m: edge of the map's voxels. ping_rate_hz: maximum ping rate of the sonar. outlier_filter:
    whether ranging.reject_uncertain and reject_outliers are used; by default, they are if the sonar is in physics mode.
    max_uncertainty_m: the limit of reject_uncertain, at 95 % confidence; by default half a voxel, so that most of the
    remaining echoes fall into the right voxels. Uncertainties are only known in physics mode, so all multibeams of the
    scenario must then be in it. Both settings apply to every map, live ones too.
    """

    area_m: Annotated[tuple[Point2, ...], Field(min_length=3, max_length=100)]
    altitude_m: Annotated[float, InRange(0.5, 500, "m")]
    line_spacing_m: Annotated[float, InRange(0.5, 500, "m")]
    speed_m_s: Annotated[float, InRange(0.05, 5, "m/s")]
    tilt_deg: NoseDown = 30.0
    heading_deg: Annotated[float, InRange(0, 360, "deg")] | None = None
    entry: Entry | None = None
    cross_lines: Annotated[int, InRange(0, 50)] = 0
    ping_rate_hz: Annotated[float, InRange(0.1, 50, "Hz")] = 10.0
    voxel_m: Annotated[float, InRange(0.02, 10, "m")] = 0.5
    outlier_filter: bool | None = None
    max_uncertainty_m: Annotated[float, InRange(0.001, 100, "m")] | None = None

    @model_validator(mode="after")
    def _limits_only_what_it_filters(self) -> Survey:
        if self.max_uncertainty_m is not None and self.outlier_filter is False:
            raise broken(
                "has no effect if outlier_filter is false",
                at=("max_uncertainty_m",),
                value=self.max_uncertainty_m,
                unit="m",
            )
        return self

    @model_validator(mode="after")
    def _is_a_polygon_of_some_size(self) -> Survey:
        crossing = crossing_edges(self.area_m)
        if crossing is not None:
            raise broken(f"the edges that start at its corners {crossing[0]} and {crossing[1]} meet", at=("area_m",))
        width, least = narrowest_width(self.area_m), MIN_WIDTH_VOXELS * self.voxel_m
        if width < least:
            rule = f"is {width:.3g} m across where it is narrowest: must be at least {MIN_WIDTH_VOXELS} voxels"
            raise broken(f"{rule}, {least:g} m", at=("area_m",))
        size, least = area(self.area_m), MIN_AREA_VOXELS * self.voxel_m**2
        if size < least:
            rule = f"covers {size:.3g} m2: must be at least {MIN_AREA_VOXELS} voxels, {least:g} m2"
            raise broken(rule, at=("area_m",))
        return self
