"""The terrain `slope`: a plane."""

import math
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray

from uwsim.scenario.build.terrain import grid_axes
from uwsim.scenario.spec.fields import InRange, Size
from uwsim.scenario.spec.terrain import TerrainModel


class Slope(TerrainModel):
    """A plane that rises to the north.

    depth_m: its depth at the world's origin. slope_deg: its inclination.
    """

    source: Literal["slope"]
    size_m: tuple[Size, Size]
    depth_m: Annotated[float, InRange(0.1, 1000, "m")]
    slope_deg: Annotated[float, InRange(0, 60, "deg")] = 0.0

    def heights(self) -> NDArray[np.floating]:
        """Return z at the nodes, from south to north."""
        x, y = grid_axes(self.size_m, self.spacing_m)
        return np.repeat(math.tan(math.radians(self.slope_deg)) * y[:, None] - self.depth_m, len(x), axis=1)
