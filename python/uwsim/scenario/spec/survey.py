"""The survey of a scenario, flown by `uwsim survey`."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from uwsim.scenario.spec.fields import InRange, Model, NoseDown, Point2, broken
from uwsim.scenario.spec.polygon import area, crossing_edges, narrowest_width

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
