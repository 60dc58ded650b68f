"""The obstacle `pyramid`."""

from __future__ import annotations

from typing import Literal

import numpy as np

from uwsim.scenario.spec.fields import Name, Size
from uwsim.scenario.spec.material import Material, MaterialSpec
from uwsim.scenario.spec.obstacle import Bed, Placed, Solid

CORNERS = np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0], [0, 0, 1]])
TRIANGLES = np.array([[0, 2, 1], [0, 3, 2], [0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]], np.uint32)


class Pyramid(Placed):
    """A pyramid with a square base.

    position_m: the middle of its base (world), unless it is on_bed. width_m, height_m: its dimensions.
    """

    kind: Literal["pyramid"]
    name: Name
    material: MaterialSpec = Material.model_construct(kind="concrete")
    width_m: Size
    height_m: Size

    def solid(self, terrain: Bed) -> Solid:
        """Return the pyramid in the world frame."""
        size_m = 0.5 * self.width_m, 0.5 * self.width_m, self.height_m
        return Solid(CORNERS * size_m + self.position_m, TRIANGLES, [])
