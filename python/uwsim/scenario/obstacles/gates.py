"""Obstacles to pass through: gates and rings."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field, model_validator

from uwsim.scenario.build.solids import SIDES, Mesh, bars, bed_below, posed
from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.read.textures import Texture, palette_texture
from uwsim.scenario.spec.camera import Colour
from uwsim.scenario.spec.fields import Degrees, InRange, Name, Point2, Size, YawPitchRoll, broken
from uwsim.scenario.spec.material import Material, MaterialSpec
from uwsim.scenario.spec.obstacle import LEVEL, Bed, OnBed, Placed, Solid

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


RING_SEGMENTS = 72
"""Segments around a ring; the chords of its axis are 0.1 % of the major radius inside the circle."""
STRIPES = 12
"""Stripes around a ring."""


class Ring(Placed):
    """A torus, such as a gate that hangs in the water; the passage is along its own x.

    position_m: its centre (world), unless it is on_bed. major_radius_m: distance from the centre to the axis of the
    bar.
    minor_radius_m: radius of the bar. stripes: albedos, in alternation, of twelve stripes around the ring; they
    override the material's.
    """

    surface_class: ClassVar = "gate"

    kind: Literal["ring"]
    name: Name
    material: MaterialSpec = Material.model_construct(kind="paint")
    yaw_pitch_roll_deg: YawPitchRoll = LEVEL
    major_radius_m: Size = Field(examples=[1.5])
    minor_radius_m: Size = Field(examples=[0.1])
    stripes: tuple[Colour, Colour] | None = None

    @model_validator(mode="after")
    def _is_open(self) -> Ring:
        if self.minor_radius_m >= self.major_radius_m:
            rule = f"must be below major_radius_m ({self.major_radius_m:g} m)"
            raise broken(rule, at=("minor_radius_m",), value=self.minor_radius_m, unit="m")
        return self

    def solid(self, terrain: Bed) -> Solid:
        """See ObstacleModel."""
        vertices, triangles = torus(self.major_radius_m, self.minor_radius_m)
        return Solid(posed(vertices, self.position_m, self.yaw_pitch_roll_deg), triangles, [])

    def texture(self) -> Texture | None:
        """Return the stripes."""
        if self.stripes is None:
            return None
        each = np.repeat(np.tile(np.array(self.stripes), (STRIPES // 2, 1)), RING_SEGMENTS // STRIPES, axis=0)
        return palette_texture(np.repeat(each, 2 * SIDES, axis=0))


def torus(major_m: float, minor_m: float) -> Mesh:
    """Return a torus about x, one segment after the other."""
    around = np.linspace(0, 2 * np.pi, RING_SEGMENTS, endpoint=False)[:, None]
    along = np.linspace(0, 2 * np.pi, SIDES, endpoint=False)[None, :]
    radius_m = major_m + minor_m * np.cos(along)
    points = [np.broadcast_to(minor_m * np.sin(along), (RING_SEGMENTS, SIDES))]
    points += [radius_m * np.cos(around), radius_m * np.sin(around)]
    a = np.arange(RING_SEGMENTS * SIDES).reshape(RING_SEGMENTS, SIDES)
    b, after, beyond = np.roll(a, -1, axis=1), np.roll(a, -1, axis=0), np.roll(a, (-1, -1), axis=(0, 1))
    triangles = np.stack([a, beyond, b, a, after, beyond], axis=-1).reshape(-1, 3)
    return np.stack(points, axis=-1).reshape(-1, 3), triangles.astype(np.uint32)
