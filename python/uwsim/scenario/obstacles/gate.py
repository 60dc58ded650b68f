"""The obstacle `gate`, two posts and a crossbar."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field, model_validator

from uwsim.scenario.build.solids import bars, bed_below
from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.spec.fields import Degrees, InRange, Name, Point2, broken
from uwsim.scenario.spec.material import Material, MaterialSpec
from uwsim.scenario.spec.obstacle import Bed, OnBed, Solid

POST_FOOT_M = 0.5
"""Depth of a gate's posts below the bed, which hides their ends on a slope."""


class Gate(OnBed):
    """Two posts and a crossbar that stand on the terrain; the passage is along the gate's x.

    position_m: x and y of its middle. yaw_deg: direction of the gate's x, counter-clockwise from east. width_m:
    distance between the posts' axes. height_m: height of the crossbar's axis above the bed at position_m. bar_radius_m:
    radius of posts and bars. lower_bar_m: height of a second bar; none by default.
    """

    surface_class: ClassVar = "gate"

    kind: Literal["gate"]
    name: Name
    material: MaterialSpec = Material.model_construct(kind="paint")
    position_m: Point2
    yaw_deg: Degrees = 0.0
    width_m: Annotated[float, InRange(0.2, 200, "m")] = Field(examples=[4])
    height_m: Annotated[float, InRange(0.2, 200, "m")] = Field(examples=[3])
    bar_radius_m: Annotated[float, InRange(0.01, 5, "m")] = 0.1
    lower_bar_m: Annotated[float, InRange(0, 200, "m")] | None = None

    @model_validator(mode="after")
    def _is_open(self) -> Gate:
        if 2 * self.bar_radius_m >= min(self.width_m, self.height_m):
            rule = "must be below half of width_m and of height_m"
            raise broken(rule, at=("bar_radius_m",), value=self.bar_radius_m, unit="m")
        if self.lower_bar_m is not None and self.lower_bar_m >= self.height_m:
            rule = f"must be below height_m ({self.height_m:g} m)"
            raise broken(rule, at=("lower_bar_m",), value=self.lower_bar_m, unit="m")
        return self

    def solid(self, terrain: Bed) -> Solid:
        """Return posts, from below the bed, and crossbars; heights are above the bed midway between the posts."""
        yaw = np.radians(self.yaw_deg)
        across = np.array([-np.sin(yaw), np.cos(yaw)])
        middle = np.asarray(self.position_m)
        feet = middle + np.array([[-0.5], [0.5]]) * self.width_m * across
        heights = bed_below(terrain, np.vstack([feet, middle]), self.name)
        top, bottom = heights[2] + self.height_m, heights[:2] - POST_FOOT_M
        if (heights[:2] >= top).any():
            raise ScenarioError(
                f"obstacle '{self.name}': the bed at a post is higher than the crossbar; make height_m larger"
            )
        lines = [(np.array([*foot, low]), np.array([*foot, top])) for foot, low in zip(feet, bottom, strict=True)]
        levels = [top] if self.lower_bar_m is None else [top, heights[2] + self.lower_bar_m]
        lines += [(np.array([*feet[0], z]), np.array([*feet[1], z])) for z in levels]
        return bars(lines, self.bar_radius_m)
