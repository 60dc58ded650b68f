"""The obstacle `box`."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from uwsim.scenario.build.solids import created, posed
from uwsim.scenario.spec.fields import Name, Size, YawPitchRoll
from uwsim.scenario.spec.material import Material, MaterialSpec
from uwsim.scenario.spec.obstacle import LEVEL, Bed, Placed, Solid


class Box(Placed):
    """A cuboid.

    position_m: its centre (world), unless it is on_bed. size_m: edge lengths along its own x, y and z.
    """

    kind: Literal["box"]
    name: Name
    material: MaterialSpec = Material.model_construct(kind="concrete")
    yaw_pitch_roll_deg: YawPitchRoll = LEVEL
    size_m: tuple[Size, Size, Size] = Field(examples=[[2, 2, 2]])

    def solid(self, terrain: Bed) -> Solid:
        """See ObstacleModel."""
        vertices, triangles = created("box", self.size_m)
        return Solid(posed(vertices, self.position_m, self.yaw_pitch_roll_deg), triangles, [])
