"""The obstacle `cylinder`."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from uwsim.scenario.build.solids import bars, posed
from uwsim.scenario.spec.fields import InRange, Name, Size, YawPitchRoll
from uwsim.scenario.spec.material import Material, MaterialSpec
from uwsim.scenario.spec.obstacle import LEVEL, Bed, Placed, Solid


class Cylinder(Placed):
    """A cylinder along its own z.

    position_m: its centre (world), unless it is on_bed. radius_m, length_m: its dimensions.
    """

    kind: Literal["cylinder"]
    name: Name
    material: MaterialSpec = Material.model_construct(kind="steel")
    yaw_pitch_roll_deg: YawPitchRoll = LEVEL
    radius_m: Annotated[float, InRange(0.002, 10_000, "m")] = Field(examples=[0.5])
    length_m: Size = Field(examples=[2])

    def solid(self, terrain: Bed) -> Solid:
        """See ObstacleModel."""
        ends = np.array([[0.0, 0.0, -0.5], [0.0, 0.0, 0.5]]) * self.length_m
        start, end = posed(ends, self.position_m, self.yaw_pitch_roll_deg)
        return bars([(start, end)], self.radius_m)
