"""The obstacle `ring`, a torus."""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np
from pydantic import Field, model_validator

from uwsim.scenario.build.solids import SIDES, Mesh, posed
from uwsim.scenario.read.textures import Texture, palette_texture
from uwsim.scenario.spec.camera import Colour
from uwsim.scenario.spec.fields import Name, Size, YawPitchRoll, broken
from uwsim.scenario.spec.material import Material, MaterialSpec
from uwsim.scenario.spec.obstacle import LEVEL, Bed, Placed, Solid

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
